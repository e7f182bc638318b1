"""Meshes of domains that are given by segments or facets, with the parts cut away that are outside.

What the front ends have in common: features with the ids that a mesh wants, the outside and holes eaten
up to the segments (in 3D facets), input vertices first, and bounds of areas that are checked and kept.
"""
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from dynmesh._mesh import Mesh
from dynmesh._server import open as open_mesh
from dynmesh._types import Array
from dynmesh.compat import _topology
from dynmesh.compat._errors import Unsupported
from dynmesh.errors import FailedPrecondition, LimitExceeded

#: For each cell of a cut, the largest area or volume that it may have.
Bounds = Callable[["Cut"], Array]
#: Mask of the cells that are kept, from the mesh's points and cells.
Keep = Callable[[Array, Array], Array]

_ROUNDS = 60
# By how much the target length everywhere may be that of a larger area, volume: the mesh's own lattices are
# finer than a target allows. The largest triangles of 192 meshes, least angles of 5 to 30 degrees, then had
# 0.97 of the bound, the largest tetrahedra of 54 meshes 0.99; one in 30 of the latter needed further balls.
_SLACK = {2: 1.3, 3: 1.9}
#: How near a point must be to a segment to cut it, in units of the extent; and at least in roundings of
#: the mesh's largest coordinate, as a mesh has no distances below about a thousand.
_ON_SEGMENT = 1e-12
_ROUNDINGS = 4096


def bounds_of(cut: "Cut", everywhere: Optional[float], of_regions: Optional[Array] = None) -> Array:
    """For each cell the largest measure: that of all cells, and that of its region, if it is above 0."""
    bounds = np.full(len(cut.cells), np.inf if everywhere is None else everywhere)
    if of_regions is not None and len(of_regions):
        bounds = np.minimum(bounds, np.append(np.where(of_regions > 0, of_regions, np.inf), np.inf)[cut.regions])
    return bounds


def array_of(value: Any, name: str, width: int, dtype: Any = np.float64) -> Array:
    """A two-dimensional array of rows; raises ValueError with the name and the shape that is needed."""
    rows = np.asarray(value if value is not None else [])
    if rows.size == 0:
        return np.zeros((0, width), dtype)
    if rows.ndim != 2 or rows.shape[1] != width:
        raise ValueError(f"{name}: an array of shape (n, {width}), and got {rows.shape}")
    if not np.isfinite(rows.astype(np.float64)).all():
        raise ValueError(f"{name}: row {int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])} is "
                         "not finite")
    return np.ascontiguousarray(rows, dtype)


def indices_of(value: Any, name: str, width: int, vertices: int) -> Array:
    """`array_of` numbers of vertices, which are checked."""
    rows = array_of(value, name, width, np.int64)
    wrong = np.flatnonzero(((rows < 0) | (rows >= vertices)).any(axis=1))
    if len(wrong):
        raise ValueError(f"{name}: row {int(wrong[0])} is {rows[wrong[0]].tolist()}, and vertices are 0 to "
                         f"{vertices - 1}")
    return rows


def rho_of(angle: float, what: str) -> float:
    """The bound of circumradius / shortest edge for a least angle in degrees."""
    if not 0 <= angle <= 30:
        raise Unsupported(
            f"{what}: the least angle is {angle:g} degrees, and dynmesh keeps up to 30: ask for "
            f"{'30' if angle > 30 else '0 to 30'}")
    sine = float(np.sin(np.radians(angle)))
    return 100.0 if sine < 0.005 else max(1.0, 0.5 / sine)


