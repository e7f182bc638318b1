#!/usr/bin/env python3
"""Finite volumes: a disc of dye goes around in a square, on a mesh that is fine along its rim.

Values are means over median-dual cells, which are carried as P1: the integral of that function is the sum of
volume times mean.

    examples/dye.py [--edge 0.06] [--steps 60] [--out out/dye]

Writes a series for ParaView, and checks that no dye is lost, that its concentration stays from 0 to 1,
that nothing of the mesh is outside of the square, and that its middle comes back to its place.
"""
from __future__ import annotations

import argparse
import math

import numpy as np

import dynmesh

SQUARE, RIM = 10, 20  # the polygon; the size along the rim
RADIUS = 0.15  # of the disc


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edge", type=float, default=0.06, help="target length; a fifth of it at the rim")
    parser.add_argument("--steps", type=int, default=60, help="edits of one turn")
    parser.add_argument("--out", default="out/dye")
    arguments = parser.parse_args()
    run(arguments.edge, arguments.steps, arguments.out)


def run(edge: float, steps: int, out: str) -> None:
    mesh = dynmesh.open(box=[[0, 0], [1, 1]], max_edge=edge)
    corners = {11: (0, 0), 12: (1, 0), 13: (1, 1), 14: (0, 1)}
    mesh.apply(add_points=corners, add_polygons={SQUARE: corners}, add_sizes=rim(0, edge))
    part = mesh.part(polygons=SQUARE)
    u = is_dyed(part, 0).astype(float)
    dye = DualCells(part).volume @ u
    series = dynmesh.Series(f"{out}/dye.pvd")
    lost = 0.0
    for step in range(1, steps + 1):
        u = DualCells(part).advected(u, 1 / steps)
        u = part.transfer(mesh.apply(set_sizes=rim(step / steps, edge)), u, bounded=True)
        volume = DualCells(part).volume
        lost = max(lost, abs(volume @ u / dye - 1))
        assert abs(volume.sum() - 1) < 1e-13, "there are cells outside of the square"
        assert -1e-12 < u.min() and u.max() < 1 + 1e-12, "a concentration is out of range"
        series.add(step, part, point_data={"dye": u})
    off = np.linalg.norm((volume * u) @ part.points / dye - centre(1)) / RADIUS
    print(f"{len(u)} vertices, {steps} edits: dye lost {lost:.1e} of it, its middle {off:.1%} of the radius off; "
          f"series in {series.path}")
    assert lost < 1e-12, "dye is lost"
    assert off < 3 * edge, "the disc has not come back"  # the scheme is of first order
    print("good")


def centre(turn: float) -> np.ndarray:
    return np.array([0.5 + 0.25 * math.cos(math.tau * turn), 0.5 + 0.25 * math.sin(math.tau * turn)])


def rim(turn: float, edge: float) -> dict[int, dict]:
    angles = np.linspace(0, math.tau, 25)
    path = centre(turn) + RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
    return {RIM: dict(path=path, radius=edge / 2, target=edge / 5)}


def is_dyed(part: dynmesh.Part, turn: float) -> np.ndarray:
    return np.linalg.norm(part.points - centre(turn), axis=1) < RADIUS


class DualCells:
    """Median-dual cells around the vertices of a part, and the faces between them."""

    def __init__(self, part: dynmesh.Part) -> None:
        points, cells = part.points, part.cells
        edges = points[cells][:, 1:] - points[cells][:, :1]
        self.volume = np.bincount(cells.ravel(), np.repeat(np.linalg.det(edges) / 6, 3), len(points))
        ends = [cells[:, [k, (k + 1) % 3]] for k in range(3)]
        middles = [points[pair].mean(axis=1) for pair in ends]
        across = [points[cells].mean(axis=1) - middle for middle in middles]
        self.ends, self.middles = np.concatenate(ends), np.concatenate(middles)
        self.normals = np.concatenate(across)[:, ::-1] * [1, -1]  # times the length

    def advected(self, u: np.ndarray, turn: float) -> np.ndarray:
        """The means after a part of a turn about the middle of the square, upwind."""
        velocity = math.tau * (self.middles - 0.5)[:, ::-1] * [-1, 1]
        flux = (velocity * self.normals).sum(axis=1)
        a, b = self.ends.T
        count = len(u)
        out = np.bincount(a, np.maximum(flux, 0), count) + np.bincount(b, np.maximum(-flux, 0), count)
        into = out - np.bincount(a, flux, count) + np.bincount(b, flux, count)
        times = math.ceil(turn / (0.9 * (self.volume / np.maximum(out, into)).min()))
        for _ in range(times):
            moved = np.maximum(flux, 0) * u[a] + np.minimum(flux, 0) * u[b]
            u = u + turn / times * (np.bincount(b, moved, count) - np.bincount(a, moved, count)) / self.volume
        return u


if __name__ == "__main__":
    main()
