#!/usr/bin/env python3
"""Diffusion around a ball that moves through a room, in 3D.

The ball is a closed surface of triangles with moving points; its surface is held at 1, the left and
the right wall of the room at 0. Every edit carries the concentration (P1, bounded) and the age of
each cell's content (P0).

    examples/moving_ball.py [--edge 0.15] [--level 2] [--steps 20] [--out out/moving_ball]

Writes a series for ParaView. Checks the areas of the walls and of the ball, that no edit loses mass
or leads out of the range of values, that nothing of the part is outside of the room, and that the mesh
equals one made from scratch.
"""
from __future__ import annotations

import argparse
import math
import time

import numpy as np
from scipy.sparse import diags

import dynmesh
import fem

ROOM, BALL, TRIANGLES = 11, 1000, 5000  # first ids: walls, points and triangles of the ball
CORNERS = {1 + i: (2 * (i & 1), i >> 1 & 1, i >> 2) for i in range(8)}
WALLS = {"bottom": (1, 2, 4, 3), "top": (5, 6, 8, 7), "front": (1, 2, 6, 5), "back": (3, 4, 8, 7),
         "left": (1, 3, 7, 5), "right": (2, 4, 8, 6)}
RADIUS = 0.2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edge", type=float, default=0.15, help="target length")
    parser.add_argument("--level", type=int, default=2, help="of 20 times 4^level triangles of the ball")
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--out", default="out/moving_ball")
    arguments = parser.parse_args()
    run(arguments.edge, arguments.level, arguments.steps, arguments.out)


def run(edge: float, level: int, steps: int, out: str) -> None:
    sphere, triangles = icosphere(level)

    def points(step: int) -> dict[int, np.ndarray]:
        middle = np.array([0.5 + step / steps, 0.5, 0.5])
        return dict(enumerate(middle + RADIUS * sphere, BALL))

    faces = {TRIANGLES + i: [BALL + c for c in corners] for i, corners in enumerate(triangles)}
    mesh = dynmesh.open([[0, 0, 0], [2, 1, 1]], max_edge=edge)
    mesh.apply(add_points={**CORNERS, **points(0)},
               add_polygons={**dict(enumerate(WALLS.values(), ROOM)), **faces},
               set_labels={**{id_: dict(name=name) for id_, name in enumerate(WALLS, ROOM)},
                           **{id_: dict(name="ball") for id_ in faces}})
    part = mesh.part()  # the room and the ball: the mesh reaches far beyond
    elements = fem.Elements(part)
    u = np.zeros(len(part.points))
    age = np.zeros(len(part.cells))
    surface = areas_by_name(part)["ball"]
    series = dynmesh.Series(f"{out}/moving_ball.pvd")
    dt, worst, off, spent, high = 0.02, 0.0, 0.0, 0.0, 0.0

    for step in range(steps + 1):
        if step > 0:
            before, ends = elements.integral(u), (u.min(), u.max())
            start = time.perf_counter()
            diff = mesh.apply(move_points=points(step))
            u = part.transfer(diff, u, bounded=True)
            age = part.transfer(diff, age, "P0", bounded=True)
            elements.follow()
            spent += time.perf_counter() - start
            worst = max(worst, abs(elements.integral(u) / before - 1))
            assert ends[0] <= u.min() and u.max() <= ends[1], "an edit led out of the range"
        # Lumped: with the consistent mass, short steps undershoot beside the ball.
        mass = diags(elements.matrix(elements.mass).sum(axis=1).A1).tocsr()
        stiffness = elements.matrix(elements.stiffness)
        held = u.copy()
        fixed = np.zeros(len(u), bool)
        for name, value in (("left", 0), ("right", 0), ("ball", 1)):
            on = part.facets[part.facet_names == name]
            fixed[on], held[on] = True, value
        u = fem.solve(mass + 0.05 * dt * stiffness, mass @ u, held, fixed)
        high = max(high, u.max())
        age += dt
        areas = areas_by_name(part)
        off = max(off, abs(areas["ball"] - surface), *(
            abs(areas[name] - (1 if name in ("left", "right") else 2)) for name in WALLS))
        series.add(step * dt, part, point_data={"u": u}, cell_data={"age": age})

    print(f"{len(part.points)} vertices, {len(part.cells)} tetrahedra, "
          f"{1e3 * spent / steps:.1f} ms a step for edit, transfer and assembly; mass kept by every "
          f"edit to {worst:.1e}, areas to {off:.1e}; values at the end from {u.min():.1e}, never "
          f"above 1 + {high - 1:.1e}; series in {series.path}")
    assert fem.is_all_of(part, 2), "there are cells outside of the room"
    assert off < 1e-12, "a wall is not whole"
    assert worst < 1e-12, "an edit lost mass"
    assert high < 1 + 1e-9, "the concentration exceeds that of the ball"
    assert np.ptp(age) < 1e-12, "a constant did not stay one"
    assert fem.rebuilt(mesh).hash == mesh.hash, "the mesh is not that of its features"
    print("good")


def areas_by_name(part: dynmesh.Part) -> dict[str, float]:
    corners = part.points[part.facets]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas, names = np.linalg.norm(normals, axis=1) / 2, part.facet_names
    return {name: math.fsum(areas[names == name]) for name in {"ball", *WALLS}}


def icosphere(level: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a sphere around 0 with radius 1, and triangles: an icosahedron, divided."""
    golden = (1 + math.sqrt(5)) / 2
    points = np.array([np.roll([0, a, b * golden], k) for k in range(3)
                       for a in (-1, 1) for b in (-1, 1)])
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    near = (distances > 0) & (distances < 2.1)
    triangles = np.array([(a, b, c) for a in range(12) for b in range(a) for c in range(b)
                          if near[a, b] and near[b, c] and near[a, c]])
    for _ in range(level):
        edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        ends, middles = np.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = (len(points) + middles.reshape(-1, 3)).T
        a, b, c = triangles.T
        triangles = np.concatenate([np.stack(each, axis=1) for each in (
            (a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        points = np.concatenate([points, points[ends].mean(axis=1)])
    return points / np.linalg.norm(points, axis=1, keepdims=True), triangles


if __name__ == "__main__":
    main()
