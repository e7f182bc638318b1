#!/usr/bin/env python3
"""Diffusion around a ball that moves through a box, in 3D.

The ball is a closed surface of triangles with moving points; inside of it the concentration is held
at 1. Every edit transfers means of cells (P0) and values at vertices (P1).

    examples/moving_ball.py [--steps 8] [--out out/moving_ball]

Writes a series for ParaView. Checks that every edit conserves mass, in total and, except for what
the ball's motion moves across its surface, in the region of the ball, and that the mesh equals one
made from scratch.
"""
from __future__ import annotations

import argparse
import time

import numpy as np

import dynmesh
import fem

# An octahedron with corners 1 to 6 and faces 11 to 18.
CORNERS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
BALL = 11
FACES = [(1, 3, 5), (3, 2, 5), (2, 4, 5), (4, 1, 5), (3, 1, 6), (2, 3, 6), (4, 2, 6), (1, 4, 6)]

ROOM = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=8)
    parser.add_argument("--edge", type=float, default=0.1, help="target length near the ball")
    parser.add_argument("--out", default="out/moving_ball")
    arguments = parser.parse_args()

    def corners(step: int) -> dict[int, np.ndarray]:
        middle = np.array([0.3 + 0.4 * step / arguments.steps, 0.5, 0.5])
        return {i + 1: middle + 0.15 * corner for i, corner in enumerate(CORNERS)}

    mesh = dynmesh.open([[0, 0, 0], [1, 1, 1]])
    mesh.apply(add_points=corners(0), add_polygons={BALL + i: face for i, face in enumerate(FACES)},
               add_sizes={20: dict(low=(0.05, 0.25, 0.25), high=(0.95, 0.75, 0.75),
                                   target=arguments.edge)})
    # The room around it: corners 31 to 38, faces 41 to 46.
    mesh.apply(add_points={31 + i: (i & 1, i >> 1 & 1, i >> 2) for i in range(8)},
               add_polygons={41 + i: [31 + c for c in face] for i, face in enumerate(ROOM)})
    part = mesh.part()  # the mesh reaches far beyond the room
    ball = mesh.part(polygons=BALL)
    elements = fem.Elements(part)
    u = np.zeros(mesh.vertex_slots)
    age = np.zeros(mesh.cell_slots)  # of each cell's content: how long it has been in the box
    series = dynmesh.Series(f"{arguments.out}/moving_ball.pvd")
    dt, worst, spent = 0.02, 0.0, 0.0

    for step in range(1, arguments.steps + 1):
        before = elements.integral(u[part.vertex_slots])
        start = time.perf_counter()
        diff = mesh.apply(move_points=corners(step))
        u = diff.transfer(u)
        age = diff.transfer(age, kind="P0", bounded=True)
        part.update(diff)
        ball.update(diff)
        elements.follow()
        spent += time.perf_counter() - start
        held = u[part.vertex_slots]
        worst = max(worst, abs(elements.integral(held) - before) / max(before, 1e-3))

        mass, stiffness = elements.matrix(elements.mass), elements.matrix(elements.stiffness)
        fixed = np.zeros(len(held), bool)
        inside = part.vertex_numbers[ball.vertex_slots]
        fixed[inside], held[inside] = True, 1
        held = fem.solve(mass + 0.1 * dt * stiffness, mass @ held, held, fixed)
        u[part.vertex_slots] = held
        age += dt
        series.add(step * dt, part, point_data={"u": held}, cell_data={"age": age[part.cell_slots]})

    live_age = age[part.cell_slots]
    print(f"{len(part.points)} vertices, {len(part.cells)} tetrahedra, "
          f"{1e3 * spent / arguments.steps:.1f} ms a step for edit, transfer and assembly; mass kept "
          f"by every edit to {worst:.1e}; series in {series.path}")
    assert fem.is_all_of(part, 1), "there are cells outside of the room"
    assert worst < 1e-12, "an edit lost mass"
    assert np.ptp(live_age) < 1e-12, "a constant did not stay one"
    assert fem.rebuilt(mesh).hash == mesh.hash, "the mesh is not that of its features"
    print("good")


if __name__ == "__main__":
    main()
