"""P1 finite elements, shared by the examples: element matrices that follow a mesh."""
from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.linalg import cg

import dynmesh


class Elements:
    """Mass and stiffness matrices of each cell of a part, or of what has `points` and `cells`, too.

    `follow`, after each update of the part, assembles the cells that have changed only.
    """

    def __init__(self, part: Any) -> None:
        self._part = part
        self._width = part.points.shape[1] + 1
        shape = (len(part.cells), self._width, self._width)
        self.mass, self.stiffness = np.zeros(shape), np.zeros(shape)
        self._assemble(np.arange(len(part.cells)))

    def follow(self) -> None:
        missing = max(0, len(self._part.cells) - len(self.mass))
        room = np.zeros((missing, self._width, self._width))
        self.mass = np.concatenate([self.mass, room])[:len(self._part.cells)]
        self.stiffness = np.concatenate([self.stiffness, room])[:len(self._part.cells)]
        self._assemble(self._part.changed_cells)

    def _assemble(self, numbers: np.ndarray) -> None:
        corners = self._part.points[self._part.cells[numbers]]
        edges = corners[:, 1:] - corners[:, :1]
        measure = np.linalg.det(edges) / math.factorial(self._width - 1)
        gradients = np.linalg.inv(edges)  # columns: of the hat functions of corners 1, 2, ...
        gradients = np.concatenate([-gradients.sum(axis=2, keepdims=True), gradients], axis=2)
        shape = np.ones((self._width, self._width)) + np.eye(self._width)
        self.mass[numbers] = measure[:, None, None] * shape / (self._width * (self._width + 1))
        self.stiffness[numbers] = measure[:, None, None] * np.einsum("nki,nkj->nij", gradients,
                                                                     gradients)

    def matrix(self, values: np.ndarray) -> csr_matrix:
        """The sum of the cells' matrices, one row per vertex."""
        size, cells = len(self._part.points), self._part.cells
        rows = np.repeat(cells, self._width, axis=1).ravel()
        columns = np.tile(cells, (1, self._width)).ravel()
        return coo_matrix((values.ravel(), (rows, columns)), shape=(size, size)).tocsr()

    def integral(self, u: np.ndarray) -> float:
        return float(np.einsum("nij,nj->", self.mass, u[self._part.cells]))


def solve(system: csr_matrix, right: np.ndarray, u: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """The solution with the values of u where `fixed`; u is also the initial guess."""
    free = np.flatnonzero(~fixed)
    known = np.where(fixed, u, 0)
    rest = (right - system @ known)[free]
    found, trouble = cg(system[free][:, free], rest, x0=u[free], tol=1e-13, maxiter=5000)
    assert trouble == 0, "the solver did not converge"
    result = known
    result[free] = found
    return result


def measure_of(part: Any) -> float:
    """The area of a part, or of what has `points` and `cells`, too; in 3D the volume."""
    corners = part.points[part.cells]
    sum_ = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum()
    return float(sum_ / math.factorial(part.cells.shape[1] - 1))


def is_all_of(part: dynmesh.Part, measure: float) -> bool:
    """Is the part as large as the domain? The mesh reaches far beyond it."""
    return abs(measure_of(part) / measure - 1) < 1e-12


def vertices_of(part: dynmesh.Part, first: int, last: int) -> np.ndarray:
    """Mask of the vertices on facets of features with ids from `first` to `last`."""
    mask = np.zeros(len(part.points), bool)
    owners = part.facet_owners
    mask[part.facets[(owners >= first) & (owners <= last)]] = True
    return mask


def rebuilt(mesh: dynmesh.Mesh) -> dynmesh.Mesh:
    """A mesh made from scratch of the same features."""
    again = dynmesh.open(**mesh.options)
    features = mesh.features()
    keys = ("at", "radius", "low", "high", "rings", "target")
    again.apply(
        add_points={f["id"]: f["at"] for f in features if f["kind"] == "point"},
        add_segments={f["id"]: f["ends"] for f in features if f["kind"] == "segment"},
        add_polygons={f["id"]: f["rings"] for f in features if f["kind"] == "polygon"},
        add_sizes={f["id"]: {k: f[k] for k in keys if k in f} for f in features
                   if f["kind"] == "size"})
    return again
