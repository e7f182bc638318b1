#!/usr/bin/env python3
"""A slanted crack in a plate under tension, which grows at both tips and turns.

Each tip grows in the direction of the greatest hoop stress, as K_I and K_II say. A part of the mesh
is opened along the crack. At the end several ways to go on are tried, and undone: the mesh comes
back to the bit.

    examples/crack_growth.py [--edge 0.1] [--steps 24] [--out out/crack_growth]

Writes a series for ParaView. Checks that the crack turns across the tension, that the energy
released from mesh to mesh is the J-integral, and that nothing of the part is outside of the plate.
"""
from __future__ import annotations

import argparse
import math

import numpy as np

import dynmesh
import elastic
from fem import is_all_of

PLATE, CRACK = 7, 20  # the plate's polygon; ids of the crack's points and segments follow
WIDTH, HEIGHT = 1.0, 2.0  # half of the plate's
GROWTH = 0.03  # of each tip in a step


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edge", type=float, default=0.1, help="target length away from the crack")
    parser.add_argument("--steps", type=int, default=24)
    parser.add_argument("--out", default="out/crack_growth")
    arguments = parser.parse_args()
    run(arguments.edge, arguments.steps, arguments.out)


class Plate:
    def __init__(self, edge: float) -> None:
        self.edge = edge
        self.ahead = {side: side * np.array([math.sqrt(0.5)] * 2) for side in (-1, 1)}
        self.tips = {side: 0.25 * ahead for side, ahead in self.ahead.items()}
        self.ends, self.next_id = {-1: CRACK, 1: CRACK + 1}, CRACK + 3
        corners = {1: (-WIDTH, -HEIGHT), 2: (WIDTH, -HEIGHT), 3: (WIDTH, HEIGHT), 4: (-WIDTH, HEIGHT)}
        self.mesh = dynmesh.open([[-WIDTH, -HEIGHT], [WIDTH, HEIGHT]], max_edge=edge)
        self.mesh.apply(
            add_points={**corners, **{self.ends[side]: tip for side, tip in self.tips.items()}},
            add_polygons={PLATE: corners},
            add_segments={8: (1, 2), 9: (3, 4), CRACK + 2: (CRACK, CRACK + 1)},
            add_sizes={**self.sizes(-1), **self.sizes(1)},
            set_labels={8: dict(name="bottom"), 9: dict(name="top"), CRACK + 2: dict(name="crack")})
        self.part = self.mesh.part(polygons=PLATE, open="crack")  # the seam

    def sizes(self, side: int) -> dict[int, dict]:
        """Discs around a tip, the inner ones finer."""
        return {1000 * (side + 2) + level: dict(at=self.tips[side], radius=0.32 * self.edge * 2**level,
                                               target=0.08 * self.edge * 2**level) for level in range(4)}

    def solve(self) -> tuple[np.ndarray, float]:
        return elastic.displacement(self.part, {"top": 1, "bottom": -1},
                                    [(-WIDTH, -HEIGHT), (WIDTH, -HEIGHT)])

    def grow(self, aheads: dict[int, np.ndarray]) -> dynmesh.Diff:
        """Lets tips grow in these directions."""
        points, segments, sizes = {}, {}, {}
        for side, ahead in aheads.items():
            self.tips[side] = self.tips[side] + GROWTH * ahead
            points[self.next_id] = self.tips[side]
            segments[self.next_id + 1] = (self.ends[side], self.next_id)
            self.ends[side], self.next_id = self.next_id, self.next_id + 2
            sizes.update(self.sizes(side))
        diff = self.mesh.apply(add_points=points, add_segments=segments, set_sizes=sizes,
                               set_labels={id_: dict(name="crack") for id_ in segments})
        self.part.update(diff)
        return diff

    def shrink(self, side: int, tip: np.ndarray, end: int) -> None:
        """Undoes the last growth of one tip."""
        self.tips[side], self.ends[side], self.next_id = tip, end, self.next_id - 2
        self.part.update(self.mesh.apply(remove=[self.next_id, self.next_id + 1],
                                         set_sizes=self.sizes(side)))


def turned(ahead: np.ndarray, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]]) @ ahead


def run(edge: float, steps: int, out: str) -> None:
    plate = Plate(edge)
    series = dynmesh.Series(f"{out}/crack_growth.pvd")
    former, ratios = None, []  # the first ones are those of a kink
    u, energy = plate.solve()
    for step in range(steps + 1):
        found = {side: elastic.intensities(plate.part, u, plate.tips[side], plate.ahead[side],
                                           0.1 if step == 0 else 0.9 * GROWTH) for side in (-1, 1)}
        released = sum(j for _, _, j in found.values()) / 2
        if former is not None:  # at both tips
            ratios.append((energy - former[0]) / (2 * GROWTH) / (0.5 * (released + former[1])))
        former = energy, released
        series.add(step, plate.part, point_data={"displacement": u})
        if step == steps:
            break
        for side, (first, second, _) in found.items():
            slant = second / first
            angle = 2 * math.atan(-2 * slant / (1 + math.sqrt(1 + 8 * slant**2)))
            plate.ahead[side] = turned(plate.ahead[side], angle)
        plate.grow(plate.ahead)
        u, energy = plate.solve()

    # Seven ways to go on at one tip, each undone: what an edit takes back leaves no trace.
    hash_, tip, end, tried = plate.mesh.hash, plate.tips[1], plate.ends[1], []
    for degrees in range(-60, 61, 20):
        plate.grow({1: turned(plate.ahead[1], math.radians(degrees))})
        tried.append((plate.solve()[1] - energy) / GROWTH / found[1][2])
        plate.shrink(1, tip, end)
        assert plate.mesh.hash == hash_, "the mesh has not come back"
    slope = abs(found[1][1] / found[1][0])
    print(f"{len(plate.part.points)} vertices; {steps} steps: tips at {plate.tips[-1].round(4)} and "
          f"{plate.tips[1].round(4)}, K_II / K_I {slope:.4f}, energy released / J from "
          f"{min(ratios[2:]):.3f} to {max(ratios[2:]):.3f}; tried: "
          f"{' '.join(f'{ratio:.2f}' for ratio in tried)}; series in {series.path}")
    assert is_all_of(plate.part, 4 * WIDTH * HEIGHT), "there are cells outside of the plate"
    assert np.abs(plate.tips[1] + plate.tips[-1]).max() < 0.01, "the tips do not grow alike"
    assert slope < 0.05, "the crack has not turned across the tension"
    assert all(abs(ratio - 1) < 0.05 for ratio in ratios[2:]), "the energy is not that of J"
    assert max(tried) == tried[3], "another way releases more energy"
    print("good")


if __name__ == "__main__":
    main()
