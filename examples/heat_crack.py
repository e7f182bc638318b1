#!/usr/bin/env python3
"""Heat conduction in a plate through which a cooled crack grows.

P1 finite elements, implicit Euler. The mesh follows the crack; each step assembles the element
matrices of the patch only and transfers the temperature across the edit.

    examples/heat_crack.py [--edge 0.02] [--steps 40] [--out out/heat_crack] [--server HOST:PORT]

Writes a series for ParaView, and finally checks that every edit conserves heat, temperatures stay
within their bounds, and the mesh equals one made from scratch.
"""
from __future__ import annotations

import argparse
import math
import time

import numpy as np

import dynmesh
import fem
from opened import opened

CRACK = 10_000  # ids of the crack's segments follow
PLATE = 5_000  # the plate's polygon; ids of its corners follow


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edge", type=float, default=0.02, help="target length of edges")
    parser.add_argument("--steps", type=int, default=40)
    parser.add_argument("--out", default="out/heat_crack")
    parser.add_argument("--server", help="address of a dynmeshd; in process without")
    arguments = parser.parse_args()

    with opened(arguments.server, box=[[0, 0], [2, 1]], max_edge=arguments.edge) as mesh:
        run(mesh, arguments.steps, arguments.out)


def run(mesh: dynmesh.Mesh, steps: int, out: str) -> None:
    tip = np.array([0.1, 0.5])
    corners = {PLATE + 1: (0, 0), PLATE + 2: (2, 0), PLATE + 3: (2, 1), PLATE + 4: (0, 1)}
    mesh.apply(add_points={1: tip, **corners}, add_polygons={PLATE: corners})
    part = mesh.part(polygons=PLATE)  # the mesh reaches far beyond the plate
    elements = fem.Elements(part)
    temperature = np.ones(mesh.vertex_slots)
    series = dynmesh.Series(f"{out}/heat_crack.pvd")
    step_length, dt = 1.7 / steps, 0.2 / steps
    direction, worst, spent, changed = 0.0, 0.0, 0.0, []

    for step in range(1, steps + 1):
        # The crack turns a little as it grows. (numpy's sine may differ from heat_crack.cc's in the
        # last bit, and then the mesh differs, too.)
        direction += 0.15 * math.sin(2.5 * step)
        tip = tip + step_length * np.array([math.cos(direction), math.sin(direction)])
        before = elements.integral(temperature[part.vertex_slots])
        start = time.perf_counter()
        diff = mesh.apply(add_points={step + 1: tip}, add_segments={CRACK + step: (step, step + 1)})
        temperature = diff.transfer(temperature)
        part.update(diff)
        elements.follow()
        spent += time.perf_counter() - start
        u = temperature[part.vertex_slots]
        worst = max(worst, abs(elements.integral(u) - before) / before)
        changed.append(len(diff.patch.added_vertices) + len(diff.patch.removed_vertices))

        # (M + dt K) T = M T_old, with T = 0 on the crack.
        mass, stiffness = elements.matrix(elements.mass), elements.matrix(elements.stiffness)
        cold = fem.vertices_of(part, CRACK + 1, CRACK + step)
        u[cold] = 0
        u = fem.solve(mass + dt * stiffness, mass @ u, u, cold)
        temperature[part.vertex_slots] = u
        series.add(step * dt, part, point_data={"temperature": u})

    live = temperature[part.vertex_slots]
    print(f"{len(part.points)} vertices, {steps} steps of the crack: "
          f"{np.mean(changed):.0f} vertices changed a step, {1e3 * spent / steps:.2f} ms "
          "a step for edit, transfer and assembly")
    print(f"heat kept by every edit to {worst:.1e} of it; temperatures {live.min():.3f} to "
          f"{live.max():.3f}; series in {series.path}")
    assert fem.is_all_of(part, 2 * 1), "there are cells outside of the plate"
    assert worst < 1e-12, "an edit lost heat"
    assert live.min() > -0.05 and live.max() < 1.05, "a temperature is out of bounds"
    assert fem.rebuilt(mesh).hash == mesh.hash, "the mesh is not that of its features"
    print("good")


if __name__ == "__main__":
    main()
