"""What tests compute the slow and obvious way."""
import math

import numpy as np


def measures(mesh):
    """Of each live cell, by slot; 0 where a slot is free."""
    live = np.flatnonzero(mesh.live_cells)
    corners = mesh.points[mesh.cells[live]]
    edges = corners[:, 1:] - corners[:, :1]
    result = np.zeros(mesh.cell_slots)
    result[live] = np.linalg.det(edges) / math.factorial(mesh.dimension)
    return result


def mass(mesh, u, kind):
    """The integral of the field, and that of its size, summed exactly."""
    live = np.flatnonzero(mesh.live_cells)
    if kind == "P1":
        means = u[mesh.cells[live]].mean(axis=1)
    elif kind == "DG1":
        means = u[live].mean(axis=1)
    else:
        means = u[live]
    terms = measures(mesh)[live] * means
    return math.fsum(terms), math.fsum(np.abs(terms))


def centroids(mesh):
    """By slot of cells; of free ones nothing."""
    return mesh.points[mesh.cells].mean(axis=1)


def sample(mesh, function, kind):
    if kind == "P1":
        return function(mesh.points)
    if kind == "DG1":
        return np.stack([function(mesh.points[mesh.cells[:, k]])
                         for k in range(mesh.dimension + 1)], axis=1)
    return function(centroids(mesh))
