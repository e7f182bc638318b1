"""P1 finite elements, shared by the examples: element matrices that follow a mesh."""
from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.linalg import cg

import dynmesh


class Elements:
    """Mass and stiffness matrices of each cell, by slot; 0 for free slots.

    `follow` assembles those of the patch only.
    """

    def __init__(self, mesh: dynmesh.Mesh) -> None:
        self._width = mesh.dimension + 1
        self.cells = np.zeros((0, self._width), np.int32)
        self.mass = np.zeros((0, self._width, self._width))
        self.stiffness = np.zeros((0, self._width, self._width))
        self._assemble(mesh, np.flatnonzero(mesh.live_cells))

    def follow(self, mesh: dynmesh.Mesh, diff: dynmesh.Diff) -> None:
        gone = diff.patch.removed_cells
        self.mass[gone] = self.stiffness[gone] = 0
        self.cells[gone] = 0
        self._assemble(mesh, diff.patch.added_cells)

    def _assemble(self, mesh: dynmesh.Mesh, slots: np.ndarray) -> None:
        missing = mesh.cell_slots - len(self.cells)
        if missing > 0:
            matrices = np.zeros((missing, self._width, self._width))
            self.cells = np.concatenate([self.cells, np.zeros((missing, self._width), np.int32)])
            self.mass = np.concatenate([self.mass, matrices])
            self.stiffness = np.concatenate([self.stiffness, matrices])
        cells = mesh.cells[slots]
        corners = mesh.points[cells]
        edges = corners[:, 1:] - corners[:, :1]
        measure = np.linalg.det(edges) / math.factorial(self._width - 1)
        gradients = np.linalg.inv(edges)  # columns: of the hat functions of corners 1, 2, ...
        gradients = np.concatenate([-gradients.sum(axis=2, keepdims=True), gradients], axis=2)
        shape = np.ones((self._width, self._width)) + np.eye(self._width)
        self.cells[slots] = cells
        self.mass[slots] = measure[:, None, None] * shape / (self._width * (self._width + 1))
        self.stiffness[slots] = measure[:, None, None] * np.einsum("nki,nkj->nij", gradients,
                                                                   gradients)

    def matrix(self, values: np.ndarray, size: int) -> csr_matrix:
        """The sum of the cells' matrices, one row per vertex slot."""
        rows = np.repeat(self.cells, self._width, axis=1).ravel()
        columns = np.tile(self.cells, (1, self._width)).ravel()
        return coo_matrix((values.ravel(), (rows, columns)), shape=(size, size)).tocsr()

    def integral(self, u: np.ndarray) -> float:
        return float(np.einsum("nij,nj->", self.mass, u[self.cells]))


def solve(system: csr_matrix, right: np.ndarray, u: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """The solution with the values of u where `fixed`; u is also the initial guess."""
    free = np.flatnonzero(~fixed)
    known = np.where(fixed, u, 0)
    rest = (right - system @ known)[free]
    found, trouble = cg(system[free][:, free], rest, x0=u[free], tol=1e-10, maxiter=5000)
    assert trouble == 0, "the solver did not converge"
    result = known
    result[free] = found
    return result


def vertices_of(mesh: dynmesh.Mesh, first: int, last: int) -> np.ndarray:
    """Mask of the vertices on segments with ids from `first` to `last`."""
    mask = np.zeros(mesh.vertex_slots, bool)
    owners = mesh.subsegment_owners
    mask[mesh.subsegments[(owners >= first) & (owners <= last)]] = True
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
