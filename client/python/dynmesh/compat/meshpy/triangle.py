"""The interface of `meshpy.triangle` on dynmesh::

    from dynmesh.compat.meshpy import triangle          # was: from meshpy import triangle
    info = triangle.MeshInfo()
    info.set_points([(0, 0), (1, 0), (1, 1), (0, 1)])
    info.set_facets([(0, 1), (1, 2), (2, 3), (3, 0)])
    mesh = triangle.build(info, max_volume=0.01, min_angle=30)
    mesh.points, mesh.elements

docs/compat.md has what is the same and what differs.
"""
from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Optional, Union

import numpy as np

from dynmesh._types import Array
from dynmesh.compat import _topology
from dynmesh.compat._domain import array_of, indices_of
from dynmesh.compat._errors import Unsupported
from dynmesh.compat._planar import Graph, Planar, marks_of, with_middles
from dynmesh.compat.meshpy._arrays import Arrays, ForeignArray

__all__ = ["MeshInfo", "build", "refine", "subdivide_facets", "write_gnuplot_mesh"]

Refinement = Optional[Callable[[Any, float], Any]]


class MeshInfo(Arrays):
    """A planar straight-line graph, or a mesh of one. All members are arrays of rows."""

    def __init__(self) -> None:
        #: x, y of each vertex.
        self.points = ForeignArray(np.float64, 2)
        #: Values of vertices; `number_of_point_attributes` first, then `setup()`.
        self.point_attributes = ForeignArray(np.float64, 1, self.points)
        #: A number for each vertex.
        self.point_markers = ForeignArray(np.int32, 1, self.points)
        #: The corners of triangles, in a mesh of `mesh_order` 2 six nodes.
        self.elements = ForeignArray(np.int32, 3)
        #: Of a mesh that was built with `attributes`: the attribute of each triangle's region.
        self.element_attributes = ForeignArray(np.float64, 1, self.elements)
        #: For `refine`: the largest area in each triangle; none if not above 0.
        self.element_volumes = ForeignArray(np.float64, 1, self.elements)
        #: The triangle opposite to each corner, -1 at the border.
        self.neighbors = ForeignArray(np.int32, 3)
        #: Segments: numbers of their two vertices.
        self.facets = ForeignArray(np.int32, 2)
        #: A number for each segment.
        self.facet_markers = ForeignArray(np.int32, 1, self.facets)
        #: A place in each hole.
        self.holes = ForeignArray(np.float64, 2)
        #: Of each region a place, an attribute and a largest area.
        self.regions = ForeignArray(np.float64, 4)
        #: Edges of a mesh that was built with `generate_faces`.
        self.faces = ForeignArray(np.int32, 2)
        #: A number for each edge.
        self.face_markers = ForeignArray(np.int32, 1, self.faces)

    def set_facets(self, facets: Iterable[Any], facet_markers: Optional[Iterable[int]] = None) -> None:
        """Sets the segments.

        Args:
            facets: pairs of numbers of vertices.
            facet_markers: a number for each of them.
        """
        rows = [list(pair) for pair in facets]
        wrong = [row for row in rows if len(row) != 2]
        if wrong:
            raise ValueError(f"facets: a facet is a pair of vertices, and got {wrong[0]!r}")
        self.facets._set(rows)
        self._mark(self.facet_markers, facet_markers, len(rows), "facet_markers")


def _description(info: MeshInfo) -> tuple[Array, Array, Array, Array]:
    points = array_of(info.points, "points", 2)
    facets = indices_of(info.facets, "facets", 2, len(points))
    point_markers = (np.array(info.point_markers) if info.point_markers.allocated
                     else np.zeros(len(points), np.int32))
    facet_markers = (np.array(info.facet_markers) if info.facet_markers.allocated
                     else np.zeros(len(facets), np.int32))
    return points, facets, point_markers, facet_markers


