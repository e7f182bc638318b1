"""Quality meshes of planar straight-line graphs: what `triangle` and `meshpy.triangle` have in common."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from dynmesh._types import Array
from dynmesh.compat import _topology
from dynmesh.compat._domain import Cut, Domain, bounds_of, check_count, max_edge_of, rho_of, target_of
from dynmesh.compat._values import interpolate
from dynmesh.errors import FailedPrecondition, InvalidArgument

#: The least angle without the switch q: that of a mesh by default.
DEFAULT_RHO = 2**0.5


def triangulated(points: Array, segments: list[list[int]]) -> Domain:
    """The constrained Delaunay triangulation of the input, without new vertices."""
    return Domain(points, segments, dict(kind="triangulation"))


@dataclass
class Graph:
    """A planar straight-line graph, and what is asked of its mesh."""

    points: Array
    segments: Array  #: (n, 2)
    holes: Array  #: A place in each
    regions: Array  #: x, y, attribute, largest area (not above 0: none)
    is_refined: bool = True  #: It has new vertices
    angle: Optional[float] = None  #: The least angle, degrees
    angle_name: str = "q"  #: What the caller calls it
    area: Optional[float] = None  #: Of all triangles
    has_region_areas: bool = False  #: Those of `regions` count
    closes_hull: bool = False  #: The convex hull's edges are segments
    unsplit: str = ""  #: "": split all; "border", "all"
    most_new: Optional[int] = None  #: New vertices
    triangles: Array = field(default_factory=lambda: np.zeros((0, 3), np.int64))  #: Of a mesh to be refined
    triangle_areas: Optional[Array] = None  #: The largest area in each of them; not above 0: none
    needs_refinement: Optional[Callable[[Any, float], Any]] = None  #: Of corners and area


class Planar:
    """The mesh of a graph."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        segments = graph.segments
        #: The rows of the caller's segments come first.
        self.given = len(segments)
        if len(graph.triangles):
            near = _topology.neighbours_of(graph.triangles, len(graph.points))
            faces = _topology.faces_of(graph.triangles)
            segments = np.concatenate([segments, faces[near < 0]])
        if graph.closes_hull:
            segments = np.concatenate([segments, _topology.hull_of(graph.points)])
        self._segments = segments
        self._grid = _topology.Grid(graph.points, graph.triangles) if len(graph.triangles) else None
        self._base: Optional[tuple[Domain, Cut]] = None
        self._domain = self._refined() if graph.is_refined else triangulated(graph.points,
                                                                             segments.tolist())
        #: The mesh.
        self.cut: Cut = (self._domain.refine(lambda: self._cut_of(self._domain), self._bounds)
                         if graph.is_refined else self._cut_of(self._domain))
        check_count(self.cut, graph.most_new, "S")

    def _refined(self) -> Domain:
        graph, rows = self.graph, self._segments.tolist()
        rho = DEFAULT_RHO if graph.angle is None else rho_of(graph.angle, graph.angle_name)
        options = dict(rho=rho, max_edge=max_edge_of(graph.area, 2))
        unsplit = self._unsplit_rows()
        sizes = self._region_sizes()
        try:
            return Domain(graph.points, rows, options, unsplit=unsplit, sizes=sizes)
        except (InvalidArgument, FailedPrecondition):
            if not sizes:
                raise
            return Domain(graph.points, rows, options, unsplit=unsplit)  # areas of regions by balls alone

    def _cut_of(self, domain: Domain) -> Cut:
        keep = None
        if self._grid is not None:
            grid = self._grid
            keep = lambda points, cells: grid.locate(points[cells].mean(axis=1)) >= 0  # noqa: E731
        return domain.cut(self.graph.holes, self.graph.regions[:, :2], keep=keep)

    def base(self) -> tuple[Domain, Cut]:
        """The triangulation of the input, for what must be known before the mesh is made."""
        if self._base is None:
            domain = triangulated(self.graph.points, self._segments.tolist())
            self._base = domain, self._cut_of(domain)
        return self._base

    def _unsplit_rows(self) -> Optional[Array]:
        if self.graph.unsplit == "":
            return None
        if self.graph.unsplit == "all":
            return np.arange(len(self._segments))
        _, cut = self.base()
        return np.unique(cut.facet_owners[sides_of(cut)[:, 1] < 0])

    def _region_sizes(self) -> list[dict[str, Any]]:
        """A sizing polygon for each region with an area."""
        regions = self.graph.regions
        if not self.graph.has_region_areas or not (regions[:, 3] > 0).any():
            return []
        domain, cut = self.base()
        cells = sides_of(cut)
        of = np.where(cells >= 0, cut.regions[cells], -1)
        result = []
        for number in np.flatnonzero(regions[:, 3] > 0):
            border = np.flatnonzero((of == number).sum(axis=1) == 1)
            side = cells[border, np.where(of[border, 0] == number, 0, 1)]
            rows, once = np.unique(cut.facet_pieces[border], return_index=True)
            pieces = domain.pieces[rows]
            middle = cut.points[cut.cells[side[once]]].mean(axis=1)
            a, b = cut.points[pieces[:, 0]], cut.points[pieces[:, 1]]
            left = ((b - a)[:, 0] * (middle - a)[:, 1] - (b - a)[:, 1] * (middle - a)[:, 0]) > 0
            rings = _rings(cut.points, np.where(left[:, None], pieces, pieces[:, ::-1]))
            if rings:
                result.append(dict(target=float(target_of(regions[number, 3], 2)),
                                   rings=[[index + 1 for index in ring] for ring in rings]))
        return result

    def _bounds(self, cut: Cut) -> Array:
        graph = self.graph
        bounds = bounds_of(cut, graph.area, graph.regions[:, 3] if graph.has_region_areas else None)
        if graph.triangle_areas is not None and self._grid is not None:
            centres = cut.points[cut.cells].mean(axis=1)
            areas = np.where(graph.triangle_areas > 0, graph.triangle_areas, np.inf)
            bounds = np.minimum(bounds, areas[self._grid.locate(centres)])
        if graph.needs_refinement is not None:
            measures = cut.measures
            corners = cut.points[cut.cells].tolist()
            flagged = np.array([bool(graph.needs_refinement(rows, area))
                                for rows, area in zip(corners, measures.tolist())], bool)
            bounds = np.minimum(bounds, np.where(flagged, measures / 1.5, np.inf))
        return bounds

    def attributes(self, given: Array) -> Array:
        """Values of vertices, at all vertices of the mesh."""
        new = self.cut.points[self.cut.inputs:]
        if len(new) == 0:
            return given
        _, base = self.base()
        return np.concatenate([given, interpolate(base, given, new)])

    def region_attributes(self) -> Array:
        """The attribute of each triangle's region, 0 outside of regions: (triangles, 1)."""
        table = np.append(self.graph.regions[:, 2], 0.0)
        result: Array = table[self.cut.regions].reshape(-1, 1)
        return result

    def old_triangles(self) -> Array:
        """Of each triangle that of the refined mesh in which its centre is."""
        assert self._grid is not None
        return self._grid.locate(self.cut.points[self.cut.cells].mean(axis=1))


