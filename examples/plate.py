"""A plate in which a warm disc moves and a wire grows; shared by the examples of FEM packages.

A package gets the triangles of the plate only, with a marker for each cell (in the disc or not) and
for each marked facet (its feature). It does one step of heat conduction and returns its integrals,
which are compared with those of the features.
"""
from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

import dynmesh
from opened import opened

# Ids of features, and so markers of facets. The left side is a segment feature, so that its
# subsegments have a marker of their own. The whole wire has the marker WIRE; its segments have ids
# from there on.
LEFT, PLATE, DISC, WIRE = 50, 100, 200, 300
CORNERS, RADIUS = 16, 0.12  # of the disc; its points are 11, 12, ...
JOINT = 1000  # the first point of the wire; the others' ids follow
IN_PLATE, IN_DISC = 1, 2  # markers of cells

# The problem: u' = div(k grad u), heated in the disc, along the wire and from the left.
TIME_STEP = 0.02
CONDUCTIVITY = {IN_PLATE: 0.1, IN_DISC: 1.0}
HEATING = {DISC: 20.0, WIRE: 5.0, LEFT: -0.5}


@dataclass(frozen=True)
class Part:
    """The triangles of the plate in a numbering without gaps, and the field on them."""

    points: np.ndarray
    cells: np.ndarray
    cell_markers: np.ndarray
    facets: np.ndarray
    facet_markers: np.ndarray
    slots: np.ndarray  # of its vertices
    u: np.ndarray

    def integral(self) -> float:
        edges = self.points[self.cells[:, 1:]] - self.points[self.cells[:, :1]]
        return float(np.linalg.det(edges) / 6 @ self.u[self.cells].sum(axis=1))


@dataclass(frozen=True)
class Answer:
    """A package's results: areas and lengths by marker, heat before and after its step."""

    areas: dict[int, float]
    lengths: dict[int, float]
    heat: float
    u: np.ndarray
    heat_after: float


def part_of(mesh: dynmesh.Mesh, u: np.ndarray) -> Part:
    """The part of a mesh in the plate, without the cells in no polygon."""
    part = mesh.part()
    # A set of several polygons has its own region id. region_sets has the polygons.
    in_disc = np.array([region for region, polygons in mesh.region_sets.items()
                        if DISC in polygons], np.uint64)
    slots = part.vertex_slots
    return Part(part.points, part.cells,
                np.where(np.isin(part.cell_regions, in_disc), IN_DISC, IN_PLATE), part.facets,
                np.minimum(part.facet_owners, WIRE).astype(np.int32), slots, u[slots])


def disc(step: int, steps: int) -> dict[int, tuple[float, float]]:
    """The disc's corners."""
    angles = [2 * math.pi * k / CORNERS for k in range(CORNERS)]
    x = 0.3 + 0.4 * step / steps
    return {11 + k: (x + RADIUS * math.cos(a), 0.3 + RADIUS * math.sin(a))
            for k, a in enumerate(angles)}


def joint(step: int, steps: int) -> tuple[float, float]:
    """The wire's end after a step."""
    return 0.15 + 0.7 * step / steps, 0.75 + 0.08 * math.sin(2.1 * step)


def length(points: list[tuple[float, float]]) -> float:
    return sum(math.dist(a, b) for a, b in zip(points, points[1:]))


def expected(step: int, steps: int) -> tuple[dict[int, float], dict[int, float], float]:
    """Expected values after a step, from the features: areas and lengths by marker, heat gained."""
    area = RADIUS**2 * CORNERS / 2 * math.sin(2 * math.pi / CORNERS)
    corners = list(disc(step, steps).values())
    lengths = {LEFT: 1.0, PLATE: 3.0, DISC: length([*corners, corners[0]]),
               WIRE: length([joint(k, steps) for k in range(step + 1)])}
    heat = HEATING[DISC] * area + HEATING[WIRE] * lengths[WIRE] + HEATING[LEFT] * lengths[LEFT]
    return {IN_PLATE: 1 - area, IN_DISC: area}, lengths, TIME_STEP * heat