def _result(info: MeshInfo, graph: Graph, planar: Planar, markers: tuple[Array, Array], *,
            attributes: bool, faces: bool, neighbours: bool, order: int) -> MeshInfo:
    cut = planar.cut
    given = len(graph.segments)
    facet_markers = np.append(markers[1], 0)[np.where(cut.facet_owners < given, cut.facet_owners, -1)]
    new = np.zeros(len(cut.points) - cut.inputs, np.int32)
    marks = marks_of(cut.points, cut.cells, cut.facets, facet_markers, np.concatenate([markers[0], new]))
    values = (planar.attributes(np.asarray(info.point_attributes).reshape(cut.inputs, -1))
              if info.point_attributes.allocated else None)
    points, cells, point_markers = cut.points, cut.cells, marks.vertices
    if order == 2:
        points, cells, values, point_markers = with_middles(points, cells, values, point_markers,
                                                            marks.edge_markers)
    mesh = MeshInfo()
    mesh.points._set(points)
    mesh.point_markers._set(point_markers)
    if values is not None:
        mesh.point_attributes._set(values, values.shape[1])
    mesh.elements._set(cells, cells.shape[1])
    mesh.facets._set(cut.facets)
    mesh.facet_markers._set(marks.segments)
    mesh.holes._set(graph.holes)
    mesh.regions._set(graph.regions)
    if attributes:
        mesh.element_attributes._set(planar.region_attributes())
    if faces:
        mesh.faces._set(marks.edges)
        mesh.face_markers._set(marks.edge_markers)
    if neighbours:
        mesh.neighbors._set(cut.neighbours)
    return mesh


def build(mesh_info: MeshInfo, verbose: bool = False, refinement_func: Refinement = None,
          attributes: bool = False, volume_constraints: bool = False,
          max_volume: Optional[float] = None, allow_boundary_steiner: bool = True,
          allow_volume_steiner: bool = True, quality_meshing: bool = True,
          generate_edges: Optional[bool] = None, generate_faces: bool = False,
          min_angle: Optional[float] = None, mesh_order: Optional[int] = None,
          generate_neighbor_lists: bool = False) -> MeshInfo:
    """The mesh of a planar straight-line graph.

    Args:
        mesh_info: the graph.
        verbose: has no effect.
        refinement_func: called with the three corners of a triangle and its area; true if it is too large.
            Those that are become smaller, until none is. It must be false for small ones.
        attributes: `element_attributes` of the mesh are those of regions, 0 elsewhere.
        volume_constraints: the areas of regions count.
        max_volume: the largest area of a triangle.
        allow_boundary_steiner: new vertices on the border; False: its segments stay whole.
        allow_volume_steiner: new vertices inside; False is `Unsupported`.
        quality_meshing: with a least angle. False, without a bound of areas: no new vertices.
        generate_edges: an older name of `generate_faces`.
        generate_faces: the mesh has its edges, as `faces`.
        min_angle: degrees, up to 30; None: 20.
        mesh_order: 2 for triangles of six nodes.
        generate_neighbor_lists: the mesh has `neighbors`.

    Returns:
        The mesh: points of the input first, in their order; `elements`, counter-clockwise; what is left of
        the segments, as `facets`; markers.

    Raises:
        ValueError: an array that cannot be meant, or nothing is left of the mesh.
        Unsupported: what dynmesh does not have.
        FailedPrecondition: the input is none that a mesh accepts, as segments that cross.
        LimitExceeded: areas that cannot be kept beside a border that may not be split.
    """
    if mesh_order not in (None, 1, 2):
        raise ValueError(f"mesh_order: 1 or 2, and got {mesh_order!r}")
    points, facets, point_markers, facet_markers = _description(mesh_info)
    holes, regions = array_of(mesh_info.holes, "holes", 2), array_of(mesh_info.regions, "regions", 4)
    if max_volume is not None and not max_volume > 0:
        raise ValueError(f"max_volume: it is above 0, and got {max_volume!r}")
    angle = (20.0 if min_angle is None else float(min_angle)) if quality_meshing else None
    is_refined = (quality_meshing or max_volume is not None or refinement_func is not None
                  or volume_constraints)
    if is_refined and not allow_volume_steiner:
        raise Unsupported("allow_volume_steiner=False: a mesh with bounds of angles or areas has new vertices "
                          "inside; quality_meshing=False without areas has none")
    graph = Graph(points, facets, holes, regions, is_refined=is_refined, angle=angle,
                  angle_name="min_angle", area=max_volume,
                  has_region_areas=volume_constraints,
                  unsplit="" if allow_boundary_steiner else "border", needs_refinement=refinement_func)
    return _result(mesh_info, graph, Planar(graph), (point_markers, facet_markers), attributes=attributes,
                   faces=bool(generate_faces or generate_edges), neighbours=generate_neighbor_lists,
                   order=mesh_order or 1)


