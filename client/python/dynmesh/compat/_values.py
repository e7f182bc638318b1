"""Values of the input's vertices at new vertices."""
from __future__ import annotations

import numpy as np

from dynmesh._types import Array
from dynmesh.compat import _topology
from dynmesh.compat._domain import Cut


def interpolate(base: Cut, values: Array, places: Array) -> Array:
    """Values at places, linear in each triangle of the input's triangulation.

    Args:
        base: the triangulation.
        values: one row for each of its vertices.
        places: (n, 2), inside or on the border.
    """
    cells = base.locate(places)
    weights = np.clip(_topology.weights_in(base.points, base.cells[cells], places), 0, 1)
    weights /= weights.sum(axis=1, keepdims=True)
    result: Array = np.einsum("ij,ijk->ik", weights, values[base.cells[cells]])
    return result
