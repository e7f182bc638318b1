#!/usr/bin/env python3
"""The stress intensity of a centre crack that grows, beside Tada's formula.

A plate under tension, plane strain, P1 finite elements. The part of the mesh is opened along the
crack, and the displacement, which jumps there, is carried from step to step.

    examples/crack_intensity.py [--edge 0.1] [--steps 4] [--out out/crack] [--server HOST:PORT]

Writes a series for ParaView, and checks the stress intensities, and that edits keep the integral of
the displacement and the area between the crack's faces.
"""
from __future__ import annotations

import argparse
import math

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

import dynmesh
from fem import is_all_of
from opened import opened

PLATE, CRACK = 7, 20  # the plate's polygon; ids of the crack's segments follow
WIDTH, HEIGHT = 1.0, 2.0  # half of the plate's
POISSON = 0.3  # Young's modulus and the tension are 1
LAW = np.array([[1 - POISSON, POISSON, 0], [POISSON, 1 - POISSON, 0], [0, 0, 0.5 - POISSON]]) / (
    (1 + POISSON) * (1 - 2 * POISSON))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--edge", type=float, default=0.1, help="target length of edges")
    parser.add_argument("--steps", type=int, default=4)
    parser.add_argument("--out", default="out/crack")
    parser.add_argument("--server", help="address of a dynmeshd; in process without")
    arguments = parser.parse_args()
    box = [[-WIDTH, -HEIGHT], [WIDTH, HEIGHT]]
    with opened(arguments.server, box=box, max_edge=arguments.edge) as mesh:
        run(mesh, arguments.edge, arguments.steps, arguments.out)


def run(mesh: dynmesh.Mesh, edge: float, steps: int, out: str) -> None:
    corners = {1: (-WIDTH, -HEIGHT), 2: (WIDTH, -HEIGHT), 3: (WIDTH, HEIGHT), 4: (-WIDTH, HEIGHT)}
    length = 0.3  # half of the crack's
    mesh.apply(add_points={**corners, 10: (-length, 0), 11: (length, 0)},
               add_polygons={PLATE: corners}, add_segments={CRACK: (10, 11)},
               add_sizes=sizes(length, edge), set_labels={CRACK: dict(name="crack")})
    part = mesh.part(polygons=PLATE, open="crack")  # the seam
    series = dynmesh.Series(f"{out}/crack.pvd")
    worst, lost, closed = 0.0, 0.0, 0.0
    for step in range(steps):
        if step > 0:
            length += 0.05
            left, right = 10 + 2 * step, 11 + 2 * step
            before = integral(part, u), opening(part, u)
            diff = mesh.apply(
                add_points={left: (-length, 0), right: (length, 0)},
                add_segments={CRACK + left: (left, left - 2), CRACK + right: (right - 2, right)},
                set_sizes=sizes(length, edge),
                set_labels={CRACK + id_: dict(name="crack") for id_ in (left, right)})
            u = part.transfer(diff, u)
            lost = max(lost, np.abs(integral(part, u) - before[0]).max())
            closed = max(closed, abs(opening(part, u) / before[1] - 1))
        u = displacement(part)
        ratio = length / WIDTH
        exact = math.sqrt(math.pi * length / math.cos(math.pi * ratio / 2)) * (
            1 - 0.025 * ratio**2 + 0.06 * ratio**4)
        found = [intensity(part, u, side * length, side) for side in (-1, 1)]
        worst = max(worst, *(abs(k / exact - 1) for k in found))
        print(f"half length {length:.2f}: {len(part.points)} vertices, K at the tips "
              f"{found[0]:.4f} and {found[1]:.4f}, Tada {exact:.4f}")
        series.add(step, part, point_data={"displacement": u})
    print(f"stress intensities within {worst:.1%}; edits kept the displacement's integral to "
          f"{lost:.1e} and the crack's area to {closed:.1e}; series in {series.path}")
    assert is_all_of(part, 4 * WIDTH * HEIGHT), "there are cells outside of the plate"
    assert worst < 0.02, "a stress intensity is wrong"
    assert lost < 1e-11 and closed < 0.01, "an edit changed the displacement"
    print("good")


