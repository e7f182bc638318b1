"""Converts edits from keyword arguments to a batch of the extension module."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from dynmesh import _core
from dynmesh._types import Array, Label


def _columns(value: Any, what: str) -> tuple[Array, Array]:
    """A dict of id to row, or (ids, rows), as two arrays."""
    if isinstance(value, Mapping):
        ids = _ids(list(value), what)
        rows = np.asarray(list(value.values()))
    else:
        try:
            ids, rows = value
        except (TypeError, ValueError) as error:
            raise TypeError(f"{what}: a dict of id to value, or (ids, values)") from error
        ids, rows = _ids(ids, what), np.asarray(rows)
    return ids, rows


def _ids(value: Any, what: str) -> Array:
    """Ids: whole numbers from 0 to 2^64 - 1."""
    if not isinstance(value, np.ndarray):
        value = list(value) if isinstance(value, Iterable) else [value]
        if not all(isinstance(v, (int, np.integer)) for v in value):
            raise TypeError(f"{what}: ids are whole numbers")
        if value and not 0 <= min(value) <= max(value) < 2**64:
            raise ValueError(f"{what}: ids are from 0 to 2^64 - 1")
        return np.array(value, dtype=np.uint64)
    ids = np.atleast_1d(value)
    if ids.size and ids.dtype.kind not in "iu":
        raise TypeError(f"{what}: ids are whole numbers, not {ids.dtype}")
    if ids.size and ids.min() < 0:
        raise ValueError(f"{what}: ids are from 0 to 2^64 - 1")
    return ids.astype(np.uint64)


def _points(batch: Any, action: str, value: Any, what: str) -> None:
    ids, places = _columns(value, what)
    if ids.size == 0:
        return
    places = places.astype(np.float64)
    if action == "move":
        batch.moves(ids, places)
    else:
        batch.points(action, ids, places)


def _segments(batch: Any, action: str, value: Any, what: str) -> None:
    ids, ends = _columns(value, what)
    if ids.size > 0:
        batch.segments(action, ids, _ids(ends.ravel(), what).reshape(ends.shape))


def _rings(value: Any) -> list[list[int]]:
    rings = [list(ring) if isinstance(ring, Iterable) else ring for ring in value]
    if rings and not isinstance(rings[0], list):
        rings = [rings]  # one ring
    return [[int(corner) for corner in ring] for ring in rings]


def _polygons(batch: Any, action: str, value: Any, what: str) -> None:
    if not isinstance(value, Mapping):
        raise TypeError(f"{what}: a dict of id to ring, or to a list of rings")
    for id_, rings in value.items():
        batch.polygon(action, id_, _rings(rings))


_OF_A_SIZE = ("at", "radius", "low", "high", "rings", "path", "target")


def _sizes(batch: Any, action: str, value: Any, what: str) -> None:
    if not isinstance(value, Mapping):
        raise TypeError(f"{what}: a dict of id to dict(at=, radius=, target=) or the like")
    for id_, size in value.items():
        size = dict(size)
        unknown = set(size) - set(_OF_A_SIZE)
        if unknown:
            raise ValueError(f"{what}: there is no {sorted(unknown)[0]} of a size; there are "
                             + ", ".join(_OF_A_SIZE))
        if "rings" in size:
            size["rings"] = _rings(size["rings"])
        batch.size(action, id_, size)


def _remove(batch: Any, action: str, value: Any, what: str) -> None:
    batch.remove(_ids(value, what))


def _labels(batch: Any, action: str, value: Any, what: str) -> None:
    if not isinstance(value, Mapping):
        raise TypeError(f"{what}: a dict of id to Label, or to dict(marker=, name=)")
    for id_, label in value.items():
        if label is None:
            label = Label()
        elif not isinstance(label, Label):
            label = Label(**label)
        batch.label(id_, label.marker, label.name)


_Adder = Callable[[Any, str, Any, str], None]
_KINDS: dict[str, _Adder] = {"points": _points, "segments": _segments, "polygons": _polygons,
                             "sizes": _sizes}
_ACTIONS: dict[str, tuple[_Adder, str]] = {
    f"{action}_{kind}": (function, action)
    for kind, function in _KINDS.items() for action in ("add", "set")}
_ACTIONS["move_points"] = (_points, "move")
_ACTIONS["remove"] = (_remove, "")
_ACTIONS["set_labels"] = (_labels, "")


def make(dimension: int, edits: Mapping[str, Any]) -> Any:
    """A batch of `edits`, applied in their order."""
    batch = _core.Batch(dimension)
    for name, value in edits.items():
        if name not in _ACTIONS:
            raise TypeError(f"there is no edit {name}; there are {', '.join(sorted(_ACTIONS))}")
        function, action = _ACTIONS[name]
        function(batch, action, value, name)
    return batch
