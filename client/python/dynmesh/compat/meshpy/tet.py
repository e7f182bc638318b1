"""The interface of `meshpy.tet` on dynmesh::

    from dynmesh.compat.meshpy.tet import MeshInfo, build     # was: from meshpy.tet import …
    info = MeshInfo()
    info.set_points([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0),
                     (0, 0, 12), (2, 0, 12), (2, 2, 12), (0, 2, 12)])
    info.set_facets([[0, 1, 2, 3], [4, 5, 6, 7], [0, 4, 5, 1],
                     [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]])
    mesh = build(info, max_volume=0.5)
    mesh.points, mesh.elements

docs/compat.md has what is the same and what differs.
"""
from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Optional

import numpy as np

from dynmesh._types import Array
from dynmesh.compat import _solid, _topology
from dynmesh.compat._domain import array_of
from dynmesh.compat._errors import Unsupported
from dynmesh.compat.meshpy._arrays import Arrays, ForeignArray

__all__ = ["Facet", "MeshInfo", "Options", "Polygon", "build"]


class Polygon:
    """A ring of vertices of a facet."""

    def __init__(self, vertices: Iterable[int]) -> None:
        #: Numbers of vertices.
        self.vertices: list[int] = [int(vertex) for vertex in vertices]


class Facet:
    """A plane facet: polygons, of which the first is its outline, and places in its holes."""

    def __init__(self, polygons: Iterable[Iterable[int]], holes: Iterable[Any] = ()) -> None:
        #: The rings.
        self.polygons: list[Polygon] = [Polygon(vertices) for vertices in polygons]
        #: A place in each hole of the facet.
        self.holes: list[Any] = [list(place) for place in holes]


class Facets:
    """The facets of a description; a list that cannot be set by rows."""

    def __init__(self) -> None:
        self._facets: list[Facet] = []

    def __len__(self) -> int:
        return len(self._facets)

    def __getitem__(self, index: int) -> Facet:
        return self._facets[index]

    def __iter__(self) -> Iterator[Facet]:
        return iter(self._facets)


class MeshInfo(Arrays):
    """Facets in space, or a mesh of tetrahedra. Members are arrays of rows, but for `facets`."""

    def __init__(self) -> None:
        #: x, y, z of each vertex.
        self.points = ForeignArray(np.float64, 3)
        #: A number for each vertex.
        self.point_markers = ForeignArray(np.int32, 1, self.points)
        #: Values of vertices. A mesh of tetrahedra has none: `Unsupported` if they are set.
        self.point_attributes = ForeignArray(np.float64, 1, self.points)
        #: The corners of tetrahedra; with the switch o2 the middles of 23, 03, 01, 12, 13, 02 after them.
        self.elements = ForeignArray(np.int32, 4)
        #: Of a mesh that was built with `attributes`: the attribute of each tetrahedron's region.
        self.element_attributes = ForeignArray(np.float64, 1, self.elements)
        #: The tetrahedron opposite to each corner, -1 at the border, with the switch n.
        self.neighbors = ForeignArray(np.int32, 4)
        #: The facets of the input.
        self.facets = Facets()
        #: A number for each facet.
        self.facet_markers = ForeignArray(np.int32, 1, self.facets)  # type: ignore[arg-type]
        #: A place in each hole.
        self.holes = ForeignArray(np.float64, 3)
        #: Of each region a place, an attribute and a largest volume.
        self.regions = ForeignArray(np.float64, 5)
        #: Triangles of a mesh on the input's facets.
        self.faces = ForeignArray(np.int32, 3)
        #: A number for each of them.
        self.face_markers = ForeignArray(np.int32, 1, self.faces)
        #: Edges of a mesh, with the switch e.
        self.edges = ForeignArray(np.int32, 2)

    def set_facets(self, facets: Iterable[Any], markers: Optional[Iterable[int]] = None) -> None:
        """Sets the facets.

        Args:
            facets: rings of numbers of vertices, each in one plane.
            markers: a number for each of them.
        """
        self.set_facets_ex([[ring] for ring in facets], None, markers)

    def set_facets_ex(self, facets: Iterable[Any], facet_holestarts: Optional[Iterable[Any]] = None,
                      markers: Optional[Iterable[int]] = None) -> None:
        """Sets facets of several rings.

        Args:
            facets: lists of rings of numbers of vertices, the outer one first.
            facet_holestarts: for each facet a list of places in its holes.
            markers: a number for each facet.
        """
        rows = [list(rings) for rings in facets]
        holes = [[] for _ in rows] if facet_holestarts is None else list(facet_holestarts)
        if len(holes) != len(rows):
            raise ValueError(f"facet_holestarts: {len(rows)} lists, and got {len(holes)}")
        self.facets._facets = [Facet(rings, places) for rings, places in zip(rows, holes)]
        self._mark(self.facet_markers, markers, len(rows), "markers")

    @property
    def face_vertex_indices_to_face_marker(self) -> dict[frozenset[int], int]:
        """The number of each of `faces`, by the set of its corners."""
        return {frozenset(row): marker for row, marker in zip(self.faces, self.face_markers)}

    def write_vtk(self, filename: str) -> None:
        """Writes the tetrahedra as a legacy .vtk file.

        Args:
            filename: the file; an old one is replaced.
        """
        cells = np.asarray(self.elements)
        if cells.shape[1] == 10:
            order = [_solid.ORDER_OF_TETGEN.index(pair) for pair in _solid.ORDER_OF_VTK]
            cells = np.concatenate([cells[:, :4], cells[:, 4:][:, order]], axis=1)
        _solid.write_vtk(filename, np.asarray(self.points), cells)