def sizes(length: float, edge: float) -> dict[int, dict[str, object]]:
    """Discs around both tips, the inner ones finer."""
    return {100 + 10 * side + level: dict(at=(x, 0), radius=0.2 * edge * 2**level,
                                          target=0.05 * edge * 2**level)
            for side, x in enumerate((-length, length)) for level in range(4)}


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


def displacement(part: dynmesh.Part) -> np.ndarray:
    area, _, strains = strain_matrices(part)
    stiffness = np.einsum("n,nki,kl,nlj->nij", area, strains, LAW, strains)
    unknowns = (2 * part.cells[:, :, None] + [0, 1]).reshape(-1, 6)
    matrix = coo_matrix((stiffness.ravel(), (np.repeat(unknowns, 6, axis=1).ravel(),
                                             np.tile(unknowns, (1, 6)).ravel()))).tocsr()
    # Tension at the upper and lower side.
    load = np.zeros((len(part.points), 2))
    for side in (-1, 1):
        edges = part.facets[(part.points[part.facets, 1] == side * HEIGHT).all(axis=1)]
        lengths = np.linalg.norm(part.points[edges[:, 1]] - part.points[edges[:, 0]], axis=1)
        np.add.at(load[:, 1], edges, side * lengths[:, None] / 2)
    # No motion of the whole: a lower corner stays, the other one in its height.
    fixed = [2 * corner(part, -WIDTH), 2 * corner(part, -WIDTH) + 1, 2 * corner(part, WIDTH) + 1]
    free = np.setdiff1d(np.arange(matrix.shape[0]), fixed)
    u = np.zeros(matrix.shape[0])
    u[free] = spsolve(matrix[free][:, free], load.ravel()[free])
    return u.reshape(-1, 2)


def corner(part: dynmesh.Part, x: float) -> int:
    return int(np.flatnonzero((part.points == [x, -HEIGHT]).all(axis=1))[0])


def intensity(part: dynmesh.Part, u: np.ndarray, tip: float, side: int) -> float:
    """From the energy release rate: the J-integral over a ring around the tip, as one over cells."""
    area, gradients, strains = strain_matrices(part)
    strain = np.einsum("nki,ni->nk", strains, u[part.cells].reshape(-1, 6))
    stress = strain @ LAW
    tensor = stress[:, [0, 2, 2, 1]].reshape(-1, 2, 2)
    slope = np.einsum("nik,nkj->nji", gradients, u[part.cells])  # of u_j along axis i
    # Falls from one to zero away from the tip.
    weight = np.clip(1.5 - np.linalg.norm(part.points - [tip, 0], axis=1) / 0.1, 0, 1)
    falls = np.einsum("nik,nk->ni", gradients, weight[part.cells])
    energy = (stress * strain).sum(axis=1) / 2
    released = np.einsum("nij,ni,nj->n", tensor, slope[:, :, 0], falls) - energy * falls[:, 0]
    return math.sqrt(max(0, side * float(area @ released)) / (1 - POISSON**2))


def integral(part: dynmesh.Part, u: np.ndarray) -> np.ndarray:
    return strain_matrices(part)[0] @ u[part.cells].mean(axis=1)


def opening(part: dynmesh.Part, u: np.ndarray) -> float:
    """The area between the faces of the crack."""
    faces = np.flatnonzero(part.facet_twins >= 0)
    edges, others = part.facets[faces], part.facets[part.facet_twins[faces]][:, ::-1]
    along = part.points[edges[:, 1]] - part.points[edges[:, 0]]
    width = (u[edges] - u[others]).mean(axis=1)
    # The part is on the left of an edge. Each pair is there twice.
    return float((width[:, 1] * along[:, 0] - width[:, 0] * along[:, 1]).sum() / 2)


if __name__ == "__main__":
    main()
