"""Plane strain with P1 finite elements, shared by the examples. Young's modulus is 1."""
from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

import dynmesh

POISSON = 0.3
LAW = np.array([[1 - POISSON, POISSON, 0], [POISSON, 1 - POISSON, 0], [0, 0, 0.5 - POISSON]]) / (
    (1 + POISSON) * (1 - 2 * POISSON))


def strain_matrices(part: dynmesh.Part) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each cell its area, the gradients of its hat functions, and the strains of its corners."""
    corners = part.points[part.cells]
    edges = corners[:, 1:] - corners[:, :1]
    gradients = np.linalg.inv(edges)
    gradients = np.concatenate([-gradients.sum(axis=2, keepdims=True), gradients], axis=2)
    strains = np.zeros((len(edges), 3, 6))
    strains[:, 0, 0::2] = strains[:, 2, 1::2] = gradients[:, 0]
    strains[:, 1, 1::2] = strains[:, 2, 0::2] = gradients[:, 1]
    return np.linalg.det(edges) / 2, gradients, strains


def displacement(part: dynmesh.Part, tension: dict[str, float],
                 corners: list[tuple[float, float]]) -> tuple[np.ndarray, float]:
    """The displacement under a vertical `tension` on sides by name, and its energy.

    The first of the two `corners` stays, the other one in its height: no motion of the whole.
    """
    area, _, strains = strain_matrices(part)
    stiffness = np.einsum("n,nki,kl,nlj->nij", area, strains, LAW, strains, optimize=True)
    unknowns = (2 * part.cells[:, :, None] + [0, 1]).reshape(-1, 6)
    matrix = coo_matrix((stiffness.ravel(), (np.repeat(unknowns, 6, axis=1).ravel(),
                                             np.tile(unknowns, (1, 6)).ravel()))).tocsr()
    load = np.zeros((len(part.points), 2))
    for name, force in tension.items():
        edges = part.facets[part.facet_names == name]
        lengths = np.linalg.norm(part.points[edges[:, 1]] - part.points[edges[:, 0]], axis=1)
        np.add.at(load[:, 1], edges, force * lengths[:, None] / 2)
    first, second = (int(np.flatnonzero((part.points == corner).all(axis=1))[0])
                     for corner in corners)
    free = np.setdiff1d(np.arange(matrix.shape[0]), [2 * first, 2 * first + 1, 2 * second + 1])
    u = np.zeros(matrix.shape[0])
    u[free] = spsolve(matrix[free][:, free], load.ravel()[free])
    return u.reshape(-1, 2), float(u @ load.ravel() / 2)


def intensities(part: dynmesh.Part, u: np.ndarray, tip: np.ndarray, ahead: np.ndarray,
                radius: float) -> tuple[float, float, float]:
    """K_I, K_II and the energy release rate at `tip`, where the crack points `ahead`.

    The J-integral and interaction integrals, over the cells of a ring around the tip.
    """
    turn = np.array([ahead, [-ahead[1], ahead[0]]])  # to the axes of the tip
    places, u = (part.points - tip) @ turn.T, u @ turn.T
    weight = np.clip(2 - 2 * np.linalg.norm(places, axis=1) / radius, 0, 1)
    ring = np.ptp(weight[part.cells], axis=1) > 0
    area, gradients, _ = strain_matrices(part)
    cells, area = part.cells[ring], area[ring]
    gradients = turn @ gradients[ring]
    falls = np.einsum("nik,nk->ni", gradients, weight[cells])
    slope = np.einsum("nik,nkj->nji", gradients, u[cells])  # of u_j along axis i
    middles = places[cells].mean(axis=1)

    def stress(slope: np.ndarray) -> np.ndarray:
        rows = np.stack([slope[:, 0, 0], slope[:, 1, 1], slope[:, 0, 1] + slope[:, 1, 0]], axis=1)
        return (rows @ LAW)[:, [0, 2, 2, 1]].reshape(-1, 2, 2)

    def released(slope: np.ndarray, other: np.ndarray) -> float:
        """Of one field the double of J; of two the interaction."""
        work = np.einsum("nij,ni,nj->n", stress(slope), other[:, :, 0], falls)
        work += np.einsum("nij,ni,nj->n", stress(other), slope[:, :, 0], falls)
        return float(area @ (work - np.einsum("nij,nij->n", stress(slope), other) * falls[:, 0]))

    step = 1e-6 * radius

    def near_tip(mode: int, x: np.ndarray) -> np.ndarray:
        """The displacement around the tip of a crack whose K is 1."""
        angle = np.arctan2(x[:, 1], x[:, 0])
        size = np.sqrt(np.hypot(*x.T) / (2 * math.pi)) * (1 + POISSON)
        kappa = 3 - 4 * POISSON
        if mode == 1:
            across = np.stack([np.cos(angle / 2), np.sin(angle / 2)], axis=1)
            return (size * (kappa - np.cos(angle)))[:, None] * across
        return size[:, None] * np.stack([np.sin(angle / 2) * (kappa + 2 + np.cos(angle)),
                                         -np.cos(angle / 2) * (kappa - 2 + np.cos(angle))], axis=1)

    modulus = 1 / (1 - POISSON**2)
    found = []
    for mode in (1, 2):
        exact = np.stack([near_tip(mode, middles + offset) - near_tip(mode, middles - offset)
                          for offset in step * np.eye(2)], axis=2) / (2 * step)
        found.append(modulus / 2 * released(slope, exact))
    return found[0], found[1], released(slope, slope) / 2


def tada(length: float, width: float) -> float:
    """K_I of a crack of this half length in the middle of a plate of this half width."""
    ratio = length / width
    return math.sqrt(math.pi * length / math.cos(math.pi * ratio / 2)) * (
        1 - 0.025 * ratio**2 + 0.06 * ratio**4)
