"""Checks a mesh's options, as far as a wrong type or a likely mistake can be seen in them."""
from __future__ import annotations

import numbers
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from dynmesh import _core
from dynmesh._types import Array
from dynmesh.errors import InvalidArgument

_TEXTS = {"kind": "'delaunay', 'quadtree' or 'triangulation'", "criterion": "'edge' or 'thesis'"}
_WHOLE = {"dimension": "2 or 3", "max_vertices": "as 1_000_000"}
_BOX = "two corners, as ((0, 0), (2, 1)), in 3D ((0, 0, 0), (2, 1, 1))"


@contextmanager
def named_options() -> Iterator[None]:
    """Errors of the library name the options as this package does."""
    try:
        yield
    except InvalidArgument as error:
        if error.reason == "BAD_OPTION":
            text = str(error).replace("options.", "", 1)
            if "quality: " in text:
                text = text.replace("quality: ", "rho: ", 1) + (
                    "; rho is the largest circumradius / shortest edge, as 2**0.5, in 3D 2")
            error.args = (text,)
        raise


def _text_of(low: Array, high: Array) -> str:
    return f"box=({tuple(low.tolist())}, {tuple(high.tolist())})"


def check_box(box: Any) -> list[list[float]]:
    """The corners of `box` as lists. Raises if it is not one, or is empty."""
    try:
        corners = np.asarray(box, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"box: it is {_BOX}, and got {box!r}") from error
    if corners.shape not in ((2, 2), (2, 3)):
        hint = ""
        if corners.shape in ((4,), (6,)):
            half = len(corners) // 2
            hint = f": {_text_of(corners[:half], corners[half:])}?"
        elif corners.shape == (3, 2):  # a range for each axis
            hint = f": {_text_of(*corners.T)}?"
        raise ValueError(f"box: it is {_BOX}, and got {box!r}{hint}")
    low: Array = corners[0]
    high: Array = corners[1]
    if np.isfinite(corners).all() and not (high > low).all():
        axis = "xyz"[int(np.flatnonzero(~(high > low))[0])]
        text = (f"box: the second corner of {box!r} is not above the first in {axis}: it is empty; "
                f"a box is {_BOX}")
        if (low > high).all():
            text += f": {_text_of(high, low)}?"
        elif len(low) == 2 and (corners[:, 1] > corners[:, 0]).all():
            text += (f", not a range for each axis: if x is from {low[0]:g} to {low[1]:g} and y from "
                     f"{high[0]:g} to {high[1]:g}, it is {_text_of(*corners.T)}")
        raise ValueError(text)
    return [low.tolist(), high.tolist()]


def check_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options of a new mesh. Raises ValueError or TypeError, naming the option."""
    known = _core.known_options()
    result: dict[str, Any] = {}
    for name, value in options.items():
        if name not in known:
            raise ValueError(f"{name}: there is no such option of a mesh; there are "
                             f"{', '.join(known)}")
        if name == "box":
            value = check_box(value)
        elif name in _TEXTS:
            if not isinstance(value, str):
                raise TypeError(f"{name}: it is {_TEXTS[name]}, and got {value!r}")
        elif name in _WHOLE:
            if not isinstance(value, numbers.Integral) or isinstance(value, bool) or value < 0:
                raise TypeError(f"{name}: it is a whole number, {_WHOLE[name]}, and got {value!r}")
            value = int(value)
        else:
            if not isinstance(value, numbers.Real) or isinstance(value, bool):
                raise TypeError(f"{name}: it is a number, and got {value!r}")
            value = float(value)
        result[name] = value
    return result
