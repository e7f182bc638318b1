#!/usr/bin/env python3
"""One step of a moving disc or ball in which the mesh is finer: dynmesh and its transfer, and the
usual way, which meshes anew and interpolates. Prints the table of RESULTS.md.

    tests/bench/remesh_table.py [--quick] [--steps 10]

Usual ways: dynmesh from scratch, Gmsh where python3-gmsh is installed; both with the values taken
from the linear interpolant of the old vertices (scipy).
"""
from __future__ import annotations

import argparse
import math
import time

import numpy as np
from scipy.interpolate import LinearNDInterpolator

import dynmesh


def field(x: np.ndarray) -> np.ndarray:
    return 2 + np.sin(5 * x[..., 0] + 1) * np.cos(4 * x[..., 1])


class Plain:
    """Points, cells and values without slots."""

    def __init__(self, points: np.ndarray, cells: np.ndarray, u: np.ndarray) -> None:
        self.points, self.cells, self.u = points, cells, u

    def measures(self) -> np.ndarray:
        corners = self.points[self.cells]
        edges = corners[:, 1:] - corners[:, :1]
        return np.abs(np.linalg.det(edges)) / math.factorial(self.points.shape[1])

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


def place_of(step: int, dimension: int) -> tuple[float, ...]:
    angle = 0.02 * step
    return (0.5 + 0.2 * math.cos(angle), 0.5 + 0.2 * math.sin(angle), 0.5)[:dimension]


def compact(mesh: dynmesh.Mesh, u: np.ndarray) -> Plain:
    c = mesh.compact()
    return Plain(c.points, c.cells, u[c.vertex_slots])


def make(dimension: int, edge: float) -> dynmesh.Mesh:
    mesh = dynmesh.open([[0] * dimension, [1] * dimension], max_edge=edge)
    mesh.apply(add_sizes={1: dict(at=place_of(0, dimension), radius=0.1, target=edge / 2)})
    return mesh


def by_dynmesh(dimension: int, edge: float, steps: int) -> tuple[int, list[str]]:
    mesh = make(dimension, edge)
    u = field(mesh.points)
    u = np.concatenate([u, np.zeros(len(u))])  # room
    before = compact(mesh, u).mass()
    times, kept = [], []
    for step in range(1, steps + 1):
        start = time.perf_counter()
        diff = mesh.apply(
            set_sizes={1: dict(at=place_of(step, dimension), radius=0.1, target=edge / 2)})
        diff.transfer(u, inplace=True)
        times.append(time.perf_counter() - start)
        kept.append(1 - len(diff.patch.added_cells) / mesh.cell_count)
    after = compact(mesh, u)
    return mesh.vertex_count, row("dynmesh, transfer", times, abs(after.mass() / before - 1),
                                  after.error(), np.mean(kept))


def anew(mesher, name: str, dimension: int, edge: float, steps: int) -> list[str]:
    points, cells = mesher(dimension, edge, 0)
    old = Plain(points, cells, field(points))
    begin = old.mass()
    times, kept = [], []
    for step in range(1, steps + 1):
        start = time.perf_counter()
        points, cells = mesher(dimension, edge, step)
        u = LinearNDInterpolator(old.points, old.u)(points)
        outside = np.isnan(u)
        u[outside] = field(points[outside])  # rounding at the border
        times.append(time.perf_counter() - start)
        new = Plain(points, cells, u)
        both = {tuple(sorted(map(tuple, old.points[c]))) for c in old.cells[:2000]} & \
            {tuple(sorted(map(tuple, points[c]))) for c in cells} if len(cells) < 300_000 else set()
        kept.append(len(both) / min(2000, len(old.cells)))
        old = new
    return row(name, times, abs(old.mass() / begin - 1), old.error(), np.mean(kept))


def from_scratch(dimension: int, edge: float, step: int) -> tuple[np.ndarray, np.ndarray]:
    mesh = dynmesh.open([[0] * dimension, [1] * dimension], max_edge=edge)
    mesh.apply(add_sizes={1: dict(at=place_of(step, dimension), radius=0.1, target=edge / 2)})
    c = mesh.compact()
    return c.points, c.cells


def by_gmsh(dimension: int, edge: float, step: int) -> tuple[np.ndarray, np.ndarray]:
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{option}", 0)
    if dimension == 2:
        gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    else:
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    ball = gmsh.model.mesh.field.add("Ball")
    at = (*place_of(step, dimension), 0.0)[:3]
    for key, value in dict(Radius=0.1, Thickness=edge, VIn=edge / 2, VOut=edge, XCenter=at[0],
                           YCenter=at[1], ZCenter=at[2] if dimension == 3 else 0).items():
        gmsh.model.mesh.field.setNumber(ball, key, value)
    gmsh.model.mesh.field.setAsBackgroundMesh(ball)
    gmsh.model.mesh.generate(dimension)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, nodes = gmsh.model.mesh.getElementsByType(2 if dimension == 2 else 4)
    number = np.zeros(int(tags.max()) + 1, int)
    number[tags.astype(int)] = np.arange(len(tags))
    gmsh.finalize()
    cells = number[nodes.astype(int)].reshape(-1, dimension + 1)
    return coordinates.reshape(-1, 3)[:, :dimension].copy(), cells


def row(name: str, times: list[float], drift: float, error: float, kept: float) -> list[str]:
    return [name, f"{1e3 * float(np.median(times)):.4g}", f"{drift:.1e}", f"{error:.3e}",
            f"{100 * kept:.1f} %"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="the smallest of each dimension")
    parser.add_argument("--steps", type=int, default=10)
    arguments = parser.parse_args()
    ways = {"dynmesh anew, interpolated": from_scratch}
    try:
        import gmsh  # noqa: F401

        ways["Gmsh, interpolated"] = by_gmsh
    except ImportError:
        print("Gmsh is not installed (python3-gmsh): its rows are left out\n")
    sizes = {2: [0.014, 0.0044, 0.0014], 3: [0.07, 0.032]}
    print("| dimension, vertices | way | ms a step | drift of mass | L2 error | cells kept |")
    print("|---|---|---|---|---|---|")
    for dimension, edges in sizes.items():
        for edge in edges[:1] if arguments.quick else edges:
            vertices, first = by_dynmesh(dimension, edge, arguments.steps)
            rows = [first]
            for name, mesher in ways.items():
                steps = min(arguments.steps, 3) if vertices > 50_000 else arguments.steps
                rows.append(anew(mesher, name, dimension, edge, steps))
            for cells in rows:
                print(f"| {dimension}D, {vertices:,} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