#: Members of TetGen's options: of those that are supported the values that there are without them.
_DEFAULTS: dict[str, Any] = {
    "plc": False, "quality": False, "minratio": 2.0, "mindihedral": 0.0, "varvolume": False,
    "fixedvolume": False, "maxvolume": -1.0, "regionattrib": False, "insertaddpoints": False,
    "nomerge": False, "order": 1, "edgesout": False, "neighout": False, "nojettison": False,
    "steinerleft": -1}
_WITHOUT_EFFECT = ("quiet", "verbose", "docheck", "zeroindex", "facesout", "epsilon", "optlevel", "optpasses",
                   "nobound", "nonodewritten", "noelewritten", "nofacewritten", "noiterationnum", "btree",
                   "max_btreenode_size", "noexact", "alpha1", "alpha2", "alpha3", "goodratio", "minangle",
                   "goodangle", "maxdihedral")
_REFUSED = {"refine": "r", "nobisect": "Y", "diagnose": "d", "voroout": "v", "metric": "m", "coarse": "R",
            "conformdel": "s", "convex": "c", "weighted": "w", "nobisect_param": "Y"}


class Options:
    """What is asked of a mesh: TetGen's switches, and members that have their names.

    Args:
        switches: as "pq1.5/10a0.1"; see `parse_switches`.
        kwargs: members by name, as `maxvolume=0.1`.
    """

    def __init__(self, switches: str = "pq", **kwargs: Any) -> None:
        self.__dict__.update(_DEFAULTS)
        self.__dict__.update({name: False for name in (*_WITHOUT_EFFECT, *_REFUSED)})
        self.parse_switches(switches)
        for name, value in kwargs.items():
            setattr(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self.__dict__:
            raise AttributeError(f"options have no member {name!r}")
        if name in _REFUSED and value:
            raise Unsupported(f"{name}: {_solid._REFUSED[_REFUSED[name]]}")
        self.__dict__[name] = value

    def parse_switches(self, switches: str) -> None:
        """Sets members by switches.

        Args:
            switches: p: facets count. q1.5/10: the largest circumradius / shortest edge (from 1.4; 2
                without a number) and the least dihedral angle (10 to 20 degrees). a0.1: the largest volume;
                a: those of regions. A: attributes. M: facets in one plane are not joined. S100: an error if
                more new vertices are needed. o2: ten nodes. e: edges. n: neighbours. i: further points.
        """
        parsed = _solid.parse(switches)
        members = self.__dict__
        members["plc"] |= parsed.has_facets
        members["quality"] |= parsed.ratio is not None
        members["minratio"] = parsed.ratio or members["minratio"]
        members["mindihedral"] = members["mindihedral"] if parsed.angle is None else parsed.angle
        members["fixedvolume"] |= parsed.volume is not None
        members["maxvolume"] = parsed.volume or members["maxvolume"]
        members["varvolume"] |= parsed.has_volumes
        members["regionattrib"] |= parsed.attributes
        members["insertaddpoints"] |= parsed.adds_points
        members["nomerge"] |= not parsed.merges
        members["order"] = max(parsed.order, members["order"])
        members["edgesout"] |= parsed.edges
        members["neighout"] |= parsed.neighbours
        members["steinerleft"] = members["steinerleft"] if parsed.most_new is None else parsed.most_new


def _rings(facet: Facet, number: int, points: Array) -> list[list[int]]:
    """The polygon's rings."""
    rings = [polygon.vertices for polygon in facet.polygons]
    if not rings or len(rings[0]) < 3:
        raise ValueError(f"facets: facet {number} has no polygon of three vertices")
    if min(map(len, rings)) < 3:
        raise Unsupported(f"facets: facet {number} has a polygon of two vertices, a segment in it: "
                          "cut the facet along the segment")
    if len(rings) - 1 != len(facet.holes):
        raise Unsupported(f"facets: facet {number} has {len(rings)} polygons and {len(facet.holes)} holes: "
                          "each polygon but the first is the border of a hole; make others facets of "
                          "their own")
    wrong = [vertex for ring in rings for vertex in ring if not 0 <= vertex < len(points)]
    if wrong:
        raise ValueError(f"facets: facet {number} has vertex {wrong[0]}, and vertices are 0 to "
                         f"{len(points) - 1}")
    return rings


def build(mesh_info: MeshInfo, options: Optional[Options] = None, verbose: bool = False,
          attributes: bool = False, volume_constraints: bool = False,
          max_volume: Optional[float] = None, diagnose: bool = False,
          insert_points: Optional[MeshInfo] = None) -> MeshInfo:
    """The mesh between facets.

    Args:
        mesh_info: the facets, holes and regions.
        options: `Options("pq")` if None.
        verbose: has no effect.
        attributes: `element_attributes` of the mesh are those of regions; other parts get numbers above.
        volume_constraints: the volumes of regions count.
        max_volume: the largest volume of a tetrahedron.
        diagnose: `Unsupported`.
        insert_points: its points become vertices, too, after those of the facets.

    Returns:
        The mesh: points of the input first, in their order; `elements`, positively oriented; on facets
        `faces` with `face_markers`.

    Raises:
        ValueError: an array that cannot be meant, or nothing is left of the mesh.
        Unsupported: what dynmesh does not have.
        FailedPrecondition, InvalidArgument: facets that a mesh refuses, as those that cross.
    """
    options = options or Options()
    if diagnose:
        raise Unsupported(f"diagnose: {_solid._REFUSED['d']}")
    if not (options.__dict__["plc"] and options.__dict__["quality"]):
        raise Unsupported("options: tetrahedra without a bound of quality, and without facets, are not there: "
                          "use the switches pq")
    if mesh_info.point_attributes.allocated:
        raise Unsupported("point_attributes: they are not interpolated in three dimensions; "
                          "Diff.transfer of a mesh of dynmesh.open carries fields")
    if max_volume is not None and not max_volume > 0:
        raise ValueError(f"max_volume: it is above 0, and got {max_volume!r}")
    member = options.__dict__
    points = array_of(mesh_info.points, "points", 3)
    rows = [_rings(facet, number, points) for number, facet in enumerate(mesh_info.facets)]
    given = points
    if insert_points is not None:
        given = np.concatenate([points, array_of(insert_points.points, "insert_points", 3)])
    volume = max_volume
    if volume is None and member["maxvolume"] > 0:
        volume = float(member["maxvolume"])
    markers = np.array(mesh_info.facet_markers) if mesh_info.facet_markers.allocated else None
    solid = _solid.Solid(_solid.Body(
        given, rows, markers, array_of(mesh_info.holes, "holes", 3),
        array_of(mesh_info.regions, "regions", 5), ratio=float(member["minratio"]),
        angle=float(member["mindihedral"]), volume=volume,
        has_region_volumes=bool(volume_constraints or member["varvolume"]), merges=not member["nomerge"],
        most_new=None if member["steinerleft"] < 0 else int(member["steinerleft"])))
    return _result(mesh_info, solid, member, bool(attributes or member["regionattrib"]))


def _result(info: MeshInfo, solid: _solid.Solid, member: dict[str, Any], attributes: bool) -> MeshInfo:
    cut = solid.cut
    points, cells = cut.points, cut.cells
    point_markers = np.zeros(cut.inputs, np.int32)
    if info.point_markers.allocated:
        point_markers[:len(info.points)] = np.array(info.point_markers)
    all_markers = solid.vertex_markers(point_markers)
    if member["order"] == 2:
        points, cells = _solid.with_middles(points, cells, _solid.ORDER_OF_TETGEN)
        all_markers = np.concatenate([all_markers, np.zeros(len(points) - len(cut.points), np.int32)])
    mesh = MeshInfo()
    mesh.points._set(points)
    mesh.point_markers._set(all_markers)
    mesh.elements._set(cells, cells.shape[1])
    mesh.faces._set(cut.facets)
    mesh.face_markers._set(solid.facet_markers())
    mesh.holes._set(solid.body.holes)
    mesh.regions._set(solid.body.regions)
    if attributes:
        mesh.element_attributes._set(solid.attributes())
    if member["neighout"]:
        mesh.neighbors._set(cut.neighbours)
    if member["edgesout"]:
        mesh.edges._set(_topology.edges_of(cut.cells))
    return mesh
