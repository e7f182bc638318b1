"""The part of a mesh in chosen polygons: the domain of a simulation."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from dynmesh import _batch, _core
from dynmesh._copies import set_at_vertices
from dynmesh._diff import Diff
from dynmesh._meshio import to_meshio
from dynmesh._rows import check_values, is_at_vertices
from dynmesh._state import MeshState
from dynmesh._types import Array, Label
from dynmesh._write import Writable
from dynmesh.errors import InvalidArgument, NotFound, StaleDiff

if TYPE_CHECKING:
    import meshio

Ids = Union[int, Iterable[int]]
IdsOrNames = Union[int, str, Iterable[Union[int, str]]]


def _ids(what: str, ids: Ids) -> list[int]:
    entries = [ids] if isinstance(ids, (int, np.integer)) else ids
    if isinstance(entries, (str, bytes)) or not isinstance(entries, Iterable):
        raise InvalidArgument(f"{what}: ids of polygons are integers, as {what}=[7, 9]; got {ids!r}")
    entries = list(entries)
    for entry in entries:
        if not isinstance(entry, (int, np.integer)):
            raise InvalidArgument(f"{what}: ids are integers, as {what}=[7, 9]; got {entry!r}")
    return [int(id_) for id_ in entries]


def _ids_and_names(what: str, given: IdsOrNames) -> tuple[list[int], list[str]]:
    entries = list(given) if isinstance(given, Iterable) and not isinstance(given, str) else [given]
    names = [entry for entry in entries if isinstance(entry, str)]
    return _ids(what, [entry for entry in entries if not isinstance(entry, str)]), names


@dataclass(frozen=True)
class _Former:
    """A part before a diff, for the values on it."""

    diff: Diff
    vertices: int
    cells: Array
    cell_slots: Array
    cell_numbers: Array


class Part(Writable):
    """The part of a mesh that lies in chosen polygons. Made by `Mesh.part`.

    Vertices, cells and facets have numbers without gaps. Arrays are read-only and never change: get
    them again after `update`, which takes time for the rows that have changed. An update keeps
    the numbers of what stays, except that the last ones fill the gaps.

    Facets are edges, in 3D triangles: the part's border, and segments (in 3D polygons) in it.
    Values by slot, as those of `mesh.fields`, are brought to the part by `values[part.vertex_slots]`
    or `values[part.cell_slots]`.

    A part with `open` features, as cracks, has a copy of a vertex for each side, and a facet:
    `origin` tells which are one vertex of the mesh, `facet_twins` and `facet_sides` tell the sides.
    A crack without a vertex between its tips stays closed. Values of such a part are carried by `Part.transfer`.

    Thread-safe. What has to be of one revision is read under `with mesh.locked():`.
    """

    def __init__(self, mesh: MeshState, polygons: Ids, names: Union[str, Iterable[str]], inside: bool,
                 without: Ids, open: IdsOrNames) -> None:
        #: The whole mesh.
        self.mesh: MeshState = mesh
        self._choice = (_ids("polygons", polygons),
                        [names] if isinstance(names, str) else list(names), inside,
                        _ids("without", without), *_ids_and_names("open", open))
        self._former: Optional[_Former] = None
        self._labels: Optional[tuple[int, dict[int, Label]]] = None
        present = {label.name for label in mesh.labels.values() if label.name}
        for name in self._choice[1] + self._choice[5]:
            if name not in present:
                there = ", ".join(sorted(present)) or "none"
                raise NotFound(f"no feature has the name {name!r}; names are: {there}")
        self._part = _core.Part(mesh._replica, *self._choice)

    def __repr__(self) -> str:
        return (f"<Part of {self.mesh.dimension} dimensions at revision {self.revision}: "
                f"{len(self.vertex_slots)} vertices, {len(self.cell_slots)} cells, "
                f"{len(self.facet_owners)} facets>")

    def update(self, diff: Optional[Diff] = None) -> None:
        """Follows the mesh. Expected time: that of the diff.

        Without a `diff`, or if the part is not at the revision that it begins at, the part is made
        anew, with other numbers: O(mesh). Raises `StaleDiff` if the mesh has left the revision that
        the diff leads to. If other threads edit the mesh, hold `Mesh.locked` from the edit on.
        """
        if diff is not None and diff.to_revision == self.revision:
            return
        self._former = None
        if diff is None or diff.from_revision != self.revision:
            self._part = _core.Part(self.mesh._replica, *self._choice)
            return
        if diff._mesh is not self.mesh:
            raise InvalidArgument("the diff is of another mesh")
        if diff.to_revision != self.mesh.revision:
            raise StaleDiff(f"the mesh has left revision {diff.to_revision}: update the part before "
                            "the next edit is applied, or without a diff")
        self._part.update(self.mesh._replica, diff._parts)

    def transfer(self, diff: Diff, u: Array, kind: str = "P1", *, bounded: bool = False) -> Array:
        """Values of the part, on the part after the edit: `Diff.transfer` for rows of the part.

        The part follows the diff, unless it has done so for another field. Nothing is carried across
        what is opened: each copy of a vertex has the values of its side. The integral over the part
        is kept to rounding where the part keeps its shape; linear functions stay linear, on each
        side. Time: that of the diff, and of a copy of the array.

        Args:
            diff: that leads from the part's revision to the mesh's.
            u: a row for each vertex ("P1", "dual") or cell of the part before the edit. Rows are finite
                numbers, or have a further axis of components; those of "DG1" have an axis of corners
                before that, in the order of `cells`.
            kind: "P1": values at vertices, of which each copy has its own. "dual": means over
                median-dual cells, which end at the part's border and at cracks. "P0": means of cells.
                "DG1": a linear function in each cell.
            bounded: keeps all values in the range of the old ones. What comes into the part then has
                their mean, and else 0.

        Returns:
            A new array, with a row for each vertex or cell of the part now.

        Raises:
            StaleDiff: the part or the mesh is not where the diff begins and ends.
            ValueError, TypeError: wrong kind, length, shape or dtype, or a value in the patch that is
                not finite.
        """
        if kind not in ("P1", "dual", "P0", "DG1"):
            raise ValueError(f"kind: a part carries 'P1', 'dual', 'P0' and 'DG1', and got {kind!r}")
        with self.mesh.locked():
            former = self._follow(diff)
            return self._transfer_from(former, np.asarray(u), kind, bounded)

    def _follow(self, diff: Diff) -> _Former:
        if self._former is None or self._former.diff is not diff:
            if diff.from_revision != self.revision:
                raise StaleDiff(f"the part is at revision {self.revision}, and the diff leads from "
                                f"{diff.from_revision}: transfer its values instead of an update, "
                                "which they need; the part follows the diff then")
            former = _Former(diff, len(self.vertex_slots), self.cells, self.cell_slots,
                             self.cell_numbers)
            self.update(diff)
            self._former = former
        return self._former

    def _transfer_from(self, former: _Former, values: Array, kind: str, bounded: bool) -> Array:
        diff = former.diff
        rows = former.vertices if is_at_vertices(kind) else len(former.cells)
        if values.ndim == 0 or len(values) != rows:
            raise ValueError(f"u: the part had {rows} {'vertices' if is_at_vertices(kind) else 'cells'} at "
                             f"revision {diff.from_revision}, and the values have the shape "
                             f"{values.shape}")
        check_values("u", values, kind, self.mesh.dimension)
        if kind == "P1":
            return self._transfer_at_vertices(former, values, "DG1", bounded)
        if kind == "dual":
            return self._transfer_at_vertices(former, values, "dual-corners", bounded=True)
        by_slot = np.zeros((self.mesh.cell_slots, *values.shape[1:]))
        if bounded and len(values):
            by_slot[:] = values.mean(axis=0)  # beyond the part, a value within their range
        by_slot[former.cell_slots] = values
        diff._carry(by_slot, kind, bounded=bounded)
        carried: Array = by_slot[self.cell_slots]
        return carried

    def _transfer_at_vertices(self, former: _Former, u: Array, kind: str, bounded: bool) -> Array:
        """At the corners of cells, and back to the vertices."""
        patch = former.diff.patch
        cells, slots = self.cells, self.cell_slots
        by_slot = np.zeros((self.mesh.cell_slots, cells.shape[1], *u.shape[1:]))
        numbers = former.cell_numbers[patch.removed_cells]
        if bounded and len(u):  # beyond the part, a value within their range
            by_slot[patch.removed_cells[numbers < 0]] = u.mean(axis=0)
            by_slot[patch.relabelled_cells] = u.mean(axis=0)
        by_slot[patch.removed_cells[numbers >= 0]] = u[former.cells[numbers[numbers >= 0]]]
        former.diff._carry(by_slot, kind, bounded=bounded)
        # The vertices that are new, have moved to another row, or have other cells.
        changed = np.zeros(len(self.vertex_slots), bool)
        changed[self.changed_vertices] = True
        changed[former.vertices:] = True
        changed[cells[self.changed_cells]] = True
        changed[cells[len(former.cells):]] = True
        near = self.cells_around(np.flatnonzero(changed))
        corners = by_slot[slots[near]]
        was = np.full(len(near), -1)
        there = slots[near] < len(former.cell_numbers)
        was[there] = former.cell_numbers[slots[near][there]]
        corners[was >= 0] = u[former.cells[was[was >= 0]]]
        result = np.zeros((len(changed), *u.shape[1:]))
        same = min(len(changed), former.vertices)
        result[:same] = u[:same]
        result[changed] = 0
        set_at_vertices(result, changed, self.points, cells[near], corners, was < 0, bounded)
        return result

    def _write(self, path: str, choices: dict[str, Any]) -> None:
        self._part.write(self.mesh._replica, self.mesh._options, path, choices)

    def to_meshio(self, point_data: Optional[Mapping[str, Array]] = None,
                  cell_data: Optional[Mapping[str, Array]] = None) -> meshio.Mesh:
        """The part for meshio: its cells, then its facets. Points have the mesh's dimension.

        Cell data are `marker`, of the features of facets and of the polygons whose own region cells
        are in, and `region`, of cells, small numbers as in files. Both are 0 for none. Facets and
        cells of features with a name are a set of that name. Where cells have the name, the facets
        are `NAME edges`, in 3D `NAME faces`: no name stands for two dimensions.

        Args:
            point_data: arrays with one row per vertex of the part, by name.
            cell_data: arrays with one row per cell of the part, by name; of facets they are 0.
        """
        return to_meshio(self, point_data, cell_data, "the part")

    def _region_labels(self) -> dict[int, tuple[int, Label]]:
        """Of each region of the part its number and its label, as in files."""
        return {region: (number, Label(marker, name)) for region, (number, marker, name)
                in self._part.region_labels(self.mesh._replica).items()}

    @property
    def revision(self) -> int:
        """The revision of the mesh that the part is of."""
        return int(self._part.revision)

    @property
    def points(self) -> Array:
        """Coordinates: (vertices, dimension), float64."""
        return self._part.points

    @property
    def cells(self) -> Array:
        """Numbers of the corners, positively oriented: (cells, dimension + 1), int32."""
        return self._part.cells

    @property
    def origin(self) -> Array:
        """The number of the first copy of each vertex: int32. Its own, but where the part is opened.

        `u[part.origin]` gives all copies the value of the first; `part.origin !=
        np.arange(len(part.origin))` are the further ones. `vertex_slots` leads all to the mesh.
        """
        return self._part.origin

    @property
    def changed_vertices(self) -> Array:
        """Numbers of the vertices whose rows the last update has written: all if it was made anew."""
        return self._changed(0, len(self.vertex_slots))

    @property
    def changed_cells(self) -> Array:
        """Numbers of the cells whose rows the last update has written: all if it was made anew.

        That much of a matrix has to be assembled again.
        """
        return self._changed(1, len(self.cell_slots))

    def cells_around(self, vertices: Any) -> Array:
        """Numbers of the cells around any of these vertices, ascending: int32.

        Time: that of these cells. Raises `OutOfRange` for a number that no vertex has,
        `FailedPrecondition` if the part is not at the mesh's revision.
        """
        numbers = np.ascontiguousarray(np.atleast_1d(vertices), dtype=np.int32)
        around: Array = self._part.cells_around(self.mesh._replica, numbers)
        return around

    @property
    def facets(self) -> Array:
        """Numbers of the corners of each facet: (facets, dimension), int32.

        At the border the part is on the left of an edge; corners of a triangle are counter-clockwise
        as seen from outside.
        """
        return self._part.facets

    @property
    def facet_cells(self) -> Array:
        """Numbers of the cells at each facet: (facets, 2), int32.

        The second is -1 at the border, and where the part is opened.
        """
        slots = self._part.facet_cells
        if len(slots) == 0:
            return slots
        return np.where(slots >= 0, self._part.cell_numbers[slots], -1).astype(np.int32)

    @property
    def is_border(self) -> Array:
        """Mask of the facets at the border, those of what is opened included."""
        return self._part.facet_cells[:, 1] < 0

    @property
    def facet_twins(self) -> Array:
        """Of a facet of what is opened, the facet of the other side: int32, else -1.

        `np.column_stack([i := np.flatnonzero(part.facet_sides > 0), part.facet_twins[i]])` are the
        pairs of a crack.
        """
        return self._part.facet_twins

    @property
    def facet_sides(self) -> Array:
        """On which side of an opened feature the part's cell at each facet is: int8. O(features).

        1: on the left of a segment, as it goes from its first end to its second one; in an opened
        polygon of 2D; in 3D on the side from which the polygon's first ring is counter-clockwise.
        -1: on the other side. 0: the facet is of no opened feature. Raises `FailedPrecondition` if
        the part is not at the mesh's revision.
        """
        owners = self.facet_owners[self.is_border]
        local = self.mesh._backend.is_local
        features = {f["id"]: f for f in self.mesh.features(None if local else self.revision)}
        there = [features[id_] for id_ in np.unique(owners).tolist() if id_ in features]
        segments = {f["id"]: f["ends"] for f in there if f["kind"] == "segment"}
        polygons = {f["id"]: f["rings"] for f in there if f["kind"] == "polygon"}
        ends = {point for pair in segments.values() for point in pair}
        ends |= {point for rings in polygons.values() for point in rings[0]}
        sides: Array = self._part.facet_sides(self.mesh._replica, _batch.make(
            self.mesh.dimension, dict(add_points={id_: features[id_]["at"] for id_ in ends},
                                      add_segments=segments, add_polygons=polygons)))
        return sides

    @property
    def facet_owners(self) -> Array:
        """The feature of each facet: uint64, 0 for none."""
        return self._part.facet_owners

    @property
    def facet_markers(self) -> Array:
        """The marker of each facet's feature: int64, 0 without one."""
        return self._by_owner(lambda label: label.marker, np.int64)

    @property
    def facet_names(self) -> Array:
        """The name of each facet's feature: str, empty without one."""
        return self._by_owner(lambda label: label.name, object)

    @property
    def cell_regions(self) -> Array:
        """The polygon around each cell, as `Mesh.regions`: uint64."""
        return self._part.cell_regions

    @property
    def vertex_slots(self) -> Array:
        """The slot of each vertex in the mesh: int32."""
        return self._part.vertex_slots

    @property
    def cell_slots(self) -> Array:
        """The slot of each cell in the mesh: int32."""
        return self._part.cell_slots

    @property
    def vertex_numbers(self) -> Array:
        """By vertex slot of the mesh, the number in the part: int32, -1 where it is not in it.

        Of several copies it is the first.
        """
        return self._part.vertex_numbers

    @property
    def cell_numbers(self) -> Array:
        """By cell slot of the mesh, the number in the part: int32, -1 where it is not in it."""
        return self._part.cell_numbers

    def _changed(self, which: int, count: int) -> Array:
        rows = self._part.changes[which]
        if rows is None:
            return np.arange(count, dtype=np.int32)
        rows = np.unique(rows)
        return rows[rows < count]

    def _by_owner(self, of: Any, dtype: Any) -> Array:
        owners, which = np.unique(self.facet_owners, return_inverse=True)
        labels = self.mesh.labels
        none = Label()
        return np.array([of(labels.get(int(id_), none)) for id_ in owners], dtype=dtype)[which]
