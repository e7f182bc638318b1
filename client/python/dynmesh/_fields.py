"""Fields on a mesh that its edits carry along."""
from __future__ import annotations

import sys
import threading
import weakref
from collections.abc import Iterator, Mapping
from typing import Any, Optional

import numpy as np

from dynmesh._diff import Diff
from dynmesh._rows import (check_finite, check_kind, check_rows, check_values, is_any_dtype,
                           is_at_vertices)
from dynmesh._state import MeshState
from dynmesh._types import Array
from dynmesh.errors import InvalidArgument


class _Field:
    """An array with room for more rows, and the view of its rows that users get."""

    def __init__(self, rows: Array, options: dict[str, Any]) -> None:
        self.options = options
        self._room = rows
        self._past: Optional[weakref.ref[Array]] = None
        self.view = rows[:]

    def is_held(self) -> bool:
        """Does anything but this object refer to the array?"""
        return (sys.getrefcount(self.view) > _OWN_VIEW or sys.getrefcount(self._room) > _OWN_ROOM)

    def advance(self, diff: Diff, rows: int) -> None:
        """Carries the field across `diff` to `rows` rows; an array in use stays as it was."""
        held, fits = self.is_held(), len(self._room) >= rows
        room = self._room
        if held or not fits:
            size = len(room) if fits else max(rows, 2 * len(room))
            room = np.zeros((size, *room.shape[1:]), room.dtype)
            room[:len(self.view)] = self.view
        diff._carry(room, **self.options)
        if room is not self._room:
            self.view.flags.writeable = False  # it is of the past now: writing to it would be lost
            self._past = weakref.ref(self.view)
        self._room, self.view = room, room[:rows]

    def is_past(self, array: Array) -> bool:
        """Is it the view that the last edit has replaced?"""
        return self._past is not None and self._past() is array


def _count_own() -> tuple[int, int]:
    """What sys.getrefcount counts for a view and an array that nothing else refers to."""
    probe = _Field(np.zeros(1), {})
    return sys.getrefcount(probe.view), sys.getrefcount(probe._room)


_OWN_VIEW, _OWN_ROOM = _count_own()


class Fields(Mapping[str, Array]):
    """Fields that every edit of their mesh transfers to the new mesh.

    After `mesh.fields.add("T", values)`, `mesh.fields["T"]` is the field on the present mesh, an
    array with one row per slot. Get it again after an edit: an array that is still in use stays as
    it was before the edit, and becomes read-only. Carrying a field whose array is in use copies it.

    Thread-safe, as `Mesh`: an array does not change by edits while it is in use. To change values
    beside edits of other threads, hold `Mesh.locked`.
    """

    def __init__(self, mesh: MeshState, lock: threading.RLock) -> None:
        self._mesh = mesh
        self._lock = lock
        self._fields: dict[str, _Field] = {}

    def add(self, name: str, values: Array, kind: Any = "P1", **options: Any) -> Array:
        """Adds a copy of `values` under `name`, transferred from now on; returns it.

        Args:
            name: that of the field; a field of this name is replaced.
            values: a row for each slot, exactly: `Mesh.vertex_slots` rows of "P1" and "dual", else
                `Mesh.cell_slots`. Numbers are finite, except in free rows.
            kind: as in `Diff.transfer`.
            options: as in `Diff.transfer`: `bounded`, `order`, `rings`.

        Raises:
            ValueError, TypeError: wrong kind, shape or dtype, or a value that is not finite.
        """
        what = f"fields[{name!r}]"
        check_kind(kind)
        unknown = set(options) - {"bounded", "order", "rings"}
        if unknown:
            raise TypeError(f"{what}: there is no option {sorted(unknown)[0]}; there are bounded, "
                            "order, rings")
        array = np.asarray(values)
        mesh = self._mesh
        with mesh.locked():
            check_rows(what, array, kind, (mesh.vertex_slots, mesh.cell_slots), mesh.revision)
            check_values(what, array, kind, mesh.dimension)
            rows = np.array(array, dtype=None if is_any_dtype(kind) else np.float64, order="C")
            check_finite(what, rows, kind,
                         mesh.live_vertices if is_at_vertices(kind) else mesh.live_cells)
            with self._lock:
                field = self._fields[name] = _Field(rows, {"kind": kind, **options})
                return field.view

    def drop(self, name: str) -> None:
        """Removes the field `name`."""
        with self._lock:
            del self._fields[name]

    def __getitem__(self, name: str) -> Array:
        with self._lock:
            return self._fields[name].view

    def __setitem__(self, name: str, values: Any) -> None:
        array = np.asarray(values)
        with self._mesh.locked():
            view = self[name]
            if self._fields[name].is_past(array):
                raise ValueError(f"fields[{name!r}]: the array is that of an earlier revision: it "
                                 "was taken before an edit; beside edits of other threads change "
                                 "fields under `with mesh.locked():`")
            if array.shape not in ((), view.shape):
                raise ValueError(f"fields[{name!r}]: the field has the shape {view.shape}, the "
                                 f"values {array.shape}; a single number sets all rows")
            view[...] = array

    def __iter__(self) -> Iterator[str]:
        with self._lock:
            return iter(list(self._fields))

    def __len__(self) -> int:
        return len(self._fields)

    def _advance(self, diff: Diff) -> None:
        """Transfers all fields. Drops those that cannot be transferred, then raises their names."""
        trouble: dict[str, Exception] = {}
        with self._lock:
            for name, field in list(self._fields.items()):
                try:
                    at_vertices = is_at_vertices(field.options["kind"])
                    field.advance(diff, diff._new_slots[0 if at_vertices else 1])
                except (ValueError, TypeError) as error:
                    trouble[name] = error
            for name in trouble:
                self._fields.pop(name, None)
        if trouble:
            text = "; ".join(f"{name}: {error}" for name, error in trouble.items())
            raise InvalidArgument(f"the mesh is at revision {diff.to_revision}; fields that could "
                                  f"not be carried there were dropped: {text}")
