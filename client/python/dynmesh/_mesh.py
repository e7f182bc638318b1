"""A mesh in process or at a server, kept up to date, and the fields on it."""
from __future__ import annotations

import threading
from collections.abc import AsyncIterator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Optional, Protocol, Union

import numpy as np

from dynmesh import _batch, _core
from dynmesh._types import Array, Label
from dynmesh._diff import Diff
from dynmesh._fields import Fields
from dynmesh._join import apply_joined
from dynmesh._part import Ids, IdsOrNames, Part
from dynmesh._write import Writable
from dynmesh.errors import FailedPrecondition

if TYPE_CHECKING:
    import meshio

Progress = Callable[[str, int, int], None]


class Backend(Protocol):
    """The host of a mesh: this process, or a server. Called with the mesh's lock of edits held."""

    name: str
    is_local: bool  #: Edits advance the mesh's replica: their diffs are not to be applied to it.

    def apply(self, mesh: Mesh, batch: Any, *, validate_only: bool,
              progress: Optional[Progress], request_id: Optional[str],
              expected_revision: Optional[int]) -> list[Any]:
        """Makes the next revision; returns the diffs from the mesh's revision to it."""

    def load(self, mesh: Mesh, batch: Any, progress: Optional[Progress]) -> list[Any]: ...

    def revert(self, mesh: Mesh, revision: int) -> list[Any]: ...

    def features(self, mesh: Mesh, revision: Optional[int]) -> list[dict[str, Any]]: ...

    def locate(self, mesh: Mesh, points: Array) -> Array: ...

    def stream(self, mesh: Mesh, batches: Iterable[Any], window: int) -> Iterator[Diff]:
        """Applies batches one by one, without the lock between them."""

    def follow(self, mesh: Mesh, timeout: Optional[float]) -> Iterator[Any]:
        """Yields what happened, for `continue_with`; without the lock."""

    def continue_with(self, mesh: Mesh, event: Any) -> list[Any]:
        """The diffs from the mesh's revision to that of `event`; none if it is there already."""

    def sync(self, mesh: Mesh) -> list[Any]: ...


@dataclass(frozen=True)
class CompactMesh:
    """A numbering without gaps, by ascending slot, for matrices."""

    points: Array  #: Coordinates, one row per vertex.
    cells: Array  #: Numbers of the corners, one row per cell.
    regions: Array  #: The region of each cell.
    vertex_slots: Array  #: The slots of vertices 0, 1, ...
    vertex_numbers: Array  #: The vertex number of each slot; -1 if the slot is free.
    cell_slots: Array  #: The slots of cells 0, 1, ...
    cell_numbers: Array  #: The cell number of each slot; -1 if the slot is free.


