"""The interface of the package `triangle`, the Python interface of Triangle, on dynmesh::

    import dynmesh.compat.triangle as tr                # was: import triangle as tr
    square = dict(vertices=[(0, 0), (1, 0), (1, 1), (0, 1)],
                  segments=[(0, 1), (1, 2), (2, 3), (3, 0)])
    mesh = tr.triangulate(square, "pq30a0.01")
    mesh["vertices"], mesh["triangles"]

docs/compat.md has what is the same and what differs.
"""
from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from dynmesh._types import Array
from dynmesh.compat import _topology
from dynmesh.compat._domain import array_of, indices_of
from dynmesh.compat._errors import Unsupported
from dynmesh.compat._planar import Graph, Planar, marks_of, with_middles

__all__ = ["compare", "convex_hull", "delaunay", "plot", "triangulate", "voronoi"]

_KEYS = ("vertices", "vertex_attributes", "vertex_markers", "segments", "segment_markers", "holes",
         "regions", "triangles", "triangle_attributes", "triangle_max_area", "neighbors", "edges",
         "edge_markers")
#: Switches that concern printing, speed, numbering, or ways to the same mesh.
_WITHOUT_EFFECT = "QVzXiFlCIs"
_REFUSED = {
    "u": "a user's own bound is a function: use `dynmesh.compat.meshpy.triangle.build` with "
         "refinement_func=, or `triangle_max_area` with the switches r and a",
    "v": "the Voronoi diagram of points is `voronoi(points)`",
    "g": "no file is written here: `dynmesh.Mesh.write` writes .off and others",
    "k": "there is no such switch", "W": "there is no such switch",
}
_NUMBER = re.compile(r"\d+\.?\d*|\.\d+")


@dataclass
class _Switches:
    """What a string of switches asks for."""

    letters: set[str]
    angle: Optional[float] = None
    area: Optional[float] = None
    has_areas: bool = False  # a without a number
    unsplit: str = ""
    most_new: Optional[int] = None
    order: int = 1
    is_refined: bool = False


def _parse(opts: str) -> _Switches:
    if not isinstance(opts, str):
        raise TypeError(f"opts: switches are a string, as 'pq30a0.1', and got {opts!r}")
    result = _Switches(set())
    at = 0
    while at < len(opts):
        letter = opts[at]
        at += 1
        number = ""
        if letter in "qaSoYi" or letter in "IV":
            found = _NUMBER.match(opts, at) if letter in "qaSo" else None
            if found:
                number = found.group()
                at = found.end()
                if re.match(r"e[-+]", opts[at:]):
                    raise ValueError(f"opts: {letter}{number}{opts[at:at + 4]} is a number with an exponent, "
                                     "which switches do not have: write f'a{area:.12f}'")
        if letter == "-" and at == 1:
            continue
        if letter in _REFUSED:
            raise Unsupported(f"the switch {letter}: {_REFUSED[letter]}")
        if letter == "q":
            result.angle = float(number) if number else 20.0
        elif letter == "a":
            if number:
                result.area = float(number)
                if result.area <= 0:
                    raise ValueError("opts: the area after a is above 0")
            else:
                result.has_areas = True
        elif letter == "S":
            result.most_new = int(float(number)) if number else 0
        elif letter == "o":
            if number not in ("1", "2"):
                raise ValueError("opts: o2 makes triangles of six nodes, o1 of three")
            result.order = int(number)
        elif letter == "Y":
            result.unsplit = "all" if result.unsplit else "border"
        elif letter not in "prcDAenjBPNEO" + _WITHOUT_EFFECT:
            raise ValueError(f"opts: there is no switch {letter!r} (in {opts!r}); there are "
                             "p r q a c D S Y A e n o j B P N E O, and without effect "
                             + " ".join(_WITHOUT_EFFECT))
        result.letters.add(letter)
    letters = result.letters
    result.is_refined = bool(letters & set("qa")) or ("p" in letters and bool(letters & set("Ds")))
    return result


