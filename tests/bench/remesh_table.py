#!/usr/bin/env python3
"""One step of a moving feature: dynmesh with its transfer, and the usual way, which remeshes from
scratch and interpolates. Writes RESULTS.md.

    tests/bench/remesh_table.py [--quick] [--steps 10] [--triangle PROGRAM] [--out RESULTS.md]

Features: a disc (in 3D a ball) in which the mesh is finer; a point that is to be a vertex.
Usual ways: dynmesh from scratch, and Gmsh, TetGen and Triangle where they are installed. Values are
those of the old mesh's linear functions, whose cells are found by walks (`walk`). A way is skipped if
a step would take longer than a minute and a half, and the table says so. A complete run takes half an
hour.
"""
from __future__ import annotations

import argparse
import math
import pathlib
import sys
import time
from dataclasses import dataclass
from typing import Any, TextIO

import numpy as np
from scipy.spatial import cKDTree

import dynmesh
from other_meshers import Arrays, Mesher, Scene, installed
from results_page import sections_of

MOST_SECONDS = 90.0  # of a step, foreseen from that of the size before
SIZES = {2: [0.0103, 0.00325, 0.00103], 3: [0.067, 0.0246]}  # targets of edges

BEFORE = """\
# One step of a moving feature

What an edit costs when the program's field comes along, beside the usual way: mesh anew, then
interpolate. `tests/bench/remesh_table.py` writes this page.

The field is `2 + sin(5x + 1) cos(4y)`, linear between vertices (P1). A row is the median of the steps on
a shared machine: trust ratios, not digits. Ratios are of both times together. There are ten steps, of the usual ways fewer where the mesh is
large, and none where a step would take longer than 90 s. Ratios are to dynmesh with its transfer. Drift is
that of the integral, relative, after all steps; the error is in L2, against the field itself. "dynmesh
anew" meshes the same features from scratch, so it shows what the local edit saves. Gmsh is called in
process. TetGen and Triangle are programs that read and write files, which numpy reads; to have edges as
short they make more cells than the others. All take values by a walk in the cells of the old mesh, from
one at the nearest old vertex, for all new vertices at once (numpy; scipy's tree of points).
"""

AFTER = """\
A point's step does not grow with the mesh; meshing anew does. A disc that is always finer changes as many
cells as lie in what it sweeps over and along its border, and these grow with the mesh: there the ratio is
that of the mesh to the swept part.
"""


def field(x: np.ndarray) -> np.ndarray:
    return 2 + np.sin(5 * x[..., 0] + 1) * np.cos(4 * x[..., 1])


@dataclass
class Row:
    way: str
    mesh: float  # seconds
    values: float
    drift: float
    error: float
    kept: float

    @property
    def seconds(self) -> float:
        return self.mesh + self.values

    def text(self, first: Row) -> str:
        return (f"{self.way} | {1e3 * self.mesh:.4g} | {1e3 * self.values:.4g} | "
                f"{self.seconds / first.seconds:,.0f} | "
                f"{self.drift:.1e} | {self.error:.3e} | {100 * self.kept:.1f} %")


class Plain:
    """Points, cells and values without slots."""

    def __init__(self, points: np.ndarray, cells: np.ndarray, u: np.ndarray) -> None:
        self.points, self.cells, self.u = points, cells, u

    def measures(self) -> np.ndarray:
        corners = self.points[self.cells]
        edges = corners[:, 1:] - corners[:, :1]
        return np.abs(np.linalg.det(edges)) / math.factorial(self.points.shape[1])

    def keys(self) -> np.ndarray:
        """A number for each cell, of the places of its corners in any order."""
        bits = np.ascontiguousarray(self.points).view(np.uint64)
        mixed = np.zeros(len(self.points), np.uint64)
        for column in bits.T:
            mixed = (mixed ^ column) * np.uint64(0x9E3779B97F4A7C15)
            mixed ^= mixed >> np.uint64(29)
        return np.unique(mixed[self.cells].sum(axis=1, dtype=np.uint64))

    def mass(self) -> float:
        return math.fsum(self.measures() * self.u[self.cells].mean(axis=1))

    def error(self) -> float:
        """L2 within the box, at the middles of edges."""
        inside = ((self.points > 0.05) & (self.points < 0.95)).all(axis=1)[self.cells].all(axis=1)
        cells, measures = self.cells[inside], self.measures()[inside]
        total, count = 0.0, 0
        for a in range(cells.shape[1]):
            for b in range(a):
                middle = (self.points[cells[:, a]] + self.points[cells[:, b]]) / 2
                value = (self.u[cells[:, a]] + self.u[cells[:, b]]) / 2
                total += float((measures * (value - field(middle)) ** 2).sum())
                count += 1
        return math.sqrt(total / count / measures.sum())


