"""What the rows of a field have to be, by its kind."""
from __future__ import annotations

from typing import Any

import numpy as np

from dynmesh._types import Array

_NUMBERS = ("P0", "P1", "DG1", "dual")


def check_kind(kind: Any) -> None:
    """Raises ValueError unless `kind` is a kind of fields."""
    if callable(kind) or (isinstance(kind, str) and kind in (*_NUMBERS, "overlap")):
        return
    near = {known.lower(): known for known in (*_NUMBERS, "overlap")}
    hint = near.get(kind.lower()) if isinstance(kind, str) else None
    raise ValueError(f"kind: there is no kind {kind!r}"
                     + (f": {hint!r} is meant?" if hint else "")
                     + "; there are 'P1' (values at vertices), 'dual' (means over median-dual "
                     "cells), 'P0' (means of cells), 'DG1' (values at the corners of cells), "
                     "'overlap' (rows of cells), or a function")


def is_at_vertices(kind: Any) -> bool:
    """Has a field of this kind a row for each vertex, not for each cell?"""
    return isinstance(kind, str) and kind in ("P1", "dual")


def is_any_dtype(kind: Any) -> bool:
    """Do rows of this kind stay as they are, of any dtype?"""
    return callable(kind) or kind == "overlap"


def name_of(kind: Any) -> str:
    """The kind, as messages name it."""
    return f"kind {kind!r}" if isinstance(kind, str) else "a function as kind"


def check_rows(what: str, u: Array, kind: Any, slots: tuple[int, int], revision: int,
               later: tuple[int, int] = (-1, -1), at_least: bool = False) -> None:
    """Raises unless `u` has a row for each of the `slots` of vertices and cells, by kind, exactly.

    The number of `later` slots is accepted, too. With `at_least`, more rows than slots are, unless
    their number is that of the other kind's slots: then the kind is likely to be wrong.
    """
    at_vertices = is_at_vertices(kind)
    right, wrong = slots if at_vertices else slots[::-1]
    mine, others = ("vertex", "cell") if at_vertices else ("cell", "vertex")
    if u.ndim == 0:
        raise ValueError(f"{what}: {name_of(kind)} needs a row for each slot, an array of {right} "
                         f"rows, not a single number; such as np.zeros(mesh.{mine}_slots)")
    if len(u) in (right, later[0 if at_vertices else 1]) or (
            at_least and len(u) > right and len(u) != wrong):
        return
    text = (f"{what}: {name_of(kind)} needs a row for each {mine} slot, "
            f"{'at least ' if at_least else ''}{right} rows at revision {revision}, and got "
            f"{len(u)}")
    if len(u) in (wrong, later[1 if at_vertices else 0]):
        fit = "'P0', 'DG1' or 'overlap'" if at_vertices else "'P1' or 'dual'"
        raise ValueError(f"{text}, the number of {others} slots: values of "
                         f"{'cells' if at_vertices else 'vertices'} have kind={fit}")
    raise ValueError(f"{text}; mesh.{mine}_slots is that number, and rows of mesh.compact() are "
                     f"brought to it by u[compact.{mine}_slots] = values")


def check_values(what: str, u: Array, kind: Any, dimension: int) -> None:
    """Raises unless rows of `u` have the shape and dtype of the kind. O(1)."""
    if is_any_dtype(kind):
        return
    if u.dtype.kind not in "fiu":
        raise TypeError(f"{what}: {name_of(kind)} needs real numbers, float64 or what converts to "
                        f"it, and got {u.dtype}: a field of {u.dtype} cannot be carried"
                        + ("; carry .real and .imag" if u.dtype.kind == "c" else
                           "; kind='overlap' carries rows of any dtype"))
    axes = u.shape[1:]
    if kind in ("DG1", "dual-corners"):
        width = dimension + 1
        if not axes or axes[0] != width:
            raise ValueError(f"{what}: kind 'DG1' has {width} values for each cell, in the order "
                             f"of mesh.cells: its shape begins with (slots, {width}), and got "
                             f"{u.shape}")
        axes = axes[1:]
    if len(axes) > 1:
        raise ValueError(f"{what}: a field has at most one axis of components, as (slots, 3)"
                         f"{' or, of DG1, (slots, corners, 3)' if kind == 'DG1' else ''}, and got "
                         f"{u.shape}")


def check_finite(what: str, u: Array, kind: Any, live: Array) -> None:
    """Raises if a number of a live row is not finite. O(rows)."""
    if is_any_dtype(kind) or u.dtype.kind != "f":
        return
    rows = np.isfinite(u).reshape(len(u), -1).all(axis=1)
    bad = np.flatnonzero(live & ~rows)
    if bad.size:
        raise ValueError(f"{what}: values of a field are finite, and row {bad[0]} is {u[bad[0]]}"
                         + (f"; so are {bad.size - 1} more" if bad.size > 1 else ""))
