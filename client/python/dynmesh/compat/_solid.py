"""Quality meshes of solids between facets: what `meshpy.tet` and `tetgen` have in common."""
from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from dynmesh._types import Array
from dynmesh.compat import _topology
from dynmesh.compat._domain import Cut, Domain, bounds_of, check_count, max_edge_of
from dynmesh.compat._errors import Unsupported
from dynmesh.errors import FailedPrecondition, InvalidArgument

#: The least bound of circumradius / shortest edge that a mesh with facets keeps.
LEAST_RATIO = 1.4
#: The least dihedral angle of a mesh by default, degrees: TetGen removes slivers without being asked, too.
CURED = 10.0
_WITHOUT_EFFECT = "CVQzTOJNEFGKBILD"
_REFUSED = {
    "j": "vertices that no facet has are vertices of the mesh: leave them out of the input",
    "r": "a mesh is not refined here: give the facets, and a smaller volume",
    "Y": "facets get vertices: there are no borders that stay whole in three dimensions",
    "c": "the convex hull is not enclosed: give its facets",
    "d": "facets that cross are told by the error of a mesh, and mended by dynmesh.read_surface(path)",
    "v": "there is no Voronoi diagram here", "w": "there are no weighted triangulations",
    "m": "sizes of vertices: a mesh of dynmesh.open has add_sizes",
    "R": "a mesh is not made coarser here", "g": "no file is written: dynmesh.Mesh.write writes many",
    "k": "no file is written: dynmesh.Mesh.write writes .vtu", "X": "predicates are exact",
    "s": "facets get vertices only where they need them",
}
_NUMBER = re.compile(r"\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+(?:[eE][-+]?\d+)?")


@dataclass
class SolidSwitches:
    """What a string of TetGen's switches asks for."""

    has_facets: bool = False  # p
    ratio: Optional[float] = None  # q
    angle: Optional[float] = None  # q…/angle
    volume: Optional[float] = None  # a with a number
    has_volumes: bool = False  # a without one
    attributes: bool = False  # A
    merges: bool = True  # not M
    most_new: Optional[int] = None  # S
    order: int = 1  # o2
    edges: bool = False  # e
    neighbours: bool = False  # n
    adds_points: bool = False  # i


def parse(switches: str) -> SolidSwitches:
    """Reads TetGen's switches; raises ValueError and Unsupported with the switch."""
    if not isinstance(switches, str):
        raise TypeError(f"switches: a string, as 'pq1.5/10a0.1', and got {switches!r}")
    result = SolidSwitches()
    at = 0

    def number() -> Optional[float]:
        nonlocal at
        found = _NUMBER.match(switches, at)
        if found is None:
            return None
        at = found.end()
        return float(found.group())

    while at < len(switches):
        letter = switches[at]
        at += 1
        if letter == "-" and at == 1 or letter == " ":
            continue
        if letter in _REFUSED:
            raise Unsupported(f"the switch {letter}: {_REFUSED[letter]}")
        if letter == "p":
            result.has_facets = True
        elif letter == "q":
            value = number()
            result.ratio = 2.0 if value is None else value
            while switches[at:at + 1] == "/":
                at += 1
                result.angle = number()
        elif letter == "a":
            value = number()
            if value is None:
                result.has_volumes = True
            elif value <= 0:
                raise ValueError("switches: the volume after a is above 0")
            else:
                result.volume = value
        elif letter == "A":
            result.attributes = True
        elif letter == "M":
            result.merges = False
            number()
        elif letter == "S":
            result.most_new = int(number() or 0)
        elif letter == "o":
            order = number()
            if order not in (1, 2):
                raise ValueError("switches: o2 makes tetrahedra of ten nodes, o1 of four")
            result.order = int(order)
        elif letter == "e":
            result.edges = True
        elif letter == "n":
            result.neighbours = True
            while switches[at:at + 1] == "n":
                at += 1
        elif letter == "i":
            result.adds_points = True
        elif letter == "f":
            pass
        elif letter in _WITHOUT_EFFECT:
            number()
            while switches[at:at + 1] == "/":
                at += 1
                number()
        else:
            raise ValueError(f"switches: there is no switch {letter!r} (in {switches!r})")
    return result