def _column(tri: Mapping[str, Any], name: str, rows: int, of: str) -> Array:
    """Markers, one for each row of `of`; 0 without them."""
    value = tri.get(name)
    if value is None:
        return np.zeros(rows, np.int32)
    markers = np.asarray(value).reshape(-1)
    if len(markers) != rows:
        raise ValueError(f"{name}: one for each row of {of}, {rows}, and got {len(markers)}")
    return markers.astype(np.int32)


def _table(tri: Mapping[str, Any], name: str, rows: int, of: str) -> Optional[Array]:
    value = tri.get(name)
    if value is None:
        return None
    table = np.asarray(value, np.float64)
    table = table.reshape(len(table), -1) if table.size else table.reshape(rows, 0)
    if len(table) != rows:
        raise ValueError(f"{name}: a row for each of {of}, {rows}, and got {len(table)}")
    return table


def _regions(value: Any) -> Array:
    if value is not None and np.size(value) and np.shape(value)[-1] == 3:
        value = np.concatenate([np.asarray(value, np.float64), np.zeros((len(value), 1))], axis=1)
    return array_of(value, "regions", 4)


def triangulate(tri: Mapping[str, Any], opts: str = "") -> dict[str, Any]:
    """A mesh of points, or of a planar straight-line graph.

    Args:
        tri: arrays by key. `vertices`: (n, 2). `vertex_attributes`: (n, k). `vertex_markers`: n.
            `segments`: (s, 2) numbers of vertices. `segment_markers`: s. `holes`: (h, 2), a place in each.
            `regions`: (r, 4), of each a place, an attribute and a largest area. With the switch r
            `triangles`: (t, 3), `triangle_attributes`: (t, k), and `triangle_max_area`: t, areas not above
            0 being none.
        opts: switches. p: segments, holes and regions count. q, q30: least angle, 20 by default, at most
            30. a0.1: largest area; a: those of `regions`, with r of `triangle_max_area`. r: refines
            `triangles`. c: the convex hull is enclosed. D: Delaunay, which meshes with q or a are anyway.
            Without q, a, D and s no new vertices.
            Y, YY: no new vertices on the border, on all segments. S100: an error if more new vertices are
            needed. A: `triangle_attributes` tell regions. e: edges. n: neighbours. o2: six nodes. j:
            vertices without a triangle are left out. B, P, N, E: no markers, segments, vertices, triangles.
            O: holes do not count. Q V z X i F l C I s have no effect.

    Returns:
        Arrays by key. `vertices` (n, 2): those of the input first, in their order. `vertex_markers` (n, 1).
        `vertex_attributes`, at new vertices linear in the input's triangulation. `triangles` (m, 3),
        counter-clockwise. With A `triangle_attributes`. With p or c `segments` and `segment_markers`. With e
        `edges` and `edge_markers`. With n `neighbors` (m, 3), opposite to each corner, -1: none. Numbers are
        int32.

    Raises:
        ValueError: an array or a switch that cannot be meant, or nothing is left of the mesh.
        Unsupported: a switch that dynmesh does not have, and angles above 30.
        FailedPrecondition: the input is none that a mesh accepts, as segments that cross.
        LimitExceeded: areas that cannot be kept beside segments that may not be split.
    """
    for key in tri:
        if key not in _KEYS:
            raise ValueError(f"tri: there is no key {key!r}; there are {', '.join(_KEYS)}")
    if tri.get("vertices") is None:
        raise ValueError("tri: vertices are missing")
    switches = _parse(opts)
    letters = switches.letters
    points = array_of(tri["vertices"], "vertices", 2)
    has_graph = "p" in letters
    segments = indices_of(tri.get("segments") if has_graph else None, "segments", 2, len(points))
    segment_markers = _column(tri if has_graph else {}, "segment_markers", len(segments), "segments")
    vertex_markers = _column(tri, "vertex_markers", len(points), "vertices")
    attributes = _table(tri, "vertex_attributes", len(points), "vertices")
    refines = "r" in letters
    old = indices_of(tri.get("triangles") if refines else None, "triangles", 3, len(points))
    if refines and not len(old):
        raise ValueError("opts: r refines a mesh, and there are no triangles")
    if refines:
        old = np.where((_topology.measures_of(points, old) < 0)[:, None], old[:, [0, 2, 1]], old)
    old_attributes = _table(tri, "triangle_attributes", len(old), "triangles") if refines else None
    areas = None
    if refines and switches.has_areas and tri.get("triangle_max_area") is not None:
        areas = np.asarray(tri["triangle_max_area"], np.float64).reshape(-1)
        if len(areas) != len(old):
            raise ValueError(f"triangle_max_area: one for each triangle, {len(old)}, and got {len(areas)}")
    regions = _regions(tri.get("regions") if has_graph else None)

    planar = None
    new_attributes = attributes
    if switches.is_refined or not refines:
        planar = Planar(Graph(
            points, segments,
            array_of(tri.get("holes") if has_graph and "O" not in letters else None, "holes", 2), regions,
            is_refined=switches.is_refined, angle=switches.angle, area=switches.area,
            has_region_areas=switches.has_areas,
            closes_hull=not refines and ("c" in letters or not has_graph), unsplit=switches.unsplit,
            most_new=switches.most_new, triangles=old, triangle_areas=areas))
        cut = planar.cut
        nodes, cells, facets, owners = cut.points, cut.cells, cut.facets, cut.facet_owners
        if attributes is not None:
            new_attributes = planar.attributes(attributes)
    else:  # r alone: it is as it is
        nodes, cells, facets = points, old.astype(np.int32), segments.astype(np.int32)
        owners = np.arange(len(segments))
    facet_markers = np.append(segment_markers, 0)[np.where(owners < len(segments), owners, -1)]
    marks = marks_of(nodes, cells, facets, facet_markers,
                     np.concatenate([vertex_markers, np.zeros(len(nodes) - len(points), np.int32)]))
    triangle_attributes = []
    if old_attributes is not None:
        triangle_attributes.append(old_attributes if planar is None
                                   else old_attributes[planar.old_triangles()])
    if "A" in letters and has_graph:
        triangle_attributes.append(planar.region_attributes() if planar is not None
                                   else np.zeros((len(cells), 1)))
    neighbours = _topology.neighbours_of(cells, len(nodes))
    edges, markers = marks.edges, marks.vertices
    if switches.order == 2:
        nodes, cells, new_attributes, markers = with_middles(nodes, cells, new_attributes, markers,
                                                             marks.edge_markers)
    if "j" in letters:
        used = np.zeros(len(nodes), bool)
        used[cells] = True
        number = (np.cumsum(used) - 1).astype(np.int32)
        nodes, markers, cells = nodes[used], markers[used], number[cells]
        facets, edges = number[facets], number[edges]
        new_attributes = None if new_attributes is None else new_attributes[used]

    result: dict[str, Any] = {}
    has_markers = "B" not in letters
    if "N" not in letters:
        result["vertices"] = nodes
        if new_attributes is not None:
            result["vertex_attributes"] = new_attributes
        if has_markers:
            result["vertex_markers"] = markers.reshape(-1, 1)
    if "E" not in letters:
        result["triangles"] = cells.astype(np.int32)
        if triangle_attributes:
            result["triangle_attributes"] = np.concatenate(triangle_attributes, axis=1)
    if letters & set("pc") and "P" not in letters:
        result["segments"] = facets.astype(np.int32)
        if has_markers:
            result["segment_markers"] = marks.segments.reshape(-1, 1)
    if "e" in letters:
        result["edges"] = edges
        if has_markers:
            result["edge_markers"] = marks.edge_markers.reshape(-1, 1)
    if "n" in letters:
        result["neighbors"] = neighbours
    return result