class Mesh(Writable):
    """A mesh as numpy arrays with stable slots. Made by `Server.mesh` or `dynmesh.open`.

    Arrays are read-only and never change: get them again after an edit. That takes time for the
    rows that have changed, the first time for all. Vertices: `points`, `ids` (0: the slot is free),
    `owners` (the feature that a vertex lies on), `containing_dimensions`. Cells: `cells` (slots of
    corners, -1: free), `neighbours` (the cell opposite to each corner, -1 at the border),
    `regions`.

    Thread-safe. Edits of several threads are applied one after another. A reader sees the revision
    before an edit or that after it; `locate` and `features` wait for an edit that is under way.
    What has to be of one revision is read under `with mesh.locked():`, which excludes edits of
    other threads. From a `progress` callback of an edit the mesh before the edit can be read; what needs
    the mesher (edits, `locate`, `features`) raises `FailedPrecondition` there.
    """

    def __init__(self, backend: Backend, replica: Any, options: dict[str, Any]) -> None:
        self._backend = backend
        self._replica = replica
        self._options = options
        self._current: Optional[Diff] = None
        # Of edits, taken first; of what follows from one: `_current` and fields. Threads wait for
        # both without the GIL.
        self._edits = threading.RLock()
        self._lock = threading.RLock()
        self._is_editing = False
        #: Fields that every edit transfers to the new mesh.
        self.fields: Fields = Fields(self, self._lock)

    def __repr__(self) -> str:
        return (f"<Mesh of {self.dimension} dimensions at revision {self.revision}: "
                f"{self.vertex_count} vertices, {self.cell_count} cells>")

    @contextmanager
    def locked(self) -> Iterator[Mesh]:
        """For a `with` block in which only this thread edits the mesh; yields the mesh.

        Waits for an edit that is under way. Arrays, fields and everything else read in the block
        are of one revision, as long as the block does not edit the mesh. Blocks may be nested.
        Other threads can read meanwhile.
        """
        with self._edits:
            yield self

    @property
    def name(self) -> str:
        """The mesh's name at its server; empty for a mesh in process."""
        return self._backend.name

    @property
    def options(self) -> dict[str, Any]:
        """The mesh's options: dimension, box, kind and those of `dynmesh.open`."""
        return dict(self._options)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self._replica.dimension)

    @property
    def revision(self) -> int:
        """The revision of this replica; each batch makes the next one."""
        return int(self._replica.revision)

    @property
    def hash(self) -> str:
        """The hash of this replica: 32 hexadecimal digits, compared with each diff's."""
        return str(self._replica.hash)

    @property
    def vertex_count(self) -> int:
        """Number of vertices, including those of the domain's border."""
        return int(self._replica.vertex_count)

    @property
    def cell_count(self) -> int:
        """Number of triangles, in 3D of tetrahedra."""
        return int(self._replica.cell_count)

    @property
    def vertex_slots(self) -> int:
        """Number of rows of vertex arrays, including free ones."""
        return int(self._replica.vertex_slots)

    @property
    def cell_slots(self) -> int:
        """Number of rows of cell arrays, including free ones."""
        return int(self._replica.cell_slots)

    @property
    def points(self) -> Array:
        """Coordinates by vertex slot: (slots, dimension), float64."""
        return self._replica.points

    @property
    def ids(self) -> Array:
        """Ids by vertex slot, 0 if it is free: uint64. An id is a hash of the coordinates."""
        return self._replica.ids

    @property
    def owners(self) -> Array:
        """The feature that each vertex lies on, by slot: uint64, 0 for none."""
        return self._replica.owners

    @property
    def containing_dimensions(self) -> Array:
        """By vertex slot: 0 for an input point, 1 on a segment, 2 on a facet, else free: uint8."""
        return self._replica.containing_dimensions

    @property
    def cells(self) -> Array:
        """Slots of the corners by cell slot: (slots, dimension + 1), int32; -1: free."""
        return self._replica.cells

    @property
    def neighbours(self) -> Array:
        """The cell opposite to each corner: (slots, dimension + 1), int32; -1 at the border."""
        return self._replica.neighbours

    @property
    def regions(self) -> Array:
        """The polygon around each cell, by cell slot: uint64, 0 for none.

        From 2^63 up it is a set of several polygons: see `region_sets`.
        """
        return self._replica.regions

    @property
    def region_sets(self) -> dict[int, tuple[int, ...]]:
        """The polygons of each region that is a set of several."""
        return self._replica.region_sets

    @property
    def subsegments(self) -> Array:
        """Subsegments: slots of their ends, -1 if a row is free."""
        return self._replica.subsegments

    @property
    def subsegment_owners(self) -> Array:
        """The feature of each row of `subsegments`: uint64."""
        return self._replica.subsegment_owners

    @property
    def subfacets(self) -> Array:
        """In 3D, subfacets: slots of their corners, -1 if a row is free."""
        return self._replica.subfacets

    @property
    def subfacet_owners(self) -> Array:
        """The polygon of each row of `subfacets`: uint64."""
        return self._replica.subfacet_owners

    @property
    def labels(self) -> dict[int, Label]:
        """The label of each feature that has one, by id. O(labels)."""
        return {id_: Label(marker, name) for id_, marker, name in self._replica.labels}

    @property
    def live_vertices(self) -> Array:
        """Mask of the vertex slots in use. O(mesh)."""
        return self.ids != 0

    @property
    def live_cells(self) -> Array:
        """Mask of the cell slots in use. O(mesh)."""
        return self.cells[:, 0] >= 0

    def find(self, ids: Any) -> Array:
        """Slots of the vertices with these `ids`; -1 for unknown ids."""
        return self._replica.find(np.atleast_1d(np.asarray(ids, dtype=np.uint64)))

    def compact(self) -> CompactMesh:
        """A copy without free rows, and the mapping of rows. O(mesh)."""
        return CompactMesh(**self._replica.compact())

    def part(self, *, polygons: Ids = (), names: Union[str, Iterable[str]] = (),
             inside: bool = False, without: Ids = (), open: IdsOrNames = ()) -> Part:
        """The part of the mesh in chosen polygons: the domain of a simulation. O(mesh).

        It follows the mesh by `Part.update`. **The whole mesh is larger than its features**: it is
        that of a square (in 3D a cube) which reaches about six times (in 3D eight times) as far as
        the box, so that the features stay what shapes the mesh.

        Args:
            polygons: ids of polygons. In 3D a polygon stands for the closed surface that has its id,
                as in `regions`.
            names: names of labels: the polygons that have one of them.
            inside: all polygons that there are; so it is if neither ids nor names are given.
            without: ids of polygons that are left out, as holes.
            open: ids or names of segments and polygons, as cracks, along which the part is opened:
                vertices there have a copy for each side (`Part.origin`). Tips stay closed, in 3D the
                front of a crack; kinks, branches and mouths at the border open. In 2D edges of a
                polygon are opened, in 3D the polygon.

        Raises `NotFound` for a name that no feature has.
        """
        everything = not names and isinstance(polygons, Iterable) and not list(polygons)
        return Part(self, polygons, names, inside or everything, without, open)

    def apply(self, *, validate_only: bool = False, progress: Optional[Progress] = None,
              request_id: Optional[str] = None, expected_revision: Optional[int] = None,
              join: bool = False, **edits: Any) -> Diff:
        """Applies a batch of edits atomically: makes the next revision.

        A batch that is refused makes none. After `Unavailable` or a timeout it is unknown whether
        a server has applied it: repeat it with the same `request_id`, which applies it once.

        Args:
            edits: applied in their order. `add_points`, `set_points`, `move_points`: a dict of id
                to coordinates, or (ids, array of coordinates). `add_segments`, `set_segments`: a
                dict of id to two ids of points. `add_polygons`, `set_polygons`: a dict of id to a
                ring of ids of points, or to a list of rings. `add_sizes`, `set_sizes`: a dict of id
                to dict(target=, at=), dict(target=, at=, radius=), dict(target=, low=, high=),
                dict(target=, rings=) or, for a capsule, dict(target=, path=, radius=) with the
                positions of two or more vertices. `remove`: ids. `set_labels`: a dict of id to
                `Label` or dict(marker=, name=), of features present or added before it; None or an
                empty one takes the label away. Features keep their labels when they are moved or
                set. `unsplit`: True, or the ids of those segments and polygons, of the ones that
                the batch adds or sets, that are to stay whole: the mesh puts no vertex on them
                (2D; "Borders that stay whole" in docs/input.md). `points_along` gives a curve its
                points at a spacing.
            validate_only: checks whether the edits are legal, and changes nothing.
            progress: called during long batches in process with the stage, the steps done and the
                total (0: unknown). An exception from it cancels the batch.
            request_id: makes it safe to send the batch twice; unique by default.
            expected_revision: the server refuses the batch at any other revision.
            join: a point that lies on an edge of a polygon, as the mouth of a crack, becomes a
                corner of it, and one that is removed leaves it, if the polygon is straight there.
                Without it such batches are refused. O(features) where a polygon changes.

        Returns:
            All changes since the previous revision of this replica, including edits of other
            clients of a server's mesh.
        """
        def apply(given: Mapping[str, Any], expected: Optional[int]) -> Diff:
            batch = _batch.make(self.dimension, given)
            return self._edit(lambda: self._backend.apply(
                self, batch, validate_only=validate_only, progress=progress, request_id=request_id,
                expected_revision=expected))

        if not join:
            return apply(edits, expected_revision)
        with self.locked():
            # Corners are put into the rings of this revision, and of no other.
            return apply_joined(edits, self.features, lambda given: apply(
                given, expected_revision if given is edits else self.revision))

    def load(self, *, progress: Optional[Progress] = None, **edits: Any) -> Diff:
        """Adds any number of features in one batch.

        `edits` (only those that add, and `set_labels` and `unsplit` of what they add) and
        `progress` are as in `apply`.
        """
        for name in edits:
            if not name.startswith("add_") and name not in ("set_labels", "unsplit"):
                raise TypeError(f"a load adds features: there is no {name}")
        batch = _batch.make(self.dimension, edits)
        return self._edit(lambda: self._backend.load(self, batch, progress))

    def stream(self, batches: Iterable[Mapping[str, Any]], window: int = 64) -> Iterator[Diff]:
        """Applies many batches, each a dict of edits as in `apply`; yields their diffs in order.

        With a server, up to `window` batches are sent ahead. Transfer fields before taking the next
        diff. A refused batch raises; the earlier batches stay applied.
        """
        made = (_batch.make(self.dimension, batch) for batch in batches)
        yield from self._backend.stream(self, made, window)

    def revert(self, revision: int) -> Diff:
        """Makes a new revision with the features of an earlier `revision`. Needs a server."""
        return self._edit(lambda: self._backend.revert(self, revision))

    def follow(self, since: Optional[int] = None, timeout: Optional[float] = None) -> Iterator[Diff]:
        """Yields the diff of each new revision; the mesh is at that revision then.

        Ends after `timeout` seconds without a new revision. `since`, if given, must be the mesh's
        revision. If the server no longer has the revisions since then, or was replaced by another
        server, the diff leads to the server's present mesh.
        """
        if since is not None and since != self.revision:
            raise FailedPrecondition(f"the mesh here is at revision {self.revision}: it can be "
                                     "followed from there only")
        for event in self._backend.follow(self, timeout):
            diff = self._follow_to(event)
            if diff is not None:
                yield diff

    async def follow_async(self, timeout: Optional[float] = None) -> AsyncIterator[Diff]:
        """`follow` with its `timeout` for asyncio; waits in a thread."""
        import asyncio  # a third of the time that an import of the package takes

        events = self._backend.follow(self, timeout)
        try:
            while True:
                event = await asyncio.to_thread(lambda: next(events, None))
                if event is None:
                    return
                diff = self._follow_to(event)
                if diff is not None:
                    yield diff
        finally:
            events.close()  # type: ignore[attr-defined]

    def sync(self) -> Diff:
        """Advances to the newest revision in one diff."""
        return self._edit(lambda: self._backend.sync(self))

    def features(self, revision: Optional[int] = None) -> list[dict[str, Any]]:
        """The present features, or those of an earlier `revision` that the server keeps.

        A dict for each: `id`, `kind` ("point", "segment", "polygon", "size") and, by kind, `at`,
        `ends`, `rings`, or the members of a size; with a label, `marker` and `name`.
        """
        return self._backend.features(self, revision)

    def locate(self, points: Any) -> Array:
        """The slot of a cell around each of n `points` (n x dimension); -1: outside."""
        places = np.ascontiguousarray(np.atleast_2d(np.asarray(points, dtype=np.float64)))
        if places.ndim != 2 or places.shape[1] != self.dimension:
            raise ValueError(f"points: places have {self.dimension} coordinates, one row for each "
                             f"place, and got an array of shape {np.shape(points)}")
        if not np.isfinite(places).all():
            raise ValueError("points: places have finite coordinates, and row "
                             f"{np.flatnonzero(~np.isfinite(places).all(axis=1))[0]} has not")
        with self._edits:
            return self._backend.locate(self, places)

    def _write(self, path: str, choices: dict[str, Any]) -> None:
        self._replica.write(self._options, path, choices)

    def to_meshio(self, point_data: Optional[Mapping[str, Array]] = None,
                  cell_data: Optional[Mapping[str, Array]] = None) -> meshio.Mesh:
        """The mesh for meshio; regions are cell data.

        Args:
            point_data: arrays with one row per vertex slot, by name.
            cell_data: arrays with one row per cell slot, by name.
        """
        import meshio

        compact = self.compact()
        points = compact.points
        if self.dimension == 2:
            points = np.column_stack([points, np.zeros(len(points))])
        name = "triangle" if self.dimension == 2 else "tetra"

        def rows(what: str, data: Optional[Mapping[str, Array]], slots: Array, count: int,
                 of: str) -> Iterator[tuple[str, Array]]:
            for key, values in (data or {}).items():
                array = np.asarray(values)
                if array.ndim == 0 or len(array) != count:
                    came = "a single number" if array.ndim == 0 else f"{len(array)} rows"
                    hint = (": that is the number of rows of mesh.compact(), which may be brought to "
                            f"slots by u[compact.{of}_slots] = values"
                            if array.ndim and len(array) == len(slots) else "")
                    raise ValueError(f"{what}[{key!r}]: it has a row for each {of} slot, {count} "
                                     f"rows (mesh.{of}_slots), and got {came}{hint}")
                yield key, array[slots]

        at_points = dict(rows("point_data", point_data, compact.vertex_slots,
                              len(compact.vertex_numbers), "vertex"))
        of_cells = dict(rows("cell_data", cell_data, compact.cell_slots,
                             len(compact.cell_numbers), "cell"))
        return meshio.Mesh(
            points, [(name, compact.cells)], point_data=at_points,
            cell_data={key: [values] for key, values in
                       {"region": compact.regions, **of_cells}.items()})

    def _edit(self, diffs_of: Callable[[], list[Any]]) -> Diff:
        """Makes and applies diffs, alone among all threads."""
        with self._edits:
            if self._is_editing:
                raise FailedPrecondition(
                    "this edit of the mesh was called from a callback of another edit of it, which "
                    "has not ended: apply it when that edit has returned")
            slots = self.vertex_slots, self.cell_slots
            self._is_editing = True
            try:
                return self._advance(diffs_of(), slots)
            finally:
                self._is_editing = False

    def _follow_to(self, event: Any) -> Optional[Diff]:
        """Advances to what `follow` has got; None if another thread has done so."""
        diff = self._edit(lambda: self._backend.continue_with(self, event))
        return diff if diff._parts else None

    def _advance(self, parts: list[Any], slots: tuple[int, int]) -> Diff:
        parts = [part for part in parts if part.from_revision != part.to_revision]
        with self._lock:
            self._current = None
            if not self._backend.is_local:
                for index, part in enumerate(parts):
                    self._replica.apply(part, extends=index > 0)
            diff = Diff(self, parts, slots)
            self._current = diff
            if len(self.fields) > 0 and parts:
                self.fields._advance(diff)
        return diff
