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

import numpy as np

import dynmesh
import elastic
from fem import is_all_of
from opened import opened

PLATE, CRACK = 7, 20  # the plate's polygon; ids of the crack's segments follow
WIDTH, HEIGHT = 1.0, 2.0  # half of the plate's
TENSION = {"top": 1.0, "bottom": -1.0}  # on the sides of these names


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
               add_polygons={PLATE: corners}, add_segments={8: (1, 2), 9: (3, 4), CRACK: (10, 11)},
               add_sizes=sizes(length, edge), set_labels={
                   8: dict(name="bottom"), 9: dict(name="top"), CRACK: dict(name="crack")})
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
        u, _ = elastic.displacement(part, TENSION, [corners[1], corners[2]])
        exact = elastic.tada(length, WIDTH)
        found = [elastic.intensities(part, u, np.array([side * length, 0]), np.array([side, 0]),
                                     0.2)[0] for side in (-1, 1)]
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


def integral(part: dynmesh.Part, u: np.ndarray) -> np.ndarray:
    return elastic.strain_matrices(part)[0] @ u[part.cells].mean(axis=1)


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