def neighbours_of(cells: np.ndarray) -> np.ndarray:
    """The cell across from each corner, or -1; as `cells`."""
    count, corners = cells.shape
    facets = np.concatenate([np.sort(np.delete(cells, k, axis=1), axis=1) for k in range(corners)])
    order = np.lexsort(facets.T)
    same = (facets[order][1:] == facets[order][:-1]).all(axis=1)
    first, second = order[:-1][same], order[1:][same]
    across = np.full(len(facets), -1)
    across[first], across[second] = second % count, first % count
    return across.reshape(corners, count).T


def walk(old: Plain, points: np.ndarray) -> np.ndarray:
    """The old linear function at `points`. Walks of all points at once, each from a cell at the
    nearest old vertex, across the facet beyond which the point is farthest. A point that is outside
    takes the value of the last cell, extrapolated."""
    cells, d = old.cells, points.shape[1]
    across = neighbours_of(cells)
    cell_at = np.zeros(len(old.points), int)
    cell_at[cells.ravel()] = np.repeat(np.arange(len(cells)), d + 1)
    cell = cell_at[cKDTree(old.points).query(points)[1]]
    origin = old.points[cells[:, 0]]
    inverse = np.linalg.inv(np.swapaxes(old.points[cells[:, 1:]] - origin[:, None], 1, 2))
    weights = np.empty((len(points), d + 1))
    active = np.arange(len(points))
    for _ in range(1000):
        at = cell[active]
        rest = np.einsum("nij,nj->ni", inverse[at], points[active] - origin[at])
        w = np.column_stack([1 - rest.sum(axis=1), rest])
        weights[active] = w
        worst = w.argmin(axis=1)
        rows = np.arange(len(active))
        step = across[at, worst]
        goes = (w[rows, worst] < -1e-12) & (step >= 0)
        active = active[goes]
        if not len(active):
            break
        cell[active] = step[goes]
    return (weights * old.u[cells[cell]]).sum(axis=1)


def scene_at(feature: str, dimension: int, edge: float, step: int) -> Scene:
    angle = 0.02 * step
    at = (0.5 + 0.2 * math.cos(angle), 0.5 + 0.2 * math.sin(angle), 0.5)[:dimension]
    return Scene(dimension, edge, at, 0.1 if feature == "disc" else 0)


def compact(mesh: dynmesh.Mesh, u: np.ndarray) -> Plain:
    c = mesh.compact()
    return Plain(c.points, c.cells, u[c.vertex_slots])


def feature_of(scene: Scene) -> dict[str, Any]:
    """The feature's arguments of Mesh.apply, but for the verb."""
    if scene.radius == 0:
        return {"points": {1: scene.at}}
    return {"sizes": {1: dict(at=scene.at, radius=scene.radius, target=scene.edge / 2)}}


def make(scene: Scene) -> dynmesh.Mesh:
    d = scene.dimension
    mesh = dynmesh.open([[0] * d, [1] * d], max_edge=scene.edge)
    mesh.apply(**{f"add_{kind}": value for kind, value in feature_of(scene).items()})
    return mesh


