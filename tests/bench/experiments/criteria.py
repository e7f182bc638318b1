#!/usr/bin/python3
"""The criterion of edges beside the thesis's criterion: sizes and times.

    tests/bench/experiments/criteria.py [--quick] [--corpus FOLDER] [--limit SECONDS]

Points in 2D and 3D, and the maps of deploy/data and FOLDER/2d.
"""
from __future__ import annotations

import pathlib
import tempfile

import numpy as np

import inputs
import meshers
from output import ROOT, arguments, markdown, section, write_csv

TEXT = """\
# Two criteria

`tests/bench/experiments/criteria.py` writes this section. With the thesis's criterion a vertex is done when
its whole Voronoi cell is within ρ times the distance to its nearest neighbour; with that of edges, the
default, when each edge's Voronoi edge is within ρ times the edge's length (docs/refinement.md). Both bound
circumradius / shortest edge by ρ. The dynamic mesher without a trace; seconds of processor time.
"""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--corpus", type=pathlib.Path)
    parser.add_argument("--limit", type=float, default=200, help="seconds of a run")
    flags = parser.parse_args()
    n = 1_000 if flags.quick else 30_000
    points = {f"{n:,} uniform points": np.random.default_rng(2).random((n, 2)),
              f"{n:,} uniform points, 3D": inputs.uniform(n),
              f"line and circle, {n // 10:,}, 3D": inputs.line_and_circle(n // 10)}
    files = [ROOT / "deploy/data/coastline-110m.poly"]
    if flags.corpus and not flags.quick:
        files += [flags.corpus / "2d" / f"{name}.poly" for name in ("usstates", "land50", "city50")]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        scenes = {path.stem: path for path in files}
        for name, of in points.items():
            scenes[name] = pathlib.Path(folder) / f"{len(scenes)}.node"
            inputs.write_node(scenes[name], of)
        for name, path in scenes.items():
            cells = []
            for criterion in ("edge", "thesis"):
                run = meshers.dynmesh_of_file(
                    flags.bin / "dynmesh", path,
                    ["--criterion", criterion, "--min-dihedral", "0"], flags.limit)
                cells.append(run)
            edge, thesis = cells
            if edge is None or thesis is None:
                continue
            rows.append([name, f"{edge.seconds:.3f}", f"{edge.vertices:,}", f"{thesis.seconds:.3f}",
                         f"{thesis.vertices:,}", f"{edge.vertices / thesis.vertices:.2f}"])
            print(*rows[-1], sep="  ", flush=True)
    head = ["input", "edge, s", "vertices", "thesis, s", "vertices", "edge / thesis"]
    write_csv(flags.out / "criteria.csv", head, rows)
    if not flags.quick:
        section(flags.page, "criteria.py", TEXT + "\n" + markdown(head, rows))


if __name__ == "__main__":
    main()
