"""Values of the input's vertices at new vertices."""
from __future__ import annotations

import numpy as np

from dynmesh._types import Array
from dynmesh.compat import _topology
from dynmesh.compat._domain import Cut


def interpolate(base: Cut, pieces: Array, values: Array, places: Array) -> Array:
    """Values at places, linear in each cell of a coarse mesh of the same input.

    At the base's own new vertices they are linear along segments, and solve Laplace's equation on it
    elsewhere. So linear functions stay linear, and values stay within the range of the given ones.

    Args:
        base: a mesh of two dimensions with the values' vertices first.
        pieces: the ends of its segments, input vertices.
        values: one row for each of the base's input vertices.
        places: (n, dimension), inside or on the border.
    """
    at_vertices = _harmonic(base, pieces, values)
    cells = base.locate(places)
    weights = np.clip(_topology.weights_in(base.points, base.cells[cells], places), 0, 1)
    weights /= weights.sum(axis=1, keepdims=True)
    result: Array = np.einsum("ij,ijk->ik", weights, at_vertices[base.cells[cells]])
    return result


def _harmonic(base: Cut, pieces: Array, values: Array) -> Array:
    """By conjugate gradients with the stiffness matrix of P1 elements."""
    count, given = len(base.points), len(values)
    result = np.zeros((count, values.shape[1]))
    result[:given] = values
    if count == given:
        return result
    rows = np.repeat(pieces[base.facet_pieces], 2, axis=0)
    on = base.facets.reshape(-1)
    begin, end = base.points[rows[:, 0]], base.points[rows[:, 1]]
    along = end - begin
    part = (((base.points[on] - begin) * along).sum(axis=1) / (along * along).sum(axis=1))[:, None]
    new = on >= given
    result[on[new]] = ((1 - part) * values[rows[:, 0]] + part * values[rows[:, 1]])[new]
    width = base.cells.shape[1]
    corners = base.points[base.cells]
    ones = np.ones((len(corners), width, 1))
    gradients = np.linalg.inv(np.concatenate([ones, corners], axis=2))[:, 1:, :]
    local = np.einsum("cki,ckj,c->cij", gradients, gradients, base.measures)
    flat = base.cells.reshape(-1)

    def product(u: Array) -> Array:
        return np.bincount(flat, np.einsum("cij,cj->ci", local, u[base.cells]).reshape(-1), count)

    diagonal = np.bincount(flat, np.einsum("cii->ci", local).reshape(-1), count)
    free = diagonal > 0
    free[:given] = False
    free[on] = False
    for column in result.T:
        u = column.copy()
        residual = np.where(free, -product(u), 0.0)
        least = 1e-26 * max(float(residual @ residual), 1e-300)
        step = np.where(free, residual / np.where(free, diagonal, 1), 0.0)
        slope = float(residual @ step)
        for _ in range(10 * count):
            if float(residual @ residual) <= least:
                break
            image = np.where(free, product(step), 0.0)
            length = slope / float(step @ image)
            u += length * step
            residual -= length * image
            scaled = np.where(free, residual / np.where(free, diagonal, 1), 0.0)
            slope, before = float(residual @ scaled), slope
            step = scaled + slope / before * step
        column[:] = u
    return result