@dataclass(frozen=True)
class Cut:
    """The part of a mesh that is left: vertices of the input first, in their order, then new ones."""

    points: Array  #: (vertices, dimension)
    cells: Array  #: Positively oriented: (cells, dimension + 1), int32
    neighbours: Array  #: The cell opposite to each corner, -1 where there is none, int32
    facets: Array  #: Subsegments, in 3D subfacets, of the input: (facets, dimension), int32
    facet_owners: Array  #: Of each the row of the input's segment or facet
    facet_pieces: Array  #: Of each the row of `Domain.pieces`
    regions: Array  #: The last place of a region that reaches each cell; -1 for none
    inputs: int  #: Number of the input's vertices
    _numbers: Array  # of the mesh's cells in this part, by slot; -1 outside
    _mesh: Optional[Mesh]

    @property
    def measures(self) -> Array:
        """Areas, in 3D volumes."""
        return _topology.measures_of(self.points, self.cells)

    def locate(self, places: Array) -> Array:
        """The cell around each place, or one beside it on the border."""
        if self._mesh is None:
            return _topology.Grid(self.points, self.cells).locate(places)
        slots = self._mesh.locate(places)
        result: Array = self._numbers[slots]
        outside = np.flatnonzero(result < 0)
        if len(outside):  # places on the border, found in the cell beyond it
            beyond = self._mesh.neighbours[slots[outside]]
            inside = np.where(beyond >= 0, self._numbers[beyond], -1)
            best = np.full(len(outside), -1e-9)
            for candidates in inside.T:
                there = np.flatnonzero(candidates >= 0)
                cells = candidates[there]
                least = _topology.weights_in(self.points, self.cells[cells],
                                             places[outside[there]]).min(axis=1)
                better = least >= best[there]
                result[outside[there[better]]] = cells[better]
                best[there[better]] = least[better]
            far = np.flatnonzero(result < 0)
            if len(far):
                result[far] = _topology.Grid(self.points, self.cells).locate(places[far])
        return result