def sides_of(cut: Cut) -> Array:
    """The triangles at each facet; the second is -1 on the border: (facets, 2)."""
    faces = _topology.faces_of(cut.cells)
    face_keys, facet_keys = _topology.common_keys(faces.reshape(-1, faces.shape[2]), cut.facets,
                                                  len(cut.points))
    order = np.argsort(face_keys, kind="stable")
    first = np.searchsorted(face_keys[order], facet_keys)
    last = np.searchsorted(face_keys[order], facet_keys, "right") - 1
    one, two = order[first] // cut.cells.shape[1], order[last] // cut.cells.shape[1]
    return np.stack([one, np.where(last > first, two, -1)], axis=1)


def _rings(points: Array, directed: Array) -> list[list[int]]:
    """Closed chains of pieces, of which each begins where another one ends; none if one stays open."""
    ahead: dict[int, list[int]] = {}
    for a, b in directed.tolist():
        ahead.setdefault(a, []).append(b)
    rings = []
    while ahead:
        start = next(iter(ahead))
        ring, at, before = [start], start, -1
        while True:
            choices = ahead.get(at)
            if not choices:
                return []
            if before >= 0 and len(choices) > 1:
                back = np.arctan2(*(points[before] - points[at])[::-1])
                turns = [(back - np.arctan2(*(points[c] - points[at])[::-1])) % (2 * np.pi)
                         for c in choices]
                to = choices.pop(int(np.argmin(turns)))
            else:
                to = choices.pop()
            if not choices:
                del ahead[at]
            if to == start:
                break
            ring.append(to)
            before, at = at, to
        rings.append(ring)
    return rings


@dataclass(frozen=True)
class Marks:
    """Boundary markers: of vertices, of segments that are left, of edges."""

    vertices: Array
    segments: Array
    edges: Array
    edge_markers: Array


def marks_of(points: Array, triangles: Array, facets: Array, facet_markers: Array,
             vertex_markers: Array) -> Marks:
    """Markers as Triangle gives them.

    An edge on a segment has the segment's marker, if that is not 0; other edges of the border have 1. A
    vertex keeps its own one, then has that of a segment that it lies on, then 1 on the border. A segment has
    the marker of its edge.
    """
    edges = _topology.edges_of(triangles)
    faces = _topology.faces_of(triangles)
    border = faces[_topology.neighbours_of(triangles, len(points)) < 0]
    count = len(points)
    edge_keys = _topology.keys(edges, count)
    order = np.argsort(edge_keys)

    def rows(pairs: Array) -> Array:
        result: Array = order[np.searchsorted(edge_keys[order], _topology.keys(pairs, count))]
        return result

    edge_markers = np.zeros(len(edges), np.int32)
    edge_markers[rows(border)] = 1
    at = rows(facets) if len(facets) else np.zeros(0, np.int64)
    marked = facet_markers != 0
    edge_markers[at[marked]] = facet_markers[marked]
    on_vertices = np.zeros(count, np.int32)
    on_vertices[border] = 1
    on_vertices[facets[marked]] = facet_markers[marked][:, None]
    result = np.where(vertex_markers != 0, vertex_markers, on_vertices).astype(np.int32)
    return Marks(result, edge_markers[at], edges.astype(np.int32), edge_markers)


def with_middles(points: Array, triangles: Array, attributes: Optional[Array], markers: Array,
                 edge_markers: Array) -> tuple[Array, Array, Optional[Array], Array]:
    """Triangles of six nodes: the corners, then the middle of the edge opposite to each of them."""
    edges = _topology.edges_of(triangles)
    faces = _topology.faces_of(triangles).reshape(-1, 2)
    edge_keys, face_keys = _topology.common_keys(edges, faces, len(points))
    order = np.argsort(edge_keys)
    of = order[np.searchsorted(edge_keys[order], face_keys)].reshape(-1, 3)
    nodes = np.concatenate([points, points[edges].mean(axis=1)])
    if attributes is not None:
        attributes = np.concatenate([attributes, attributes[edges].mean(axis=1)])
    return (nodes, np.concatenate([triangles, len(points) + of], axis=1).astype(np.int32), attributes,
            np.concatenate([markers, edge_markers]))
