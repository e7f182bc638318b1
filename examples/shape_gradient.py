#!/usr/bin/env python3
"""Shape optimisation: a cooled hole in a heated plate moves to where it cools best.

The hole is a polygon. The gradient of the mean temperature is computed by finite differences: the
hole is moved a little and back. The mesh is a function of its features, so it is restored to the
bit, and the differences depend on the shape only, not on the history of edits.

    examples/shape_gradient.py [--edge 0.04] [--steps 12] [--out out/shape_gradient]

Writes a series for ParaView. Checks that the mean temperature falls, that the hole moves to the
heat, and that the mesh is restored after each difference.
"""
from __future__ import annotations

import argparse
import math

import numpy as np

import dynmesh
import fem

CORNERS, HOLE, PLATE = 24, 100, 200
HEAT = np.array([0.68, 0.62])  # where the plate is heated most


class Plate:
    """The plate with its hole at `middle`, and the temperature on it."""

    def __init__(self, edge: float) -> None:
        self.mesh = dynmesh.open([[0, 0], [1, 1]], max_edge=edge)
        self.middle = np.array([0.3, 0.35])
        outline = {PLATE + 1: (0, 0), PLATE + 2: (1, 0), PLATE + 3: (1, 1), PLATE + 4: (0, 1)}
        self.mesh.apply(add_points={**self._corners(self.middle), **outline},
                        add_polygons={HOLE: range(1, CORNERS + 1), PLATE: outline})
        self.part = self.mesh.part(polygons=PLATE, without=HOLE)
        self.elements = fem.Elements(self.part)
        self.temperature = np.zeros(self.mesh.vertex_slots)

    @staticmethod
    def _corners(middle: np.ndarray) -> dict[int, np.ndarray]:
        angles = [2 * math.pi * k / CORNERS for k in range(CORNERS)]
        return {k + 1: middle + 0.07 * np.array([math.cos(a), math.sin(a)])
                for k, a in enumerate(angles)}

    def move(self, middle: np.ndarray) -> None:
        diff = self.mesh.apply(move_points=self._corners(middle))
        self.temperature = diff.transfer(self.temperature)  # the solver's first guess
        self.part.update(diff)
        self.elements.follow()
        self.middle = middle

    def mean(self) -> float:
        """Solves, and returns the mean temperature of the plate."""
        part, elements = self.part, self.elements
        mass, stiffness = elements.matrix(elements.mass), elements.matrix(elements.stiffness)
        fixed = fem.vertices_of(part, HOLE, HOLE)
        u = self.temperature[part.vertex_slots]
        u[fixed] = 0
        distance2 = ((part.points - HEAT) ** 2).sum(axis=1)
        u = fem.solve(stiffness, mass @ np.exp(-distance2 / 0.15**2), u, fixed)
        self.temperature[part.vertex_slots] = u
        weights = mass.sum(axis=0)
        return float(np.asarray(weights @ u).item() / weights.sum())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edge", type=float, default=0.04)
    parser.add_argument("--steps", type=int, default=12)
    parser.add_argument("--out", default="out/shape_gradient")
    arguments = parser.parse_args()

    plate = Plate(arguments.edge)
    series = dynmesh.Series(f"{arguments.out}/shape_gradient.pvd")
    means = [plate.mean()]
    step = 0.1
    for iteration in range(arguments.steps):
        temperature = plate.temperature[plate.part.vertex_slots]
        series.add(iteration, plate.part, point_data={"temperature": temperature})
        middle, here, gradient = plate.middle, plate.mesh.hash, np.zeros(2)
        for axis in range(2):
            little = 0.01 * np.eye(2)[axis]
            ahead, behind = (plate.move(middle + s * little) or plate.mean() for s in (1, -1))
            gradient[axis] = (ahead - behind) / 0.02
        plate.move(middle)
        assert plate.mesh.hash == here, "the mesh did not come back"
        direction = gradient / np.linalg.norm(gradient)
        while step > 1e-3:
            plate.move(np.clip(middle - step * direction, 0.1, 0.9))
            mean = plate.mean()
            if mean < means[-1]:
                means.append(mean)
                break
            step /= 2
        else:
            plate.move(middle)
            break

    print(f"{len(plate.part.points)} vertices; mean temperature {means[0]:.5f} to {means[-1]:.5f} "
          f"in {len(means) - 1} steps and {plate.mesh.revision} edits; hole at "
          f"({plate.middle[0]:.3f}, {plate.middle[1]:.3f}); series in {series.path}")
    assert all(b < a for a, b in zip(means, means[1:])), "a step made it hotter"
    assert np.linalg.norm(plate.middle - HEAT) < 0.2, "the hole did not find the heat"
    print("good")


if __name__ == "__main__":
    main()
