#!/usr/bin/python3
"""Meshes of points in 3D: SVR beside the dynamic mesher and TetGen (the thesis's Fig. 3.4).

    tests/bench/experiments/point_clouds.py [--quick] [--corpus FOLDER] [--limit SECONDS]

FOLDER has bunny.node. Without it, generated points alone are meshed. TetGen is left out if it is not
installed. Processor time; a run over the limit is left out.
"""
from __future__ import annotations

import pathlib

import inputs
import meshers
from output import arguments, markdown, section, write_csv

# Seconds on a 3.2 GHz Pentium D (2007), and vertices, without the box's.
THESIS = {"bunny": (4.62, 59_702), "line & circle 2,000": (0.80, 12_119),
          "line & circle 20,000": (7.62, 120_933), "grid 50³": (11.30, 129_839),
          "grid 100³": (97.71, 1_016_262)}
THESIS_BUNNY = 34_890  # points

TEXT = """\
# Points in 3D: SVR, the dynamic mesher, TetGen

`tests/bench/experiments/point_clouds.py` writes this section: the table of the thesis's Fig. 3.4, whose
figures for SVR are in the last column (seconds of 2007). Circumradius / shortest edge is at most 2. Seconds
are of processor time, without reading and writing files. Vertices are without those of the box's border.
TetGen (Debian's 1.5, `-pq2`) has the same points in a cube as large as dynmesh's domain. "svr" and "dynamic"
are `dynmesh mesh --engine`, without a trace, `--min-dihedral 0`.
"""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--corpus", type=pathlib.Path, help="with bunny.node")
    parser.add_argument("--limit", type=float, default=400, help="seconds of a run")
    flags = parser.parse_args()
    scenes = {"line & circle 2,000": inputs.line_and_circle(2_000)}
    if not flags.quick:
        scenes["line & circle 20,000"] = inputs.line_and_circle(20_000)
        scenes["grid 50³"] = inputs.grid(50)
        scenes["grid 100³"] = inputs.grid(100)
    else:
        scenes["grid 50³"] = inputs.grid(20)
    if flags.corpus:
        scenes["bunny"] = inputs.read_node(flags.corpus / "bunny.node")
    head = ["input", "points", "method", "seconds", "vertices", "tetrahedra", "peak MB",
            "thesis: s, vertices"]
    rows, table = [], []
    speeds, sizes = [], []  # beside the thesis's
    for name, points in scenes.items():
        runs = {"svr": meshers.dynmesh(flags.bin / "dynmesh", "svr", points, flags.limit),
                "dynamic": meshers.dynmesh(flags.bin / "dynmesh", "dynamic", points, flags.limit)}
        if meshers.has_tetgen():
            runs["TetGen"] = meshers.tetgen(points, flags.limit)
        for method, run in runs.items():
            first = method == "svr"
            seconds, vertices = THESIS[name]
            if first and run is not None:
                speeds.append(seconds / run.seconds)
                sizes.append(100 * (run.vertices / vertices - 1))
            thesis = f"{seconds}, {vertices:,}" if first and not flags.quick else ""
            label = [name, f"{len(points):,}"] if first else ["", ""]
            if run is None:
                rows.append([name, len(points), method, "", "", "", ""])
                table.append([*label, method, f"over {flags.limit:g}", "", "", "", thesis])
                continue
            rows.append([name, len(points), method, run.seconds, run.vertices, run.tetrahedra,
                         round(run.megabytes)])
            table.append([*label, method, f"{run.seconds:.2f}", f"{run.vertices:,}",
                          f"{run.tetrahedra:,}", f"{run.megabytes:.0f}", thesis])
            print(*table[-1], sep="  ", flush=True)
    write_csv(flags.out / "point_clouds.csv", head[:-1], rows)
    if not flags.quick:
        after = (f"\nSVR is {min(speeds):.1f} to {max(speeds):.1f} times as fast as the thesis's "
                 f"seconds of 2007. Its meshes have {min(sizes):.1f} to {max(sizes):.1f} % more "
                 f"vertices than the thesis's, whose bunny has {THESIS_BUNNY:,} points. It wins "
                 "over the dynamic mesher where a triangulation of the input alone is large; on "
                 "grids the dynamic mesher wins, and its meshes are always the smaller ones.\n")
        section(flags.page, "point_clouds.py", TEXT + "\n" + markdown(head, table) + after)


if __name__ == "__main__":
    main()
