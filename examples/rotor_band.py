#!/usr/bin/env python3
"""The torque on a rotor that turns in a stator, beside that of a sliding band.

A bar at potential 1 turns in a bore with a slot at 0. Rotor and stator are meshed once; an assembly
meshes the band between them in each position.

    examples/rotor_band.py [--spacing 0.0175] [--steps 360] [--out out/rotor_band]

Writes a series for ParaView, and checks that the rotor's mesh stays to the bit while it turns, that areas are
exact, that the energy is smooth, and that the torque is that of a finer mesh which slides along a circle.
"""
from __future__ import annotations

import argparse
import math

import numpy as np

import dynmesh
from fem import Elements, measure_of, solve
from sliding_band import SlidingBand

ROTOR, BAR, STATOR, BORE = 10_001, 10_002, 10_003, 10_004  # polygons; ids of points are smaller
INNER, OUTER, RADIUS = 0.5, 0.55, 0.6  # the band's circles, and the bore
BOX = [[-1, -1], [1, 1]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spacing", type=float, default=0.0175, help="of vertices on the circles")
    parser.add_argument("--steps", type=int, default=360, help="of a whole turn")
    parser.add_argument("--out", default="out/rotor_band")
    arguments = parser.parse_args()
    run(arguments.spacing, arguments.steps, arguments.out)


def circle(radius: float, spacing: float) -> np.ndarray:
    return dynmesh.points_along(lambda t: (radius * math.cos(math.tau * t), radius * math.sin(math.tau * t)),
                                spacing, closed=True)


def rotor_in(inner: np.ndarray) -> dynmesh.Part:
    """A disc with a hole for the bar."""
    bar = np.array([(-.42, -.1), (.42, -.1), (.42, .1), (-.42, .1)])
    mesh = dynmesh.open(BOX, max_edge=0.05)
    add_loops(mesh, {ROTOR: inner, BAR: bar}, [ROTOR])
    mesh.apply(add_sizes={20_000 + i: dict(at=at, radius=0.05, target=0.0125) for i, at in enumerate(bar)},
               set_labels={BAR: dict(marker=1, name="bar"), ROTOR: dict(name="rotor")})
    return mesh.part(polygons=ROTOR, without=BAR)


def stator_around(circles: list[np.ndarray]) -> dynmesh.Part:
    """What is between the first circle and the bore, which has a slot at the top; all circles stay whole."""
    half = math.asin(0.12 / RADIUS)
    angles = np.linspace(math.pi / 2 + half, 5 * math.pi / 2 - half, 72)
    bore = RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
    slot = [(0.12, RADIUS * math.cos(half) + 0.2), (-0.12, RADIUS * math.cos(half) + 0.2)]
    mesh = dynmesh.open(BOX, max_edge=0.05)
    bores = {BORE + i: at for i, at in enumerate(circles)}
    add_loops(mesh, {STATOR: np.vstack([bore, slot]), **bores}, list(bores))
    mesh.apply(add_sizes={20_000 + i: dict(at=bore[k], radius=0.05, target=0.0125)
                          for i, k in enumerate((0, -1))},
               set_labels={STATOR: dict(marker=2, name="stator")})
    return mesh.part(polygons=STATOR, without=BORE)


def add_loops(mesh: dynmesh.Mesh, loops: dict[int, np.ndarray], unsplit: list[int]) -> None:
    first = np.cumsum([1] + [len(at) for at in loops.values()])
    mesh.apply(add_points=(np.arange(1, first[-1]), np.vstack(list(loops.values()))),
               add_polygons={id_: list(range(a, b)) for id_, a, b in zip(loops, first, first[1:])},
               unsplit=unsplit)


def run(spacing: float, steps: int, out: str) -> None:
    inner, outer = circle(INNER, spacing), circle(OUTER, spacing)
    rotor, stator = rotor_in(inner), stator_around([outer])
    assembly = dynmesh.Assembly()
    assembly.add("rotor", rotor)
    assembly.add("stator", stator)
    assembly.band("gap", outer=("stator", outer), inner=("rotor", inner))
    whole, hash_, rows = measure_of(assembly), rotor.mesh.hash, assembly.cells[assembly.cells_of("rotor")]
    gap = np.zeros(len(assembly.cells), bool)
    gap[assembly.cells_of("gap")] = True

    series = dynmesh.Series(f"{out}/rotor.pvd")
    energy, torque = np.zeros(steps), np.zeros(steps)
    u = np.zeros(len(assembly.points))
    for step in range(steps):
        motion = assembly.turn("rotor", math.tau * step / steps)
        u = motion.transfer(u)  # the first guess of the solver
        u, energy[step] = potential(assembly, u)
        torque[step] = arkkio(assembly, u, gap)
        assert abs(measure_of(assembly) - whole) < 1e-12, "the parts and the band do not cover the whole"
        if step % max(1, steps // 36) == 0:
            series.add(step, assembly, point_data={"u": u})
    assert rotor.mesh.hash == hash_, "the rotor's mesh has changed"
    assert np.array_equal(assembly.cells[assembly.cells_of("rotor")], rows), "its numbers have"

    every = max(1, steps // 36)
    exact = torque_of_sliding_band(math.tau * np.arange(0, steps, every) / steps)
    off = np.abs(torque[::every] - exact).max() / np.abs(exact).max()
    rough = roughness(energy) / np.ptp(energy)
    print(f"{len(assembly.points)} vertices, {steps} steps: torque within {off:.2%} of a sliding band's; energy's noise "
          f"{rough:.1e} of its range; series in {series.path}")
    assert off < 0.01, "the torque is wrong"
    assert rough < 1e-4, "the energy is not smooth"
    print("good")


def potential(domain: dynmesh.Assembly | SlidingBand, guess: np.ndarray) -> tuple[np.ndarray, float]:
    """1 on the bar, 0 on the bore; and its energy."""
    elements = Elements(domain)
    stiffness = elements.matrix(elements.stiffness)
    fixed = np.zeros(len(guess), bool)
    for marker in (1, 2):
        ends = domain.facets[domain.facet_markers == marker]
        guess[ends], fixed[ends] = marker == 1, True
    u = solve(stiffness, np.zeros(len(guess)), guess, fixed)
    return u, float(u @ (stiffness @ u)) / 2


def arkkio(domain: dynmesh.Assembly | SlidingBand, u: np.ndarray, gap: np.ndarray) -> float:
    """The torque, as a mean over the gap."""
    corners = domain.points[domain.cells[gap]]
    edges = corners[:, 1:] - corners[:, :1]
    jumps = u[domain.cells[gap]]
    field = -np.linalg.solve(edges, (jumps[:, 1:] - jumps[:, :1])[:, :, None])[:, :, 0]
    middle = corners.mean(axis=1)
    radius = np.linalg.norm(middle, axis=1)
    along = (field * middle).sum(axis=1) / radius
    across = (field[:, 1] * middle[:, 0] - field[:, 0] * middle[:, 1]) / radius
    return float((radius * along * across * np.linalg.det(edges)).sum() / 2 / (OUTER - INNER))


def torque_of_sliding_band(angles: np.ndarray) -> np.ndarray:
    """Of a finer mesh, which slides along the inner circle by whole edges."""
    inner, outer = circle(INNER, math.tau * INNER / 720), circle(OUTER, math.tau * INNER / 720)
    band = SlidingBand(rotor_in(inner), stator_around([inner, outer]), inner)
    torque, u = [], np.zeros(len(band.points))
    for angle in angles:
        band.turn(angle)
        gap = band.of_stator & (np.linalg.norm(band.points[band.cells].mean(axis=1), axis=1) < OUTER)
        u, _ = potential(band, u)
        torque.append(arkkio(band, u, gap))
    return np.array(torque)


def roughness(energy: np.ndarray) -> float:
    """What is left of the energy, as root mean square, beside polynomials over each sixth of a turn."""
    rest = []
    for part in np.split(energy, 6):
        at = np.arange(len(part))
        rest.append(part - np.polynomial.Chebyshev.fit(at, part, 12)(at))
    return float(np.sqrt(np.mean(np.square(rest))))


if __name__ == "__main__":
    main()