def convex_hull(pts: Any) -> Array:
    """The edges of the convex hull of points, counter-clockwise: (edges, 2), int32.

    Of `pts`, (n, 2), those that lie on it are ends of edges, those exactly between others too.
    """
    return _topology.hull_of(array_of(pts, "pts", 2))


def delaunay(pts: Any) -> Array:
    """The Delaunay triangulation of points `pts`, (n, 2): (triangles, 3), int32."""
    cells: Array = triangulate(dict(vertices=pts))["triangles"]
    return cells


def voronoi(pts: Any) -> tuple[Array, Array, Array, Array]:
    """The Voronoi diagram of points.

    Args:
        pts: (n, 2).

    Returns:
        Its vertices (n, 2); its finite edges as pairs of them; of the rays the vertices where they begin,
        and their directions, with the length of the points' edge that a ray bisects.
    """
    points = array_of(pts, "pts", 2)
    return dual_of(points, delaunay(points))


def dual_of(points: Array, triangles: Array) -> tuple[Array, Array, Array, Array]:
    """The Voronoi diagram that is dual to a Delaunay triangulation; returns the arrays of `voronoi`."""
    a, b, c = points[triangles].transpose(1, 0, 2)
    p, q = b - a, c - a
    scale = 2 * (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])
    pp, qq = (p * p).sum(axis=1), (q * q).sum(axis=1)
    centres = a + np.stack([q[:, 1] * pp - p[:, 1] * qq, p[:, 0] * qq - q[:, 0] * pp],
                           axis=1) / scale[:, None]
    near = _topology.neighbours_of(triangles, len(points))
    cell, corner = np.nonzero(near > np.arange(len(triangles))[:, None])
    edges = np.stack([cell, near[cell, corner]], axis=1).astype(np.int32)
    cell, corner = np.nonzero(near < 0)
    first, second = triangles[cell, (corner + 1) % 3], triangles[cell, (corner + 2) % 3]
    along = points[second] - points[first]
    return centres, edges, cell.astype(np.int32), np.stack([along[:, 1], -along[:, 0]], axis=1)


