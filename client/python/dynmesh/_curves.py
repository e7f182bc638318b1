"""Points along curves, for borders that stay whole."""
from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from dynmesh._types import Array
from dynmesh.errors import InvalidArgument, NotFound

if TYPE_CHECKING:
    from dynmesh._band import Frame
    from dynmesh._part import Part

_HAIR = 1e-9  # two curves that differ by rounding get equally many points
_FINE = 64  # samples between two points, to measure a curve


def points_along(curve: Union[Array, list[Any], Callable[[float], Any]], spacing: float,
                 closed: bool = False) -> Array:
    """Points along a curve, at most `spacing` apart; an array with a row for each.

    Curves that are alike, as the two borders of a periodic box, get points that are alike: what
    moves one curve to the other moves these, but for rounding.

    Args:
        curve: the corners of a polyline, which are points of the result, with equal parts of each
            edge between them; or a function of 0 to 1 to places, of which the points are equally
            far apart along the curve.
        spacing: the greatest distance of two neighbours, along the curve.
        closed: the curve ends where it begins. Then the first point is not repeated; the corners
            of a polyline need not be, either.
    """
    if not spacing > 0:
        raise ValueError(f"spacing: a length above 0 is expected, and got {spacing!r}")
    if callable(curve):
        return _along(curve, spacing, closed)
    corners = np.asarray(curve, dtype=np.float64)
    if corners.ndim != 2 or len(corners) < 2 or corners.shape[1] not in (2, 3):
        raise ValueError("curve: two or more places of two or three coordinates are expected, and "
                         f"got an array of shape {corners.shape}")
    if closed and not np.array_equal(corners[0], corners[-1]):
        corners = np.vstack([corners, corners[:1]])
    parts = []
    for a, b in zip(corners[:-1], corners[1:]):
        n = _parts(float(np.linalg.norm(b - a)), spacing)
        parts.append(a + np.arange(n)[:, None] / n * (b - a))
    if not closed:
        parts.append(corners[-1:])
    return np.concatenate(parts)


def periodic_pairs(part: Part, first: Union[int, str], second: Union[int, str],
                   frame: Optional[Frame] = None) -> Array:
    """The vertices of two borders of a part that are one, as those of a periodic box: int32, (n, 2).

    Both borders are to have the same points, by `points_along`, and to be unsplit; then each vertex of
    the one has its partner on the other. `u[pairs[:, 1]] = u[pairs[:, 0]]`. O(n^2) for n vertices on a border.

    Args:
        part: of a mesh of any dimension.
        first: the id or the name of the features of one border.
        second: those of the other.
        frame: what leads from the first to the second: a turn, for a sector of a machine. Without it a shift,
            from the middle of the one to that of the other.

    Raises:
        NotFound: no facet of the part is of these features.
        InvalidArgument: the borders are not alike; the text has a vertex without a partner.
    """
    ends = []
    for which in (first, second):
        of = part.facet_names == which if isinstance(which, str) else part.facet_owners == np.uint64(which)
        if not of.any():
            there = ", ".join(sorted({repr(name) for name in part.facet_names.tolist() if name})) or "none"
            raise NotFound(f"the part has no facet of {which!r}; names are: {there}")
        ends.append(np.unique(part.facets[of]))
    one, other = (part.points[numbers] for numbers in ends)
    if frame is not None:
        moved = frame.place(one)
    else:
        moved = one + ((other.min(axis=0) + other.max(axis=0)) - (one.min(axis=0) + one.max(axis=0))) / 2
    apart = np.array([np.linalg.norm(other - at, axis=1) for at in moved])
    partner, reach = apart.argmin(axis=1), np.abs(part.points).max()
    far = apart.min(axis=1) > _HAIR * reach
    if far.any() or len(one) != len(other) or len(np.unique(partner)) < len(one):
        if far.any():
            at = int(np.flatnonzero(far)[0])
            why = (f"the vertex of {first!r} at {one[at].tolist()} has its partner's place at {moved[at].tolist()}, and the "
                   f"nearest vertex of {second!r} is {apart[at].min():.3g} away")
        else:
            why = f"{first!r} has {len(one)} vertices, {second!r} {len(other)}"
        raise InvalidArgument(f"the borders {first!r} and {second!r} are not alike: {why}; give both the same points "
                              "(dynmesh.points_along) and mark them unsplit")
    return np.column_stack([ends[0], ends[1][partner]]).astype(np.int32)


def _parts(length: float, spacing: float) -> int:
    return max(1, int(np.ceil(length / spacing * (1 - _HAIR))))


def _places(curve: Callable[[float], Any], at: Array) -> Array:
    places: Array = np.array([np.asarray(curve(float(t)), dtype=np.float64) for t in at])
    if places.ndim != 2 or places.shape[1] not in (2, 3):
        raise ValueError("curve: a function to places of two or three coordinates is expected")
    return places


def _along(curve: Callable[[float], Any], spacing: float, closed: bool) -> Array:
    count, needed = 0, 1
    while needed > count:
        count = needed
        samples = np.linspace(0, 1, count * _FINE + 1)
        steps = np.linalg.norm(np.diff(_places(curve, samples), axis=0), axis=1)
        ends = np.concatenate([[0], np.cumsum(steps)])
        needed = _parts(float(ends[-1]), spacing)
    points = _places(curve, np.interp(np.arange(needed + 1) / needed * ends[-1], ends, samples))
    return points[:-1] if closed else points
