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
    mesh.apply(add_points={1: tip})
    elements = fem.Elements(mesh)
    temperature = np.ones(mesh.vertex_slots)
    series = dynmesh.Series(f"{out}/heat_crack.pvd")
    step_length, dt = 1.7 / steps, 0.2 / steps
    direction, worst, spent, changed = 0.0, 0.0, 0.0, []

    for step in range(1, steps + 1):
        # The crack turns a little as it grows. (numpy's sine may differ from heat_crack.cc's in the
        # last bit, and then the mesh differs, too.)
        direction += 0.15 * math.sin(2.5 * step)
        tip = tip + step_length * np.array([math.cos(direction), math.sin(direction)])
        before = elements.integral(temperature)
        start = time.perf_counter()
        diff = mesh.apply(add_points={step + 1: tip}, add_segments={CRACK + step: (step, step + 1)})
        temperature = diff.transfer(temperature, bounded=True)
        elements.follow(mesh, diff)
        spent += time.perf_counter() - start
        worst = max(worst, abs(elements.integral(temperature) - before) / before)
        changed.append(len(diff.patch.added_vertices) + len(diff.patch.removed_vertices))

        # (M + dt K) T = M T_old, with T = 0 on the crack; free slots have T = 0, too.
        mass = elements.matrix(elements.mass, mesh.vertex_slots)
        stiffness = elements.matrix(elements.stiffness, mesh.vertex_slots)
        cold = fem.vertices_of(mesh, CRACK + 1, CRACK + step) | ~mesh.live_vertices
        temperature[cold] = 0
        temperature = fem.solve(mass + dt * stiffness, mass @ temperature, temperature, cold)
        series.add(step * dt, mesh, point_data={"temperature": temperature})

    live = temperature[mesh.live_vertices]
    print(f"{mesh.vertex_count} vertices, {steps} steps of the crack: "
          f"{np.mean(changed):.0f} vertices changed a step, {1e3 * spent / steps:.2f} ms "
          "a step for edit, transfer and assembly")
    print(f"heat kept by every edit to {worst:.1e} of it; temperatures {live.min():.3f} to "
          f"{live.max():.3f}; series in {series.path}")
    assert worst < 1e-12, "an edit lost heat"
    assert live.min() > -0.05 and live.max() < 1.05, "a temperature is out of bounds"
    assert fem.rebuilt(mesh).hash == mesh.hash, "the mesh is not that of its features"
    print("good")


if __name__ == "__main__":
    main()