@dataclass
class Body:
    """Facets and what is asked of the mesh between them."""

    points: Array
    facets: Sequence[Sequence[Sequence[int]]]  #: Rings of vertices, the outer one first
    markers: Optional[Array]  #: A number for each facet
    holes: Array  #: A place in each
    regions: Array  #: x, y, z, attribute, largest volume (not above 0: none)
    ratio: float = 2.0
    angle: float = 0.0  #: The least dihedral angle, degrees; below `CURED` that
    volume: Optional[float] = None
    has_region_volumes: bool = False
    merges: bool = True  #: Facets in one plane are joined
    most_new: Optional[int] = None


class Solid:
    """The mesh of a body."""

    def __init__(self, body: Body) -> None:
        if not body.ratio >= LEAST_RATIO:
            raise Unsupported(f"the switch q, minratio: circumradius / shortest edge is {body.ratio:g}, and "
                              f"dynmesh keeps {LEAST_RATIO} and above: ask for q{LEAST_RATIO}")
        if not 0 <= body.angle <= 20:
            raise Unsupported(f"the switch q, mindihedral: the least dihedral angle is {body.angle:g}, and "
                              "dynmesh has bounds up to 20 degrees")
        if len(body.facets) == 0:
            raise ValueError("facets: there are none, and a mesh is between facets")
        self.body = body
        facets = body.facets
        markers = np.ones(len(facets), np.int32) if body.markers is None else body.markers
        if body.merges:
            facets, markers = merged(body.points, facets, markers)
        self._markers = markers
        try:
            self._domain = Domain(
                body.points, facets, dict(rho=min(body.ratio, 100.0), min_dihedral=max(body.angle, CURED),
                                          max_edge=max_edge_of(body.volume, 3)))
            self.cut: Cut = self._domain.refine(
                lambda: self._domain.cut(body.holes, body.regions[:, :3]), self._bounds)
        except (FailedPrecondition, InvalidArgument) as error:
            if error.reason:
                error.args = (f"{error}; points are the given ones from 1 on, facets follow; a surface file "
                              "is mended by dynmesh.read_surface(path)",)
            raise
        check_count(self.cut, body.most_new, "the switch S")

    def _bounds(self, cut: Cut) -> Array:
        body = self.body
        return bounds_of(cut, body.volume, body.regions[:, 4] if body.has_region_volumes else None)

    def attributes(self) -> Array:
        """Of each tetrahedron that of its region; parts without one have numbers above all of these."""
        cut = self.cut
        result = np.append(self.body.regions[:, 3], 0.0)[cut.regions]
        faces = _topology.faces_of(cut.cells)
        face_keys, facet_keys = _topology.common_keys(faces.reshape(-1, 3), cut.facets, len(cut.points))
        blocked = np.isin(face_keys, facet_keys).reshape(cut.cells.shape)
        number = max(0.0, float(np.max(self.body.regions[:, 3], initial=0.0)))
        left = cut.regions < 0
        while left.any():
            number += 1
            part = _topology.flood(cut.neighbours, blocked, np.flatnonzero(left)[:1])
            result[part] = number
            left &= ~part
        return result

    def facet_markers(self) -> Array:
        """Of each face of `cut.facets` that of the facet; 1 if facets have none."""
        result: Array = self._markers[self.cut.facet_owners].astype(np.int32)
        return result

    def vertex_markers(self, given: Array) -> Array:
        """Those that are given, then that of a facet that a vertex is on, else 0.

        Args:
            given: a number for each input vertex.
        """
        result = np.zeros(len(self.cut.points), np.int32)
        result[self.cut.facets] = self.facet_markers()[:, None]
        result[:len(given)] = np.where(given != 0, given, result[:len(given)])
        return result


