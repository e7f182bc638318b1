"""Converts edits from keyword arguments to a batch of the extension module.

What is of the wrong form is refused here, with the argument, what it needs and what came. Whether
the features fit each other and the mesh is for the mesher to say.
"""
from __future__ import annotations

import numbers
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from dynmesh import _core
from dynmesh._types import Array, Label

_FORMS = {
    "points": "{1: (0.2, 0.3), 2: (0.8, 0.3)} or ([1, 2], [[0.2, 0.3], [0.8, 0.3]]), in 3D with z",
    "segments": "{10: (1, 2), 11: (2, 3)} or ([10, 11], [[1, 2], [2, 3]]), of ids of points",
    "polygons": "{20: (1, 2, 3)} or, with a hole, {20: [(1, 2, 3), (4, 5, 6)]}, of ids of points",
    "sizes": "{30: dict(target=0.01, at=(0.5, 0.5), radius=0.1)}; other members are low= and "
             "high=, rings=, or path= with radius=",
    "labels": "{10: dict(marker=3, name='wall')}, dynmesh.Label or None",
    "remove": "[1, 2, 10]",
    "unsplit": "True, for all segments and polygons of these edits, or [10, 20], their ids",
}


def _shown(value: Any) -> str:
    text = repr(value).replace("\n", " ")
    return text if len(text) <= 60 else text[:57] + "..."


def _expected(what: str, got: Any = None, text: str = "") -> str:
    """What an argument has to look like; `text` says more about what came."""
    form = _FORMS.get(what.split("_", 1)[-1], "")
    came = text or f"got {_shown(got)}"
    return f"{what}: {came}; expected is {what}={form}"


def _ids(value: Any, what: str, of: str = "ids") -> Array:
    """Ids: whole numbers. Whether a feature may have an id is for the mesher to say."""
    def refuse(bad: Any) -> None:
        raise TypeError(_expected(what, text=f"{of} are whole numbers, and got {_shown(bad)}"))

    if isinstance(value, np.ndarray):
        ids = np.atleast_1d(value)
        if ids.size and ids.dtype.kind not in "iu":
            refuse(ids.ravel()[0])
        least = ids.min() if ids.size else 1
        most = ids.max() if ids.size else 1
    else:
        is_many = isinstance(value, Iterable) and not isinstance(value, (str, bytes))
        entries = list(value) if is_many else [value]
        for id_ in entries:
            if not isinstance(id_, (int, np.integer)) or isinstance(id_, bool):
                refuse(id_)
        least, most = min(entries, default=1), max(entries, default=1)
        if 0 <= least and most < 2**64:
            ids = np.array(entries, dtype=np.uint64)
    if least < 0 or most >= 2**64:
        raise ValueError(f"{what}: {of} are from 1 to {_core.last_feature_id}, and got "
                         f"{least if least < 0 else most}")
    return ids.astype(np.uint64)


def _columns(value: Any, what: str, width: int, of: str) -> tuple[Array, Array]:
    """A dict of id to row, or (ids, rows), as two arrays; a row has `width` entries: `of`."""
    given: Any
    if isinstance(value, Mapping):
        given, rows = list(value), list(value.values())
    else:
        if isinstance(value, np.ndarray) or not _is_pair(value):
            raise TypeError(_expected(what, value, "" if _is_pair(value) else
                                      f"there are no ids in {_shown(value)}"))
        given, rows = value
        if not isinstance(given, np.ndarray) and isinstance(given, Iterable) and any(
                isinstance(id_, numbers.Real) and not isinstance(id_, numbers.Integral)
                for id_ in given):
            raise TypeError(_expected(what, text=f"ids are whole numbers, and there are none in "
                                                 f"{_shown(value)}"))
    ids = _ids(given, what)
    array: Array
    try:
        array = np.asarray(rows)
    except ValueError:  # rows of several lengths
        array = np.empty(0, object)
    if ids.ndim != 1:
        raise TypeError(_expected(what, text=f"ids are a list, and got {ids.ndim} axes"))
    if array.dtype.kind not in "fiu" or array.shape != (len(ids), width):
        if not len(ids) and not array.size:
            return ids, array.reshape(0, width)
        raise ValueError(_expected(what, text=_what_rows_came(ids, rows, array, width, of)))
    return ids, array


