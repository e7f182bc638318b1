#!/usr/bin/env python3
"""One step of a moving feature: dynmesh and its transfer, and the usual way, which meshes anew and
interpolates. Prints the table of RESULTS.md.

    tests/bench/remesh_table.py [--quick] [--steps 10] [--feature disc|point]

Features: a disc (in 3D a ball) in which the mesh is finer; a point that is to be a vertex.
Usual ways: dynmesh from scratch, Gmsh where python3-gmsh is installed; both with the values taken
from the linear interpolant of the old vertices (scipy). Ratios are to dynmesh with its transfer.
"""
from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import LinearNDInterpolator

import dynmesh


def field(x: np.ndarray) -> np.ndarray:
    return 2 + np.sin(5 * x[..., 0] + 1) * np.cos(4 * x[..., 1])


Arrays = tuple[np.ndarray, np.ndarray]  # points, cells
Mesher = Callable[[str, int, float, int], Arrays]  # of scene, dimension, edge, step


@dataclass
class Row:
    way: str
    seconds: float
    drift: float
    error: float
    kept: float

    def text(self, first: Row) -> str:
        return (f"{self.way} | {1e3 * self.seconds:.4g} | {self.seconds / first.seconds:,.0f} | "
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


def place_of(step: int, dimension: int) -> tuple[float, ...]:
    angle = 0.02 * step
    return (0.5 + 0.2 * math.cos(angle), 0.5 + 0.2 * math.sin(angle), 0.5)[:dimension]


def compact(mesh: dynmesh.Mesh, u: np.ndarray) -> Plain:
    c = mesh.compact()
    return Plain(c.points, c.cells, u[c.vertex_slots])


def feature_at(scene: str, step: int, dimension: int, edge: float) -> dict[str, Any]:
    """The feature's arguments of Mesh.apply, but for the verb."""
    at = place_of(step, dimension)
    if scene == "point":
        return {"points": {1: at}}
    return {"sizes": {1: dict(at=at, radius=0.1, target=edge / 2)}}


def make(scene: str, dimension: int, edge: float, step: int) -> dynmesh.Mesh:
    mesh = dynmesh.open([[0] * dimension, [1] * dimension], max_edge=edge)
    feature = feature_at(scene, step, dimension, edge)
    mesh.apply(**{f"add_{kind}": value for kind, value in feature.items()})
    return mesh


def by_dynmesh(scene: str, dimension: int, edge: float, steps: int) -> tuple[int, Row]:
    mesh = make(scene, dimension, edge, 0)
    u = field(mesh.points)
    u = np.concatenate([u, np.zeros(len(u))])  # room
    before = compact(mesh, u).mass()
    times, kept = [], []
    for step in range(1, steps + 1):
        start = time.perf_counter()
        feature = feature_at(scene, step, dimension, edge)
        diff = mesh.apply(**{f"set_{kind}": value for kind, value in feature.items()})
        diff.transfer(u, inplace=True)
        times.append(time.perf_counter() - start)
        kept.append(1 - len(diff.patch.added_cells) / mesh.cell_count)
    after = compact(mesh, u)
    return mesh.vertex_count, Row("dynmesh, transfer", float(np.median(times)),
                                  abs(after.mass() / before - 1), after.error(),
                                  float(np.mean(kept)))


def anew(mesher: Mesher, name: str, scene: str, dimension: int, edge: float, steps: int) -> Row:
    points, cells = mesher(scene, dimension, edge, 0)
    old = Plain(points, cells, field(points))
    begin = old.mass()
    times, kept = [], []
    for step in range(1, steps + 1):
        start = time.perf_counter()
        points, cells = mesher(scene, dimension, edge, step)
        u = LinearNDInterpolator(old.points, old.u)(points)
        outside = np.isnan(u)
        u[outside] = field(points[outside])  # rounding at the border
        times.append(time.perf_counter() - start)
        new = Plain(points, cells, u)
        kept.append(len(np.intersect1d(old.keys(), new.keys())) / len(new.cells))
        old = new
    return Row(name, float(np.median(times)), abs(old.mass() / begin - 1), old.error(),
               float(np.mean(kept)))


def from_scratch(scene: str, dimension: int, edge: float, step: int) -> Arrays:
    c = make(scene, dimension, edge, step).compact()
    return c.points, c.cells


def by_gmsh(scene: str, dimension: int, edge: float, step: int) -> Arrays:
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{option}", 0)
    if dimension == 2:
        gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    else:
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    at = (*place_of(step, dimension), 0.0)[:3]
    point = gmsh.model.occ.addPoint(*at) if scene == "point" else None
    gmsh.model.occ.synchronize()
    if point is not None:
        gmsh.model.mesh.embed(0, [point], dimension, 1)
    ball = gmsh.model.mesh.field.add("Ball")
    inside = edge if scene == "point" else edge / 2
    for key, value in dict(Radius=0.1, Thickness=edge, VIn=inside, VOut=edge, XCenter=at[0],
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="the smallest of each dimension")
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--feature", choices=["disc", "point"], help="both without")
    arguments = parser.parse_args()
    ways: dict[str, Mesher] = {"dynmesh anew, interpolated": from_scratch}
    try:
        import gmsh  # noqa: F401

        ways["Gmsh, interpolated"] = by_gmsh
    except ImportError:
        print("Gmsh is not installed (python3-gmsh): its rows are left out\n")
    sizes = {2: [0.0103, 0.00325, 0.00103], 3: [0.067, 0.0305]}
    for scene in [arguments.feature] if arguments.feature else ["disc", "point"]:
        print(f"A {scene} that moves\n")
        print("| dimension, vertices | way | ms a step | ratio | drift of mass | L2 error | "
              "cells kept |\n|---|---|---|---|---|---|---|")
        for dimension, edges in sizes.items():
            for edge in edges[:1] if arguments.quick else edges:
                vertices, first = by_dynmesh(scene, dimension, edge, arguments.steps)
                rows = [first]
                for name, mesher in ways.items():
                    # Where a step takes minutes, fewer of them.
                    steps = min(arguments.steps, 3) if vertices > 30_000 else arguments.steps
                    rows.append(anew(mesher, name, scene, dimension, edge, steps))
                for row in rows:
                    print(f"| {dimension}D, {vertices:,} | {row.text(first)} |", flush=True)
        print()


if __name__ == "__main__":
    main()
