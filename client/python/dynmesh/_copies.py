"""Values at the copies of a part's vertices, from those at the corners of its cells."""
from __future__ import annotations

import math

import numpy as np

from dynmesh._types import Array

_STEPS = 8  # of the projection: the rest falls by a quarter and more in each


def set_at_vertices(result: Array, changed: Array, points: Array, cells: Array, corners: Array,
                    is_new: Array, bounded: bool) -> None:
    """Sets the `changed` vertices such that the integral is that of the values at `corners`.

    `cells` are all around them. At vertices of new ones, and where corners disagree, the value is
    the mean, weighted by the cells, and then corrected towards the L2 projection, unless it is
    `bounded`. Elsewhere it is the value at the corners, to the bit. Linear functions are kept.
    """
    if not len(cells):
        return
    width = cells.shape[1]
    rows = changed[cells]
    result[cells[rows]] = corners[rows]
    differs = (result[cells] != corners).reshape(len(cells), width, -1).any(axis=2)
    is_open = np.zeros(len(result), bool)
    is_open[cells[is_new]] = True
    is_open[cells[differs]] = True
    star = np.flatnonzero(is_open[cells].any(axis=1))
    if not star.size:
        return

    # All cells at these vertices, and a row of numbers for each component.
    numbers, here = np.unique(cells[star], return_inverse=True)
    here = here.reshape(len(star), width)
    given = corners[star].reshape(len(star), width, -1)
    edges = points[cells[star]]
    measure = np.abs(np.linalg.det(edges[:, 1:] - edges[:, :1])) / math.factorial(width - 1)
    share = np.repeat(measure / width, width)
    mass = np.bincount(here.ravel(), share, len(numbers))
    may_change = is_open[numbers]

    def gathered(values: Array) -> Array:
        """Sums over the corners, one column a component."""
        return np.column_stack([np.bincount(here.ravel(), column, len(numbers))
                                for column in values.reshape(-1, values.shape[2]).T])

    # Differences to a value at hand, so that constants stay to the bit.
    base = result[numbers].reshape(len(numbers), -1)
    mean = gathered((given - base[here]) * share.reshape(len(star), width, 1)) / mass[:, None]
    u = np.where(may_change[:, None], base + mean, base)
    if not bounded:
        # Test functions add up to one over the vertices that may change: the integral stays.
        tested = may_change[here]
        lost = 1 / tested.sum(axis=1)
        for _ in range(_STEPS):
            rest = given - u[here]
            moment = (rest + rest.sum(axis=1, keepdims=True)) * (
                measure / (width * (width + 1)))[:, None, None]
            out = np.where(tested[:, :, None], 0, moment).sum(axis=1, keepdims=True)
            moment = np.where(tested[:, :, None], moment + out * lost[:, None, None], 0)
            u = u + gathered(moment) / mass[:, None]
    result[numbers[may_change]] = u[may_change].reshape(-1, *result.shape[1:])
