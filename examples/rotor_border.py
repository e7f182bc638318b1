#!/usr/bin/env python3
"""A rotor and its stator, meshed apart, with the same points on the circle between them.

The circle stays whole: neither mesh puts a vertex on it, however fine it is beside it. So the two
fit together, in each position that turns the circle's points onto themselves.

    examples/rotor_border.py [--spacing 0.05] [--steps 6] [--out out/rotor] [--server HOST:PORT]

Writes both parts for ParaView, and checks that they are equal on the circle, before and after a hole
comes into the rotor, that they cover the whole without a gap, and that the turned rotor still fits.
"""
from __future__ import annotations

import argparse
import os

import numpy as np

import dynmesh
from opened import opened

RADIUS, OUTER = 0.5, 0.9
ROTOR, STATOR, HOLE = 1_000_000, 1_000_001, 1_000_002  # polygons; ids of points are smaller


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spacing", type=float, default=0.05, help="of points on the circle")
    parser.add_argument("--steps", type=int, default=6, help="positions of the rotor")
    parser.add_argument("--out", default="out/rotor")
    parser.add_argument("--server", help="address of a dynmeshd; in process without")
    arguments = parser.parse_args()
    box = [[-1, -1], [1, 1]]
    with opened(arguments.server, box=box) as rotor, opened(arguments.server, box=box) as stator:
        run(rotor, stator, arguments.spacing, arguments.steps, arguments.out)


def circle(radius: float, spacing: float) -> np.ndarray:
    def at(t: float) -> tuple[float, float]:
        return radius * np.cos(2 * np.pi * t), radius * np.sin(2 * np.pi * t)

    return dynmesh.points_along(at, spacing, closed=True)


def run(rotor: dynmesh.Mesh, stator: dynmesh.Mesh, spacing: float, steps: int, out: str) -> None:
    inner, outer = circle(RADIUS, spacing), circle(OUTER, 2 * spacing)
    on_circle = np.arange(1, len(inner) + 1)
    on_outer = np.arange(len(inner) + 1, len(inner) + len(outer) + 1)
    rotor.apply(add_points=(on_circle, inner), add_polygons={ROTOR: on_circle.tolist()},
                unsplit=[ROTOR])
    stator.apply(add_points=(np.concatenate([on_circle, on_outer]), np.vstack([inner, outer])),
                 add_polygons={STATOR: [on_circle.tolist(), on_outer.tolist()]}, unsplit=True,
                 add_sizes={STATOR + 10: dict(target=spacing / 2, at=(0.7, 0), radius=0.1)})
    ring = stator.part(polygons=STATOR)
    check_circle(ring, inner)
    check_circle(rotor.part(polygons=ROTOR), inner)

    # A hole comes into the rotor: nothing changes on the circle.
    hole = circle(0.1, spacing / 4) + np.array([0.2, 0])
    on_hole = np.arange(10_001, 10_001 + len(hole))
    rotor.apply(add_points=(on_hole, hole), set_polygons={ROTOR: [on_circle.tolist(),
                                                                  on_hole.tolist()]},
                unsplit=[ROTOR])
    disc = rotor.part(polygons=ROTOR)
    check_circle(disc, inner)
    whole = area(outer) - area(hole)
    assert abs(area_of(disc) + area_of(ring) - whole) < 1e-12, "the two do not cover the whole"

    # Positions in which the rotor's points are the stator's.
    border = ring.points[on(ring, RADIUS)]
    for step in range(steps):
        angle = 2 * np.pi * step / len(inner)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        turned = disc.points[on(disc, RADIUS)] @ turn.T
        apart = np.linalg.norm(turned[:, None] - border[None], axis=2).min(axis=1).max()
        assert apart < 1e-12, f"the rotor does not fit at {np.degrees(angle):g} degrees"

    os.makedirs(out, exist_ok=True)
    disc.write(f"{out}/rotor.vtu")
    ring.write(f"{out}/stator.vtu")
    print(f"{len(inner)} points on the circle; rotor {len(disc.points)} and stator "
          f"{len(ring.points)} vertices; least angles {least_angle(disc):.1f} and "
          f"{least_angle(ring):.1f} degrees")


def on(part: dynmesh.Part, radius: float) -> np.ndarray:
    """The part's vertices at that distance from the centre."""
    return np.flatnonzero(np.abs(np.linalg.norm(part.points, axis=1) - radius) < 1e-12)


def check_circle(part: dynmesh.Part, given: np.ndarray) -> None:
    """The part's points on the circle are those given, to the bit, and joined one to the next."""
    at = on(part, RADIUS)
    assert sorted(map(tuple, part.points[at])) == sorted(map(tuple, given)), "points were added"
    joined = np.isin(part.facets, at).all(axis=1).sum()
    assert joined == len(given), "an edge of the circle is missing"


def area(ring: np.ndarray) -> float:
    after = np.roll(ring, -1, axis=0)
    return float((ring[:, 0] * after[:, 1] - ring[:, 1] * after[:, 0]).sum() / 2)


def corners_of(part: dynmesh.Part) -> np.ndarray:
    return part.points[part.cells]


def area_of(part: dynmesh.Part) -> float:
    a, b, c = np.moveaxis(corners_of(part), 1, 0)
    u, v = b - a, c - a
    return float((u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() / 2)


def least_angle(part: dynmesh.Part) -> float:
    corners = corners_of(part)
    angles = []
    for i in range(3):
        u, v = corners[:, (i + 1) % 3] - corners[:, i], corners[:, (i + 2) % 3] - corners[:, i]
        angles.append(np.arccos((u * v).sum(axis=1) /
                                (np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1))))
    return float(np.degrees(np.min(angles)))


if __name__ == "__main__":
    main()
