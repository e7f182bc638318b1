"""Points of the thesis's experiments, as arrays of n x 3 or n x 2."""
from __future__ import annotations

import pathlib
from collections.abc import Sequence

import numpy as np


def line_and_circle(n: int) -> np.ndarray:
    """n/2 points on the unit circle and n/2 on its axis, evenly: their Delaunay tetrahedralization
    has a quadratic number of tetrahedra (Fig. 2.3)."""
    half = n // 2
    angle = np.arange(half) * 2 * np.pi / half
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(half)])
    height = -1 + 2 * (np.arange(n - half) + 0.5) / (n - half)
    line = np.column_stack([np.zeros((n - half, 2)), height])
    return np.vstack([circle, line])


def grid(side: int) -> np.ndarray:
    at = np.arange(side, dtype=float)
    return np.stack(np.meshgrid(at, at, at, indexing="ij"), axis=-1).reshape(-1, 3)


def uniform(n: int) -> np.ndarray:
    return np.random.default_rng(2).random((n, 3))


def shortest_first(n: int) -> np.ndarray:
    """n points in 2D (Fig. 2.2): on the y axis with gaps that grow a little, one at the off-center of
    the lowest gap, and two far enough to see all of the axis. A mesher that splits shortest edges
    first, in a triangulation of all points, changes a linear number of triangles at each step."""
    on_axis = n - 3
    gaps = 1 + 1e-3 * np.arange(on_axis - 1) / on_axis
    y = np.concatenate([[0], np.cumsum(gaps)])
    axis = np.column_stack([np.zeros(on_axis), y])
    # At ratio sqrt(2) a triangle with the lowest gap as its shortest edge is still good.
    ratio = np.sqrt(2)
    off_center = [ratio + np.sqrt(ratio**2 - 0.25), gaps[0] / 2]
    far = [[on_axis**2 / 2.0, 0], [on_axis**2 / 2.0, y[-1]]]
    return np.vstack([axis, [off_center], far])


def cluster(n: int) -> np.ndarray:
    """All but two of the points in a box of side 2^-30 (Fig. 3.1)."""
    points = 0.7 + np.random.default_rng(2).random((n, 3)) * 2.0**-30
    points[0], points[1] = 0, 1
    return points


def read_node(path: pathlib.Path) -> np.ndarray:
    """The points of a 3D .node file."""
    with open(path, encoding="ascii") as file:
        count = int(file.readline().split()[0])
        return np.loadtxt(file, max_rows=count, comments="#")[:, 1:4]


def write_node(path: pathlib.Path, points: np.ndarray) -> None:
    rows = [f"{len(points)} {points.shape[1]} 0 0"]
    rows += [" ".join([str(i + 1), *map(repr, point)]) for i, point in enumerate(points.tolist())]
    path.write_text("\n".join(rows) + "\n", encoding="ascii")


def write_poly_in_cube(path: pathlib.Path, points: np.ndarray,
                       polygons: Sequence[Sequence[int]] = ()) -> None:
    """The points, and polygons by the points' numbers from 0, in a cube of 8 times the points'
    extent, about as dynmesh's domain: for TetGen."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    half = 4 * (points.max(axis=0) - points.min(axis=0)).max()
    corners = np.array([[middle[k] + (half if i >> k & 1 else -half) for k in range(3)]
                        for i in range(8)])
    rows = [f"{len(points) + 8} 3 0 0"]
    rows += [f"{i + 1} {x!r} {y!r} {z!r}"
             for i, (x, y, z) in enumerate([*corners.tolist(), *points.tolist()])]
    facets = [(1, 2, 4, 3), (5, 6, 8, 7), (1, 2, 6, 5), (3, 4, 8, 7), (1, 3, 7, 5), (2, 4, 8, 6),
              *(tuple(9 + i for i in polygon) for polygon in polygons)]
    rows.append(f"{len(facets)} 0")
    for facet in facets:
        rows += ["1 0", " ".join(map(str, (len(facet), *facet)))]
    path.write_text("\n".join([*rows, "0", ""]), encoding="ascii")
