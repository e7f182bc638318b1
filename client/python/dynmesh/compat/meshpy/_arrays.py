"""Arrays that a mesh's description consists of, with the methods that meshpy's have."""
from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator
from typing import Any, Optional

import numpy as np

from dynmesh._types import Array


class ForeignArray:
    """Rows of numbers, of which an array is made by `numpy.array`.

    A row is a list, or a number if `unit` is 1. One that belongs to another array (markers of points) has
    as many rows as that, once it is allocated.
    """

    def __init__(self, dtype: Any, unit: int, master: Optional[ForeignArray] = None) -> None:
        self._dtype, self._unit, self._master = dtype, unit, master
        self._data: Optional[Array] = None

    def _rows(self) -> Array:
        count = len(self._master) if self._master is not None and self._data is not None else (
            0 if self._data is None else len(self._data))
        if self._data is None or len(self._data) != count:
            fresh = np.zeros((count, self._unit), self._dtype)
            if self._data is not None:
                kept = min(count, len(self._data))
                fresh[:kept] = self._data[:kept]
                self._data = fresh
            return fresh
        return self._data

    def __len__(self) -> int:
        return len(self._rows())

    def __array__(self, dtype: Any = None, copy: Any = None) -> Array:
        rows = self._rows()
        return np.array(rows[:, 0] if self._unit == 1 else rows, dtype=dtype or self._dtype)

    def __iter__(self) -> Iterator[Any]:
        rows: Any = self.__array__().tolist()
        return iter(rows)

    def __getitem__(self, index: Any) -> Any:
        rows = self._rows()
        if isinstance(index, tuple):
            return rows[index].item()
        if isinstance(index, slice):
            return self.__array__()[index].tolist()
        return rows[index, 0].item() if self._unit == 1 else rows[index].tolist()

    def __setitem__(self, index: Any, value: Any) -> None:
        rows = self._rows()
        if not isinstance(index, tuple) and self._unit > 1 and len(value) != self._unit:
            raise ValueError(f"a row has {self._unit} numbers, and got {len(value)}")
        rows[index] = value

    @property
    def unit(self) -> int:
        """Numbers of a row."""
        return self._unit

    @property
    def allocated(self) -> bool:
        """There are rows to be set."""
        return self._data is not None

    def resize(self, size: int) -> None:
        """Makes it `size` rows long; new ones are 0."""
        if self._master is not None:
            raise RuntimeError("the length is that of the array that this one belongs to: use setup()")
        rows = np.zeros((size, self._unit), self._dtype)
        if self._data is not None:
            kept = min(size, len(self._data))
            rows[:kept] = self._data[:kept]
        self._data = rows

    def setup(self) -> None:
        """Allocates rows of 0, as many as the array has that this one belongs to."""
        count = len(self._master) if self._master is not None else len(self)
        self._data = np.zeros((count, self._unit), self._dtype)

    def deallocate(self) -> None:
        """Has no rows from now on."""
        self._data = None

    def _set(self, rows: Any, unit: Optional[int] = None) -> None:
        array = np.asarray(rows, self._dtype)
        self._unit = unit or self._unit
        self._data = np.array(array.reshape(-1, self._unit))


class Arrays:
    """What descriptions of two and of three dimensions have in common."""

    def copy(self) -> Any:
        """A description of its own with the same content."""
        return copy.deepcopy(self)

    points: ForeignArray
    point_markers: ForeignArray
    point_attributes: ForeignArray
    element_attributes: ForeignArray
    holes: ForeignArray

    @property
    def number_of_point_attributes(self) -> int:
        """Numbers that a row of `point_attributes` has."""
        return self.point_attributes.unit

    @number_of_point_attributes.setter
    def number_of_point_attributes(self, count: int) -> None:
        self.point_attributes.deallocate()
        self.point_attributes._unit = count

    @property
    def number_of_element_attributes(self) -> int:
        """Numbers that a row of `element_attributes` has."""
        return self.element_attributes.unit

    @number_of_element_attributes.setter
    def number_of_element_attributes(self, count: int) -> None:
        self.element_attributes.deallocate()
        self.element_attributes._unit = count

    def set_points(self, points: Iterable[Any], point_markers: Optional[Iterable[int]] = None) -> None:
        """Sets the vertices of the input.

        Args:
            points: their coordinates.
            point_markers: a number for each of them.
        """
        rows = list(points)
        wrong = [row for row in rows if len(row) != self.points.unit]
        if wrong:
            raise ValueError(f"points: a point has {self.points.unit} coordinates, and got {wrong[0]!r}")
        self.points._set(rows)
        self._mark(self.point_markers, point_markers, len(rows), "point_markers")

    def set_holes(self, hole_starts: Iterable[Any]) -> None:
        """Sets places: what is around each, up to segments (3D: facets), is left out.

        Args:
            hole_starts: their coordinates.
        """
        self.holes._set(list(hole_starts))

    @staticmethod
    def _mark(array: ForeignArray, markers: Optional[Iterable[int]], count: int, name: str) -> None:
        if markers is None:
            array.deallocate()
            return
        rows = list(markers)
        if len(rows) != count:
            raise ValueError(f"{name}: {count} numbers, and got {len(rows)}")
        array._set(rows)