def merged(points: Array, facets: Sequence[Sequence[Sequence[int]]], markers: Array,
           ) -> tuple[Sequence[Sequence[Sequence[int]]], Array]:
    """Facets of one ring that share an edge, lie in one plane and have one marker, joined.

    All vertices stay corners: a facet comes to others over one edge, with corners that they do not have.
    """
    at_edge: dict[frozenset[int], list[int]] = {}
    planes = []
    for number, rings in enumerate(facets):
        ring = list(rings[0])
        corners = points[ring]
        normal = np.cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0]).sum(axis=0)
        size = float(np.linalg.norm(normal))
        planes.append((size, normal / size if size else normal, corners[0]))
        for pair in zip(ring, ring[1:] + ring[:1]):
            at_edge.setdefault(frozenset(pair), []).append(number)
    done = [len(rings) != 1 or planes[i][0] == 0 for i, rings in enumerate(facets)]
    result: list[Sequence[Sequence[int]]] = []
    of: list[int] = []
    for seed in sorted(range(len(facets)), key=lambda i: -planes[i][0]):
        if done[seed]:
            continue
        size, normal, origin = planes[seed]
        near = 1e-11 * size**0.5
        group, front, corners_of = {seed}, [seed], set(facets[seed][0])
        for number in front:
            ring = list(facets[number][0])
            for pair in zip(ring, ring[1:] + ring[:1]):
                edge = frozenset(pair)
                if len(at_edge[edge]) != 2:
                    continue
                for other in at_edge[edge]:
                    if (other not in group and not done[other] and markers[other] == markers[seed]
                            and corners_of & set(facets[other][0]) == edge
                            and np.abs((points[list(facets[other][0])] - origin) @ normal).max() <= near):
                        group.add(other)
                        front.append(other)
                        corners_of |= set(facets[other][0])
        for number in group:
            done[number] = True
        result.append([_outline([list(facets[i][0]) for i in group])] if len(group) > 1 else facets[seed])
        of.append(seed)
    rest = [i for i, rings in enumerate(facets) if len(rings) != 1 or planes[i][0] == 0]
    return result + [facets[i] for i in rest], markers[np.array(of + rest, np.int64)]


def _outline(faces: list[list[int]]) -> list[int]:
    """The ring around faces that hang together by single edges."""
    count: dict[frozenset[int], int] = {}
    for ring in faces:
        for pair in zip(ring, ring[1:] + ring[:1]):
            edge = frozenset(pair)
            count[edge] = count.get(edge, 0) + 1
    beside: dict[int, list[int]] = {}
    for edge, times in count.items():
        if times == 1:
            a, b = edge
            beside.setdefault(a, []).append(b)
            beside.setdefault(b, []).append(a)
    start = faces[0][0]
    ring, before, at = [start], start, beside[start][0]
    while at != start:
        ring.append(at)
        one, two = beside[at]
        before, at = at, (two if one == before else one)
    return ring


#: The corners between which the nodes of a tetrahedron are, after the corners.
ORDER_OF_TETGEN = (2, 3), (0, 3), (0, 1), (1, 2), (1, 3), (0, 2)
ORDER_OF_VTK = (0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)


def with_middles(points: Array, cells: Array, order_of: Sequence[tuple[int, int]]) -> tuple[Array, Array]:
    """Tetrahedra of ten nodes: corners, then middles of edges in the order of `order_of`."""
    edges = _topology.edges_of(cells)
    pairs = np.concatenate([cells[:, pair] for pair in order_of])
    edge_keys, pair_keys = _topology.common_keys(edges, pairs, len(points))
    order = np.argsort(edge_keys)
    of = order[np.searchsorted(edge_keys[order], pair_keys)].reshape(6, -1).T
    return (np.concatenate([points, points[edges].mean(axis=1)]),
            np.concatenate([cells, len(points) + of], axis=1).astype(np.int32))


def write_vtk(path: Any, points: Array, cells: Array) -> None:
    """Writes tetrahedra of four or ten nodes as a legacy .vtk file, text."""
    width = cells.shape[1]
    rows = itertools.chain(
        ["# vtk DataFile Version 2.0", "dynmesh", "ASCII", "DATASET UNSTRUCTURED_GRID",
         f"POINTS {len(points)} double"],
        (" ".join(map(repr, row)) for row in points.tolist()),
        [f"CELLS {len(cells)} {len(cells) * (width + 1)}"],
        (f"{width} " + " ".join(map(str, row)) for row in cells.tolist()),
        [f"CELL_TYPES {len(cells)}"], ["10" if width == 4 else "24"] * len(cells))
    with open(path, "w", encoding="ascii") as file:
        file.writelines(row + "\n" for row in rows)


__all__ = ["Body", "LEAST_RATIO", "ORDER_OF_TETGEN", "ORDER_OF_VTK", "Solid", "SolidSwitches", "merged", "parse",
           "with_middles", "write_vtk"]