def _is_pair(value: Any) -> bool:
    return isinstance(value, (tuple, list)) and len(value) == 2


def _what_rows_came(ids: Array, rows: Any, array: Array, width: int, of: str) -> str:
    """What is wrong with rows: the first of the wrong length, or their number."""
    if array.ndim < 2 and not isinstance(rows, list):  # a pair of something else
        return (f"a pair is (ids, values), and there are {of} for each id: got the ids "
                f"{_shown(ids.tolist())} and the values {_shown(rows)}")
    if isinstance(rows, (list, tuple)):
        for id_, row in zip(ids.tolist(), rows):
            if np.shape(row) != (width,) or np.asarray(row).dtype.kind not in "fiu":
                return f"{id_} has {of}, and got {_shown(row)}"
    if array.ndim == 2 and array.shape[::-1] == (len(ids), width):
        return (f"there are {of} for each id: an array of shape ({len(ids)}, {width}), and got one "
                f"of shape {array.shape}, its transpose")
    got = f"of shape {array.shape}" if array.dtype.kind in "fiu" else _shown(rows)
    return f"there are {of} for each of {len(ids)} ids: shape ({len(ids)}, {width}), and got {got}"


def _points(batch: Any, action: str, value: Any, what: str) -> None:
    width = batch.dimension
    ids, places = _columns(value, what, width, f"{width} coordinates")
    if ids.size == 0:
        return
    places = places.astype(np.float64)
    if action == "move":
        batch.moves(ids, places)
    else:
        batch.points(action, ids, places)


def _segments(batch: Any, action: str, value: Any, what: str) -> None:
    ids, ends = _columns(value, what, 2, "two ends, ids of points")
    if ids.size > 0:
        batch.segments(action, ids, _ids(ends.ravel(), what, "ends").reshape(ends.shape))


def _rings(value: Any, what: str, feature: int) -> list[list[int]]:
    """The rings of a polygon: `value` is one ring, or a list of them."""
    def refuse(text: str) -> None:
        raise TypeError(_expected(what, text=f"{feature} {text}"))

    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        refuse(f"has a ring, and got {_shown(value)}")
    rings = [list(ring) if isinstance(ring, Iterable) and not isinstance(ring, (str, bytes))
             else ring for ring in value]
    if rings and not any(isinstance(ring, list) for ring in rings):
        rings = [rings]  # one ring
    for ring in rings:
        for corner in ring if isinstance(ring, list) else [ring]:
            if not isinstance(corner, numbers.Integral) or isinstance(corner, bool):
                is_place = isinstance(corner, numbers.Real)
                refuse("has corners that are ids of points, whole numbers, and got "
                       f"{_shown(corner)}"
                       + (": add its points first, with ids, and name these" if is_place else ""))
        if not isinstance(ring, list):
            refuse(f"has rings and single corners side by side in {_shown(value)}")
    return [_ids(ring, what, "corners").tolist() for ring in rings]


def _polygons(batch: Any, action: str, value: Any, what: str) -> None:
    if not isinstance(value, Mapping):
        raise TypeError(_expected(what, value))
    for id_, rings in value.items():
        feature = int(_ids([id_], what)[0])
        batch.polygon(action, feature, _rings(rings, what, feature))


_OF_A_SIZE = ("at", "radius", "low", "high", "rings", "path", "target")


