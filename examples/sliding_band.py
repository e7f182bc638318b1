"""Two parts that slide along a circle, on which they have the same vertices: what bands are compared with."""
from __future__ import annotations

import math

import numpy as np

import dynmesh


class SlidingBand:
    """A rotor in a stator, which are in step: angles are those of whole edges of the circle."""

    def __init__(self, rotor: dynmesh.Part, stator: dynmesh.Part, circle: np.ndarray) -> None:
        self._parts, self._edge = (rotor, stator), math.tau / len(circle)
        rows = [{tuple(at): row for row, at in enumerate(part.points.tolist())} for part in self._parts]
        self._on_circle = [np.array([of[tuple(at)] for at in circle.tolist()]) for of in rows]
        self.facet_markers = np.concatenate([part.facet_markers for part in self._parts])
        self.of_stator = np.arange(len(rotor.cells) + len(stator.cells)) >= len(rotor.cells)
        self.turn(0)

    def turn(self, angle: float) -> None:
        rotor, stator = self._parts
        edges = round(angle / self._edge)
        assert abs(edges * self._edge - angle) < 1e-9, "the circle has no vertex there"
        turned = dynmesh.Frame(angle).place(rotor.points)
        self.points = np.vstack([turned, stator.points])
        # On the circle the stator has the rotor's vertices; its own are in no cell.
        numbers = len(turned) + np.arange(len(stator.points))
        numbers[self._on_circle[1]] = np.roll(self._on_circle[0], edges)
        self.cells = np.vstack([rotor.cells, numbers[stator.cells]])
        self.facets = np.vstack([rotor.facets, numbers[stator.facets]])