def by_dynmesh(feature: str, dimension: int, edge: float, steps: int) -> tuple[int, Row]:
    mesh = make(scene_at(feature, dimension, edge, 0))
    u = field(mesh.points)
    u = np.concatenate([u, np.zeros(len(u))])  # room
    before = compact(mesh, u).mass()
    times, kept = [], []
    for step in range(1, steps + 1):
        start = time.perf_counter()
        moved = feature_of(scene_at(feature, dimension, edge, step))
        diff = mesh.apply(**{f"set_{kind}": value for kind, value in moved.items()})
        meshed = time.perf_counter()
        diff.transfer(u, inplace=True)
        times.append((meshed - start, time.perf_counter() - meshed))
        kept.append(1 - len(diff.patch.added_cells) / mesh.cell_count)
    after = compact(mesh, u)
    return mesh.vertex_count, Row("dynmesh, transfer", *np.median(times, axis=0),
                                  abs(after.mass() / before - 1), after.error(),
                                  float(np.mean(kept)))


def anew(mesher: Mesher, name: str, feature: str, dimension: int, edge: float, steps: int) -> Row:
    points, cells = mesher(scene_at(feature, dimension, edge, 0))
    old = Plain(points, cells, field(points))
    begin = old.mass()
    times, kept = [], []
    for step in range(1, steps + 1):
        start = time.perf_counter()
        points, cells = mesher(scene_at(feature, dimension, edge, step))
        meshed = time.perf_counter()
        u = walk(old, points)
        times.append((meshed - start, time.perf_counter() - meshed))
        new = Plain(points, cells, u)
        kept.append(len(np.intersect1d(old.keys(), new.keys())) / len(new.cells))
        old = new
    return Row(f"{name}, interpolated", *np.median(times, axis=0), abs(old.mass() / begin - 1), old.error(),
               float(np.mean(kept)))


def from_scratch(scene: Scene) -> Arrays:
    c = make(scene).compact()
    return c.points, c.cells


def write_table(file: TextIO, feature: str, steps: int, quick: bool,
                others: dict[int, dict[str, Mesher]]) -> None:
    print("| dimension, vertices | way | ms to mesh | ms for values | ratio | drift of mass | L2 error "
          "| cells kept |\n|---|---|---|---|---|---|---|---|", file=file)
    for dimension, edges in SIZES.items():
        took: dict[str, tuple[float, float]] = {}  # edge and seconds of the size before
        for edge in edges[:1] if quick else edges:
            vertices, first = by_dynmesh(feature, dimension, edge, steps)
            rows = [first]
            few = steps if vertices < 30_000 else 3 if vertices < 300_000 else 1
            left_out = []
            for name, mesher in {"dynmesh anew": from_scratch, **others[dimension]}.items():
                before, seconds = took.get(name, (edge, 0.0))
                if seconds * (before / edge) ** dimension > MOST_SECONDS:
                    left_out.append(name)
                    continue
                rows.append(anew(mesher, name, feature, dimension, edge, min(few, steps)))
                took[name] = (edge, rows[-1].seconds)
                print(f"{feature}, {dimension}D, {vertices:,}: {rows[-1].text(first)}",
                      file=sys.stderr, flush=True)
            for i, row in enumerate(rows):
                of = f"{dimension}D, {vertices:,}" if i == 0 else ""
                print(f"| {of} | {row.text(first)} |", file=file)
            for name in left_out:
                print(f"| | {name}, interpolated | left out | | | | | |", file=file)
            file.flush()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="the smallest of each dimension")
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--triangle", metavar="PROGRAM", help="Triangle's; Debian has none")
    parser.add_argument("--out", type=pathlib.Path, default="RESULTS.md")
    arguments = parser.parse_args()
    others = installed(arguments.triangle)
    titles = {"point": "A point that moves by 0.004",
              "disc": "A disc (3D: a ball) in which the mesh is finer, moving by 0.004"}
    other = sections_of(arguments.out)
    with open(arguments.out, "w", encoding="utf-8") as file:
        print(BEFORE, file=file)
        for feature, title in titles.items():
            print(f"## {title}\n", file=file)
            write_table(file, feature, arguments.steps, arguments.quick, others)
            print(file=file)
        file.write(AFTER)
        if other:
            file.write("\n" + other)


if __name__ == "__main__":
    main()