class Domain:
    """The input of a mesh, and the mesh."""

    def __init__(self, points: Array, facets: Sequence[Sequence[Any]], options: dict[str, Any], *,
                 unsplit: Optional[Array] = None, sizes: Sequence[dict[str, Any]] = ()) -> None:
        """Makes the mesh.

        Args:
            points: the input's vertices, of which equal ones are one.
            facets: 2D: pairs of vertices; 3D: lists of rings of vertices.
            options: of the mesh, but for its box and dimension.
            unsplit: 2D: the rows of `facets` that get no vertex.
            sizes: sizing features.
        """
        self.dimension = points.shape[1]
        self.inputs = len(points)
        self._given = points
        self._first, self._distinct = _distinct(points)
        self._facets = facets
        self._options = options
        self._unsplit = np.zeros(0, np.int64) if unsplit is None else unsplit
        self._sizes = list(sizes)
        if len(self._first) <= self.dimension:
            raise ValueError(f"vertices: {len(self._first)} different ones, and a mesh needs "
                             f"{self.dimension + 1}")
        self.mesh = self._make()

    def _make(self) -> Mesh:
        if self.dimension == 3:
            return self._apply(*self._polygons())
        pieces, owners = self._segments(np.asarray(self._facets, np.int64).reshape(-1, 2))
        try:
            return self._apply(pieces, owners)
        except FailedPrecondition as error:
            extent = float(np.ptp(self._given, axis=0).max())
            largest = float(np.abs(self._given).max()) + 4 * extent  # of the mesh, which reaches farther
            near = max(_ON_SEGMENT * extent, _ROUNDINGS * float(np.spacing(largest)))
            cut, number = _topology.pieces_between(self._given, pieces, near)
            cut, of = self._segments(cut)
            if len(cut) == len(pieces) and (cut == pieces).all():
                raise
            try:
                return self._apply(cut, owners[number[of]])
            except FailedPrecondition:
                raise error from None

    def _segments(self, rows: Array) -> tuple[Array, Array]:
        """Each pair of different points once, and the row that it comes from."""
        ends = self._first[self._distinct[rows]]
        kept = np.flatnonzero(ends[:, 0] != ends[:, 1])
        _, once = np.unique(np.sort(ends[kept], axis=1), axis=0, return_index=True)
        kept = kept[np.sort(once)]
        return ends[kept], kept

    def _polygons(self) -> tuple[Any, Array]:
        rings = [[self._first[self._distinct[np.asarray(ring)]].tolist() for ring in facet]
                 for facet in self._facets]
        return rings, np.arange(len(rings))

    def _apply(self, facets: Any, owners: Array) -> Mesh:
        points = self._given[self._first]
        low, high = points.min(axis=0), points.max(axis=0)
        extent = float((high - low).max())
        high = np.maximum(high, low + 1e-3 * extent)
        mesh = open_mesh((low.tolist(), high.tolist()), dimension=self.dimension, **self._options)
        self._base = self.inputs + 1  # ids of facets begin here
        ids = np.arange(self._base, self._base + len(facets), dtype=np.uint64)
        self._owners = owners
        #: 2D: the segments of the mesh: those of the input, cut at vertices that lie on them.
        self.pieces: Array = facets if self.dimension == 2 else np.zeros((0, 2), np.int64)
        self._next = self._base + len(facets)
        edits: dict[str, Any] = dict(add_points=((self._first + 1).astype(np.uint64), points))
        if self.dimension == 2:
            edits["add_segments"] = (ids, facets + 1)
            marked = ids[np.isin(owners, self._unsplit)]
            if len(marked):
                edits["unsplit"] = marked
        else:
            edits["add_polygons"] = {int(id_): [[i + 1 for i in ring] for ring in rings]
                                     for id_, rings in zip(ids, facets)}
        if self._sizes:
            edits["add_sizes"] = {self._next + i: size for i, size in enumerate(self._sizes)}
            self._next += len(self._sizes)
        mesh.load(**edits)
        return mesh

    def cut(self, holes: Array, seeds: Array, *, keep: Optional[Keep] = None) -> Cut:
        """What is left without the outside and the holes.

        Args:
            holes: a place in each hole.
            seeds: a place in each region.
            keep: chooses the cells, in place of eating from outside and from holes.
        """
        mesh, compact = self.mesh, self.mesh.compact()
        cells, points = compact.cells, compact.points
        near = mesh.neighbours[compact.cell_slots]
        near = np.where(near >= 0, compact.cell_numbers[near], -1)
        rows, of = ((mesh.subsegments, mesh.subsegment_owners) if self.dimension == 2
                    else (mesh.subfacets, mesh.subfacet_owners))
        live = rows[:, 0] >= 0
        facets = compact.vertex_numbers[rows[live]]
        owner_ids = of[live].astype(np.int64) - self._base
        faces = _topology.faces_of(cells)
        face_keys, facet_keys = _topology.common_keys(faces.reshape(-1, self.dimension), facets,
                                                      len(points))
        blocked = np.isin(face_keys, facet_keys).reshape(cells.shape)
        if keep is not None:
            kept = keep(points, cells)
        else:
            starts = np.flatnonzero((near < 0).any(axis=1))
            if len(holes):
                starts = np.concatenate([starts, self._at(holes, compact)])
            kept = ~_topology.flood(near, blocked, starts)
        if not kept.any():
            raise ValueError(
                "nothing is left of the mesh: the segments (in 3D facets) enclose nothing, or holes are in "
                "all that they enclose; close the outline, or enclose the convex hull (in 2D the switch c)")
        regions = np.full(len(cells), -1)
        if len(seeds):
            for number, start in enumerate(self._at(seeds, compact, dropped=-1)):
                if start >= 0 and kept[start]:
                    regions[_topology.flood(near, blocked | ~np.where(near >= 0, kept[near], False),
                                            np.array([start]))] = number
        # Vertices: those of the input, then the other ones that are left.
        owners = mesh.owners[compact.vertex_slots]
        is_input = ((mesh.containing_dimensions[compact.vertex_slots] == 0)
                    & (owners >= 1) & (owners <= self.inputs))
        used = np.zeros(len(points), bool)
        used[cells[kept]] = True
        new = np.flatnonzero(used & ~is_input)
        numbers = np.full(len(points), -1, np.int32)
        numbers[is_input] = owners[is_input].astype(np.int64) - 1
        numbers[new] = self.inputs + np.arange(len(new))
        cell_numbers = np.full(len(cells), -1, np.int32)
        cell_numbers[kept] = np.arange(np.count_nonzero(kept))
        left = np.isin(facet_keys, face_keys.reshape(cells.shape)[kept])
        by_slot = np.full(mesh.cell_slots, -1, np.int32)
        by_slot[compact.cell_slots] = cell_numbers
        return Cut(np.concatenate([self._given, points[new]]), numbers[cells[kept]],
                   np.where(near[kept] >= 0, cell_numbers[near[kept]], -1).astype(np.int32),
                   numbers[facets[left]], self._owners[owner_ids[left]], owner_ids[left], regions[kept],
                   self.inputs, by_slot, mesh)

    def _at(self, places: Array, compact: Any, dropped: Optional[int] = None) -> Array:
        """The cell at each place; those outside of the mesh are `dropped`, if given, or left out."""
        slots = self.mesh.locate(places)
        numbers: Array = np.where(slots >= 0, compact.cell_numbers[slots], -1 if dropped is None else dropped)
        return numbers if dropped is not None else numbers[slots >= 0]

    def refine(self, cut_of: Callable[[], Cut], bounds: Bounds) -> Cut:
        """Makes cells finer until none is larger than its bound.

        A cell that is gets a sizing ball at its centre, with the target length whose largest cell has that
        area or volume; the mesh is brought up to date, and looked at again.
        """
        power = 1 / self.dimension
        for _ in range(_ROUNDS):
            cut = cut_of()
            limits = bounds(cut)
            over = np.flatnonzero(cut.measures > limits * (1 + 1e-9))
            if len(over) == 0:
                return cut
            centres = cut.points[cut.cells[over]].mean(axis=1)
            targets = target_of(limits[over], self.dimension)
            radii = 0.35 * cut.measures[over]**power
            before = self.mesh.hash
            self.mesh.apply(add_sizes={
                self._next + i: dict(target=float(h), at=tuple(c), radius=float(r))
                for i, (h, c, r) in enumerate(zip(targets, centres, radii))})
            self._next += len(over)
            if self.mesh.hash == before:
                break
        raise LimitExceeded(
            f"{len(over)} cells stay larger than they may be, the first around "
            f"{tuple(round(float(x), 6) for x in centres[0])}"
            + (": they are beside segments that may not be split; give these more vertices, or leave "
               "out the switch Y" if len(self._unsplit) else ""))