def plot(ax: Any, **kw: Any) -> None:
    """Draws the arrays of `triangulate` on axes of matplotlib.

    Args:
        ax: axes; only `plot`, `scatter` and `set_aspect` are called.
        kw: arrays by key: `vertices`, and those of `triangles`, `edges`, `segments`, `holes`, and of
            `regions` the places, that there are.
    """
    points = array_of(kw.get("vertices"), "vertices", 2)

    def lines(pairs: Array, style: str, width: float) -> None:
        gaps = np.full((len(pairs), 1, 2), np.nan)
        rows = np.concatenate([points[pairs], gaps], axis=1).reshape(-1, 2)
        ax.plot(rows[:, 0], rows[:, 1], style, linewidth=width)

    if kw.get("triangles") is not None and len(kw["triangles"]):
        lines(_topology.edges_of(np.asarray(kw["triangles"])[:, :3]), "k-", 0.7)
    elif kw.get("edges") is not None and len(kw["edges"]):
        lines(np.asarray(kw["edges"]), "k-", 0.7)
    if kw.get("segments") is not None and len(kw["segments"]):
        lines(np.asarray(kw["segments"]), "b-", 1.5)
    ax.scatter(points[:, 0], points[:, 1], s=6, color="k")
    for key, marker in (("holes", "x"), ("regions", "*")):
        if kw.get(key) is not None and len(kw[key]):
            places = np.asarray(kw[key], np.float64)
            ax.scatter(places[:, 0], places[:, 1], s=40, marker=marker, color="r")
    ax.set_aspect("equal")


def compare(plt: Any, A: Mapping[str, Any], B: Mapping[str, Any], figsize: tuple[float, float] = (6, 3),
            ) -> None:
    """Draws two dicts of arrays beside each other, as the input and its mesh.

    Args:
        plt: the module `matplotlib.pyplot`.
        A: drawn on the left.
        B: drawn on the right.
        figsize: of the figure, inches.
    """
    plt.figure(figsize=figsize)
    left = plt.subplot(121)
    plot(left, **A)
    right = plt.subplot(122, sharex=left, sharey=left)
    plot(right, **B)
    plt.tight_layout()