def refine(input_p: MeshInfo, verbose: bool = False, refinement_func: Refinement = None,
           quality_meshing: bool = True, min_angle: Optional[float] = None,
           generate_neighbor_lists: bool = False) -> MeshInfo:
    """A finer mesh with the vertices and segments of a mesh.

    Args:
        input_p: the mesh; its `element_volumes`, if they are allocated, are the largest areas in its
            triangles.
        verbose: has no effect.
        refinement_func: as of `build`.
        quality_meshing: with a least angle.
        min_angle: as of `build`.
        generate_neighbor_lists: the mesh has `neighbors`.

    Raises as `build` does.
    """
    points, facets, point_markers, facet_markers = _description(input_p)
    triangles = indices_of(np.asarray(input_p.elements)[:, :3] if len(input_p.elements) else None,
                           "elements", 3, len(points))
    if len(triangles) == 0:
        raise ValueError("input_p: it has no elements to be refined")
    flipped = _topology.measures_of(points, triangles) < 0
    triangles = np.where(flipped[:, None], triangles[:, [0, 2, 1]], triangles)
    areas = np.array(input_p.element_volumes) if input_p.element_volumes.allocated else None
    angle = (20.0 if min_angle is None else float(min_angle)) if quality_meshing else None
    none = np.zeros((0, 4))
    graph = Graph(points, facets, none[:, :2], none, angle=angle, angle_name="min_angle",
                  triangles=triangles, triangle_areas=areas, needs_refinement=refinement_func)
    return _result(input_p, graph, Planar(graph), (point_markers, facet_markers), attributes=False,
                   faces=False, neighbours=generate_neighbor_lists, order=1)


def subdivide_facets(subdivisions: Union[int, Iterable[int]], points: Any, facets: Any,
                     facet_markers: Optional[Iterable[int]] = None) -> tuple[Any, ...]:
    """Segments cut into equal parts, for borders that get no other vertices.

    Args:
        subdivisions: the number of parts, of all segments or of each.
        points: coordinates of vertices.
        facets: segments, pairs of their numbers.
        facet_markers: a number for each segment.

    Returns:
        Lists of points, the given ones first, and of segments; with `facet_markers` of markers, too.
    """
    pairs = [tuple(pair) for pair in facets]
    counts = ([subdivisions] * len(pairs) if isinstance(subdivisions, (int, np.integer))
              else list(subdivisions))
    if len(counts) != len(pairs) or any(count < 1 for count in counts):
        raise ValueError(f"subdivisions: a number from 1, or {len(pairs)} of them, and got {subdivisions!r}")
    new_points = [tuple(point) for point in points]
    markers = None if facet_markers is None else list(facet_markers)
    new_facets: list[tuple[int, int]] = []
    new_markers: list[int] = []
    for row, ((a, b), count) in enumerate(zip(pairs, counts)):
        begin, end = np.asarray(new_points[a], float), np.asarray(new_points[b], float)
        chain = [a, *range(len(new_points), len(new_points) + count - 1), b]
        new_points += [tuple((begin + (end - begin) * i / count).tolist()) for i in range(1, count)]
        new_facets += list(zip(chain, chain[1:]))
        if markers is not None:
            new_markers += [markers[row]] * count
    if markers is None:
        return new_points, new_facets
    return new_points, new_facets, new_markers


def write_gnuplot_mesh(filename: str, out_p: MeshInfo, facets: bool = False) -> None:
    """Writes the outlines of a mesh's triangles as text for gnuplot.

    Args:
        filename: the file; an old one is replaced.
        out_p: the mesh.
        facets: its segments instead.
    """
    points = np.asarray(out_p.points)
    rows = np.asarray(out_p.facets) if facets else np.asarray(out_p.elements)[:, [0, 1, 2, 0]]
    with open(filename, "w", encoding="ascii") as file:
        for row in rows:
            file.write("".join(f"{x!r} {y!r}\n" for x, y in points[row].tolist()) + "\n")
