"""Corners of polygons that come and go with points on their edges."""
from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Optional, TypeVar

import numpy as np

from dynmesh._types import Array
from dynmesh.errors import DynmeshError, FailedPrecondition

T = TypeVar("T")
_STRAIGHT = 1e-9  # of a corner that may go: its distance from the line, as a part of its length


class _Rings:
    """Points and polygons as they are after a batch of edits."""

    def __init__(self, features: list[dict[str, Any]], edits: Mapping[str, Any]) -> None:
        self.points = {f["id"]: f["at"] for f in features if f["kind"] == "point"}
        self.rings = {f["id"]: [list(ring) for ring in f["rings"]] for f in features
                      if f["kind"] == "polygon"}
        for name, rows in edits.items():
            if not name.endswith(("_points", "_polygons")):
                continue
            for id_, row in rows.items() if isinstance(rows, Mapping) else zip(*rows):
                if name.endswith("_points"):
                    self.points[int(id_)] = row
                else:
                    row = list(row)
                    nested = bool(row) and np.ndim(row[0]) > 0
                    self.rings[int(id_)] = [list(ring) for ring in (row if nested else [row])]

    def at(self, point: int) -> Array:
        return np.asarray(self.points[point], dtype=float)

    def distance(self, point: int, a: int, b: int) -> float:
        """From the segment between two points, as a part of its length."""
        along = self.at(b) - self.at(a)
        place = np.clip((self.at(point) - self.at(a)) @ along / (along @ along), 0, 1)
        off = self.at(point) - self.at(a) - place * along
        return float(np.sqrt((off @ off) / (along @ along)))

    def with_corner(self, point: int, polygon: int) -> Optional[list[list[int]]]:
        """The polygon's rings with the point in its nearest edge."""
        rings = self.rings[polygon]
        if point not in self.points or any(point in ring for ring in rings):
            return None
        edges = [(self.distance(point, ring[i - 1], ring[i]), r, i)
                 for r, ring in enumerate(rings) for i in range(len(ring))]
        _, r, i = min(edges)
        return [ring[:i] + [point] + ring[i:] if r == at else ring for at, ring in enumerate(rings)]

    def without_corner(self, point: int, polygon: int) -> Optional[list[list[int]]]:
        """The polygon's rings without the point, if they are straight there."""
        rings = []
        for ring in self.rings[polygon]:
            if point in ring:
                i = ring.index(point)
                before, after = ring[i - 1], ring[(i + 1) % len(ring)]
                if len(ring) < 4 or self.distance(point, before, after) > _STRAIGHT:
                    return None
                ring = ring[:i] + ring[i + 1:]
            rings.append(ring)
        return rings


def _mended(error: DynmeshError, features: list[dict[str, Any]],
            edits: Mapping[str, Any]) -> Optional[dict[str, Any]]:
    """The edits with one more `set_polygons` that does away with the error; None if none does."""
    state = _Rings(features, edits)
    involved = list(error.features)
    changed: dict[int, list[list[int]]] = {}
    for polygon in involved:
        for point in involved:
            if polygon not in state.rings or point in state.rings or point not in state.points:
                continue
            rings = (state.without_corner(point, polygon) if error.reason == "POINT_IN_USE" else
                     state.with_corner(point, polygon))
            if rings is not None:
                changed[polygon] = rings
    if not changed:
        return None
    present = edits.get("set_polygons", {})
    if not isinstance(present, Mapping):
        present = dict(zip(*present))
    marked = _marked(edits)
    kept = {f["id"] for f in features if f.get("unsplit")} - _named(edits)
    marked += [polygon for polygon in changed if polygon in kept and polygon not in marked]
    # At the end: it acts on polygons that the batch adds.
    return {**{name: rows for name, rows in edits.items()
               if name not in ("set_polygons", "unsplit")},
            "set_polygons": {**present, **changed}, "unsplit": marked}


def _named(edits: Mapping[str, Any]) -> set[int]:
    """The segments and polygons that the edits add or set."""
    kinds = ("add_segments", "set_segments", "add_polygons", "set_polygons")
    rows = [edits[kind] for kind in kinds if kind in edits]
    return {int(id_) for given in rows
            for id_ in (given if isinstance(given, Mapping) else given[0])}


def _marked(edits: Mapping[str, Any]) -> list[int]:
    """Those of them that are unsplit."""
    unsplit = edits.get("unsplit")
    if unsplit is None or isinstance(unsplit, (bool, np.bool_)):
        return sorted(_named(edits)) if unsplit else []
    return [int(id_) for id_ in np.atleast_1d(np.asarray(unsplit))]


def apply_joined(edits: dict[str, Any], features: Callable[[], list[dict[str, Any]]],
                 apply: Callable[[dict[str, Any]], T]) -> T:
    """What `apply` of the edits returns, with corners that come and go as they must."""
    present: Optional[list[dict[str, Any]]] = None
    while True:
        try:
            return apply(edits)
        except FailedPrecondition as error:
            if error.reason not in ("POINT_ON_SEGMENT", "TOO_CLOSE", "POINT_IN_USE"):
                raise
            if present is None:
                present = features()
            mended = _mended(error, present, edits)
            if mended is None:
                raise
            edits = mended
