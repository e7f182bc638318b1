#!/usr/bin/env python3
"""A heat source that moves around a plate, with a fine mesh where it is.

A sizing disc moves with the source: the mesh refines ahead of it and coarsens behind. P1 finite
elements, implicit Euler; every edit transfers the temperature.

    examples/moving_source.py [--edge 0.05] [--steps 60] [--out out/moving_source]

Writes a series for ParaView, and checks that each edit keeps the heat, and that it equals the source's
input at the end.
"""
from __future__ import annotations

import argparse
import math
import time

import numpy as np

import dynmesh
import fem


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edge", type=float, default=0.05, help="target length away from it")
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--out", default="out/moving_source")
    arguments = parser.parse_args()

    def place(step: int) -> tuple[float, float]:
        angle = 2 * math.pi * step / arguments.steps
        return 0.5 + 0.3 * math.cos(angle), 0.5 + 0.3 * math.sin(angle)

    def size(step: int) -> dict[int, dict[str, object]]:
        return {1: dict(at=place(step), radius=0.08, target=arguments.edge / 6)}

    mesh = dynmesh.open([[0, 0], [1, 1]], max_edge=arguments.edge)
    corners = {11: (0, 0), 12: (1, 0), 13: (1, 1), 14: (0, 1)}
    mesh.apply(add_points=corners, add_polygons={10: corners}, add_sizes=size(0))
    part = mesh.part(polygons=10)  # the mesh reaches far beyond it
    elements = fem.Elements(part)
    mesh.fields.add("temperature", np.zeros(mesh.vertex_slots), bounded=True)
    series = dynmesh.Series(f"{arguments.out}/moving_source.pvd")
    dt, brought, spent, lost, counts = 1.0 / arguments.steps, 0.0, 0.0, 0.0, []

    for step in range(1, arguments.steps + 1):
        start = time.perf_counter()
        diff = mesh.apply(set_sizes=size(step))  # carries the field, too
        part.update(diff)
        elements.follow()
        spent += time.perf_counter() - start
        counts.append(len(part.points))
        u = mesh.fields["temperature"][part.vertex_slots]
        if brought > 0:
            lost = max(lost, abs(elements.integral(u) / held - 1))

        mass, stiffness = elements.matrix(elements.mass), elements.matrix(elements.stiffness)
        distance2 = ((part.points - place(step)) ** 2).sum(axis=1)
        heating = dt * (mass @ np.exp(-distance2 / 0.02**2))
        brought += heating.sum()
        free = np.zeros(len(u), bool)
        u = fem.solve(mass + 0.02 * dt * stiffness, mass @ u + heating, u, free)
        mesh.fields["temperature"][part.vertex_slots] = u
        held = elements.integral(u)
        series.add(step * dt, part, point_data={"temperature": u})

    print(f"{min(counts)} to {max(counts)} vertices, {1e3 * spent / arguments.steps:.2f} ms a step "
          f"for edit, transfer and assembly; heat kept to {held / brought - 1:.1e} of what was "
          f"brought, by each edit to {lost:.1e}; series in {series.path}")
    assert fem.is_all_of(part, 1), "there are cells outside of the plate"
    assert lost < 1e-12, "an edit lost heat"
    assert abs(held / brought - 1) < 1e-10, "heat was lost"
    assert fem.rebuilt(mesh).hash == mesh.hash, "the mesh is not that of its features"
    print("good")


if __name__ == "__main__":
    main()
