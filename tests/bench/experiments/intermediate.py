#!/usr/bin/python3
"""Inputs whose own Delaunay triangulation is large or slow to refine (the thesis's Figs. 2.2, 2.3).

    tests/bench/experiments/intermediate.py [--quick] [--limit SECONDS]

TetGen is left out if it is not installed.
"""
from __future__ import annotations

import pathlib
import tempfile

import inputs
import meshers
from output import arguments, markdown, section, write_csv

TEXT = """\
# Triangulations on the way

`tests/bench/experiments/intermediate.py` writes this section. A mesher that triangulates its input first
meets vertices of large degree on the way to a mesh that has none. "dynamic" is the dynamic mesher without a
trace; seconds are of processor time, without reading and writing files.

## Shortest edges first (Fig. 2.2)

n points in 2D: on a line with gaps that grow a little, one at the off-center of the first gap, two so far
that they see all of the line. A mesher of shortest edges first, in a triangulation of all points, changes
a linear number of triangles at each step; the thesis measured a quadratic time of Triangle 1.5.
"""

CIRCLE = """\
## Line and circle (Fig. 2.3)

n/2 points on a circle and n/2 on its axis. "alone" is the number of tetrahedra of the input's own Delaunay
tetrahedralization, (n/2)² and more, by TetGen without refinement.
"""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--limit", type=float, default=200, help="seconds of a run")
    flags = parser.parse_args()
    program = flags.bin / "dynmesh"
    rows, planar = [], []
    for n in (300, 1_000) if flags.quick else (1_000, 3_000, 10_000, 30_000, 100_000):
        for engine in ("svr", "dynamic"):
            run = meshers.dynmesh(program, engine, inputs.shortest_first(n), flags.limit)
            figures = ["", ""] if run is None else [f"{run.seconds:.3f}", run.vertices]
            rows.append(["shortest first", n, engine, *figures, "", ""])
            per = "" if run is None else f"{1e6 * run.seconds / run.vertices:.2f}"
            planar.append([f"{n:,}", engine, figures[0] or f"over {flags.limit:g}",
                           f"{figures[1]:,}" if run else "", per])
            print(*planar[-1], sep="  ", flush=True)
    spatial = []
    for n in (200, 500) if flags.quick else (200, 500, 1_000, 2_000, 5_000, 10_000):
        points = inputs.line_and_circle(n)
        alone = None
        if meshers.has_tetgen():
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "points.node"
                inputs.write_node(path, points)
                alone = meshers.tetgen_of_file(path, "-", flags.limit)
        for engine in ("svr", "dynamic"):
            run = meshers.dynmesh(program, engine, points, flags.limit)
            of_input = "" if alone is None else alone.tetrahedra
            figures = (["", "", ""] if run is None else
                       [f"{run.seconds:.3f}", run.vertices, run.tetrahedra])
            rows.append(["line and circle", n, engine, *figures, of_input])
            spatial.append([f"{n:,}", f"{of_input:,}" if alone else "", engine, figures[0],
                            f"{figures[1]:,}" if run else "", f"{figures[2]:,}" if run else "",
                            f"{run.tetrahedra / n:.1f}" if run else ""])
            print(*spatial[-1], sep="  ", flush=True)
    write_csv(flags.out / "intermediate.csv",
              ["input", "points", "engine", "seconds", "vertices", "tetrahedra", "alone"], rows)
    if not flags.quick:
        section(flags.page, "intermediate.py", TEXT + "\n" + markdown(
            ["points", "engine", "seconds", "vertices", "us a vertex"], planar) + "\n" + CIRCLE
            + "\n" + markdown(["points", "alone", "engine", "seconds", "vertices", "tetrahedra",
                               "a point"], spatial))


if __name__ == "__main__":
    main()
