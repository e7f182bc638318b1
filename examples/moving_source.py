#!/usr/bin/env python3
"""A heat source that moves around a plate, with a fine mesh where it is.

A sizing disc moves with the source: the mesh refines ahead of it and coarsens behind. P1 finite
elements, implicit Euler; every edit transfers the temperature.

    examples/moving_source.py [--edge 0.05] [--steps 60] [--out out/moving_source]

Writes a series for ParaView, and checks that the heat equals the source's input after all edits.
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
    mesh.apply(add_sizes=size(0))
    elements = fem.Elements(mesh)
    mesh.fields.add("temperature", np.zeros(mesh.vertex_slots))
    series = dynmesh.Series(f"{arguments.out}/moving_source.pvd")
    dt, brought, spent, counts = 1.0 / arguments.steps, 0.0, 0.0, []

    for step in range(1, arguments.steps + 1):
        start = time.perf_counter()
        diff = mesh.apply(set_sizes=size(step))  # carries the field, too
        elements.follow(mesh, diff)
        spent += time.perf_counter() - start
        counts.append(mesh.vertex_count)

        mass = elements.matrix(elements.mass, mesh.vertex_slots)
        stiffness = elements.matrix(elements.stiffness, mesh.vertex_slots)
        distance2 = ((mesh.points - place(step)) ** 2).sum(axis=1)
        source = np.where(mesh.live_vertices, np.exp(-distance2 / 0.02**2), 0)
        heating = dt * (mass @ source)
        brought += heating.sum()
        u = mesh.fields["temperature"]
        free_slots = ~mesh.live_vertices
        u[free_slots] = 0
        u[:] = fem.solve(mass + 0.02 * dt * stiffness, mass @ u + heating, u, free_slots)
        series.add(step * dt, mesh, point_data={"temperature": u})

    held = elements.integral(mesh.fields["temperature"])
    print(f"{min(counts)} to {max(counts)} vertices, {1e3 * spent / arguments.steps:.2f} ms a step "
          f"for edit, transfer and assembly; heat {held:.9g} of {brought:.9g} brought; series in "
          f"{series.path}")
    assert abs(held / brought - 1) < 1e-8, "heat was lost"
    assert fem.rebuilt(mesh).hash == mesh.hash, "the mesh is not that of its features"
    print("good")


if __name__ == "__main__":
    main()