def _size(size: Mapping[str, Any], what: str, feature: int, dimension: int) -> dict[str, Any]:
    """A size with members of the right types."""
    def place(key: str, value: Any) -> list[float]:
        try:
            position = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            position = np.empty(0)
        if position.shape != (dimension,):
            raise ValueError(_expected(what, text=f"{feature}: {key} has {dimension} coordinates, "
                                                  f"and got {_shown(value)}"))
        return list(position.tolist())

    result: dict[str, Any] = {}
    for key, value in size.items():
        if key not in _OF_A_SIZE:
            raise ValueError(f"{what}: there is no {key} of a size; there are "
                             + ", ".join(_OF_A_SIZE))
        if key == "rings":
            result[key] = _rings(value, what, feature)
        elif key == "path":
            if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
                raise ValueError(_expected(what, text=f"{feature}: path is the places of two or "
                                                      f"more vertices, and got {_shown(value)}"))
            result[key] = [place("each place of path", vertex) for vertex in value]
        elif key in ("target", "radius"):
            if not isinstance(value, numbers.Real) or isinstance(value, bool):
                raise ValueError(_expected(what, text=f"{feature}: {key} is a number, and got "
                                                      f"{_shown(value)}"))
            result[key] = float(value)
        else:
            result[key] = place(key, value)
    return result


def _sizes(batch: Any, action: str, value: Any, what: str) -> None:
    if not isinstance(value, Mapping):
        raise TypeError(_expected(what, value))
    for id_, size in value.items():
        feature = int(_ids([id_], what)[0])
        if not isinstance(size, Mapping):
            raise TypeError(_expected(what, text=f"{feature} is a dict with a target and a place, "
                                                 f"and got {_shown(size)}"))
        members = _size(size, what, feature, batch.dimension)
        for key, needs in (("", ("target",)), ("path", ("radius",)), ("low", ("high",)),
                           ("high", ("low",))):
            if (not key or key in members) and not set(needs) <= set(members):
                with_it = f" with `{key}`" if key else ""
                raise ValueError(_expected(what, text=f"{feature}{with_it} has no {needs[0]}"))
        if not {"at", "low", "rings", "path"} & set(members):
            raise ValueError(_expected(what, text=f"{feature} has no place: `at`, `low` and "
                                                  "`high`, `rings` or `path`"))
        batch.size(action, feature, members)


def _remove(batch: Any, action: str, value: Any, what: str) -> None:
    batch.remove(_ids(value, what).ravel())


def _label(value: Any, what: str, feature: int) -> Label:
    if value is None:
        return Label()
    if isinstance(value, Label):
        value = dict(marker=value.marker, name=value.name)
    if not isinstance(value, Mapping):
        raise TypeError(_expected(what, text=f"{feature} has a marker and a name, and got "
                                             f"{_shown(value)}"))
    unknown = [key for key in value if key not in ("marker", "name")]
    if unknown:
        raise TypeError(_expected(what, text=f"there is no {unknown[0]} of a label; there are "
                                             "marker and name"))
    label = Label(**value)
    if (not isinstance(label.marker, numbers.Integral)
            or not -2**63 <= int(label.marker) < 2**63):
        raise TypeError(_expected(what, text=f"{feature} has a whole number as marker, from -2^63 "
                                             f"to 2^63 - 1, and got {_shown(label.marker)}"))
    if not isinstance(label.name, str):
        raise TypeError(_expected(what, text=f"{feature} has a text as name, and got "
                                             f"{_shown(label.name)}"))
    return label


def _labels(batch: Any, action: str, value: Any, what: str) -> None:
    if not isinstance(value, Mapping):
        raise TypeError(_expected(what, value))
    for id_, given in value.items():
        feature = int(_ids([id_], what)[0])
        label = _label(given, what, feature)
        batch.label(feature, int(label.marker), label.name)


def _unsplit(batch: Any, value: Any, what: str) -> None:
    """`value`: True for all segments and polygons that the batch adds or sets, or their ids."""
    if value is None or isinstance(value, (bool, np.bool_)):
        if value:
            batch.unsplit(None)
        return
    missing = batch.unsplit(_ids(value, what).ravel().tolist())
    if missing:
        raise ValueError(_expected(what, text=f"{missing[0]} is no segment or polygon that these "
                                              "edits add or set"))


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
        if name == "unsplit":
            continue
        if name not in _ACTIONS:
            raise TypeError(f"there is no edit {name}; there are "
                            f"{', '.join(sorted([*_ACTIONS, 'unsplit']))}")
        function, action = _ACTIONS[name]
        function(batch, action, value, name)
    _unsplit(batch, edits.get("unsplit"), "unsplit")
    return batch