def target_of(measure: Any, dimension: int) -> Any:
    """The target length with which no cell is larger than this area (3D: volume)."""
    if dimension == 2:
        return np.sqrt(np.asarray(measure) / 0.8660254037844387)
    return np.cbrt(3 * np.asarray(measure))


def max_edge_of(measure: Optional[float], dimension: int) -> float:
    """The target length everywhere for a largest area (3D: volume), which is then checked; 0 for none."""
    return 0.0 if measure is None else float(target_of(_SLACK[dimension] * measure, dimension))


def _distinct(points: Array) -> tuple[Array, Array]:
    """The first of each group of equal points, and the group of each point."""
    _, first, group = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(first), np.int64)
    rank[order] = np.arange(len(first))
    return first[order], rank[group.reshape(-1)]


def check_count(cut: Cut, most: Optional[int], what: str) -> None:
    """Raises if a mesh has more new vertices than the caller allows."""
    new = len(cut.points) - cut.inputs
    if most is not None and new > most:
        raise Unsupported(f"{what}: the mesh needs {new} new vertices, and dynmesh does not stop before "
                          "it is good: allow as many, or ask for larger angles or areas")


__all__ = ["Bounds", "Cut", "Domain", "array_of", "check_count", "indices_of", "max_edge_of", "rho_of",
           "target_of"]