def difference(found: dict[int, float], wanted: dict[int, float]) -> float:
    assert found.keys() == wanted.keys(), f"markers {sorted(found)}, not {sorted(wanted)}"
    return max(abs(found[key] - wanted[key]) for key in wanted)


def missing(debian_package: str) -> NoReturn:
    """Ends the program with the exit code that CTest lists as skipped."""
    print(f"not run: install Debian's package {debian_package}")
    sys.exit(77)


def run(name: str, solve: Callable[[Part], Answer]) -> None:
    """Applies ten edits; after each, the package `name` does a step on the present mesh."""
    parser = argparse.ArgumentParser(description=f"Heat conduction with {name} on a changing mesh.")
    parser.add_argument("--edge", type=float, default=0.03, help="target length of edges")
    parser.add_argument("--steps", type=int, default=10)
    parser.add_argument("--out", default=f"out/plate_{name}")
    parser.add_argument("--server", help="address of a dynmeshd; in process without")
    arguments = parser.parse_args()

    with opened(arguments.server, box=[[0, 0], [1, 1]], max_edge=arguments.edge) as mesh:
        follow(mesh, name, solve, arguments.steps, arguments.out)


def follow(mesh: dynmesh.Mesh, name: str, solve: Callable[[Part], Answer], steps: int,
           out: str) -> None:
    mesh.apply(
        add_points={1: (0, 0), 2: (1, 0), 3: (1, 1), 4: (0, 1), JOINT: joint(0, steps),
                    **disc(0, steps)},
        add_polygons={PLATE: (1, 2, 3, 4), DISC: range(11, 11 + CORNERS)},
        add_segments={LEFT: (4, 1)})
    u = np.zeros(mesh.vertex_slots)
    series = dynmesh.Series(f"{out}/plate.pvd")
    worst = dict.fromkeys(("areas", "lengths", "integrals", "edits", "balance"), 0.0)
    spent, changed = {"edits": 0.0, name: 0.0}, []

    def note(what: str, error: float) -> None:
        worst[what] = max(worst[what], error)

    for step in range(1, steps + 1):
        held = part_of(mesh, u).integral()
        start = time.perf_counter()
        diff = mesh.apply(
            move_points=disc(step, steps), add_points={JOINT + step: joint(step, steps)},
            add_segments={WIRE + step: (JOINT + step - 1, JOINT + step)})
        u = diff.transfer(u)
        spent["edits"] += time.perf_counter() - start
        changed.append(len(diff.patch.added_vertices) + len(diff.patch.removed_vertices))

        start = time.perf_counter()
        part = part_of(mesh, u)
        answer = solve(part)
        spent[name] += time.perf_counter() - start
        u[part.slots] = answer.u

        areas, lengths, heating = expected(step, steps)
        note("areas", difference(answer.areas, areas))
        note("lengths", difference(answer.lengths, lengths))
        note("integrals", abs(answer.heat - part.integral()))
        note("edits", abs(part.integral() - held))
        note("balance", abs(answer.heat_after - answer.heat - heating))
        series.add(step * TIME_STEP, mesh, point_data={"temperature": u})

    print(f"{mesh.vertex_count} vertices, {len(part.cells)} cells in the plate, {steps} edits: "
          f"{np.mean(changed):.0f} vertices changed an edit, {1e3 * spent['edits'] / steps:.1f} ms "
          f"an edit with transfer, {1e3 * spent[name] / steps:.0f} ms a step of {name}; "
          f"temperatures {answer.u.min():.6f} to {answer.u.max():.6f}")
    print(f"largest differences: areas {worst['areas']:.1e}, lengths {worst['lengths']:.1e}, "
          f"integral of the carried field {worst['integrals']:.1e}, heat that an edit lost "
          f"{worst['edits']:.1e}, balance of a step {worst['balance']:.1e}; series in "
          f"{series.path}")
    assert worst["areas"] < 1e-12, "a region has another area than its polygon"
    assert worst["lengths"] < 1e-12, "the facets of a marker are not those of the feature"
    assert worst["integrals"] < 1e-12, f"{name} integrates another field"
    assert worst["edits"] < 1e-12, "an edit lost heat"
    assert worst["balance"] < 1e-9, "a step does not gain what it is heated by"
    print("good")
