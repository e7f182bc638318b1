#!/usr/bin/python3
"""Meshes of a corpus of points, segments and polygons, by SVR and the dynamic mesher (Fig. 3.3).

    tests/bench/experiments/plcs.py [--quick] [--corpus FOLDER] [--limit SECONDS]

Files of deploy/data, and of FOLDER/2d, FOLDER/3d and FOLDER/plc3 if given. Each mesh of SVR is judged
by `dynmesh verify`. TetGen meshes surfaces, if it is installed. Also draws a cut of a mesh.
"""
from __future__ import annotations

import pathlib
import subprocess
import tempfile

import meshers
from output import ROOT, arguments, markdown, section, show, write_csv

TEXT = """\
# A corpus by SVR

`tests/bench/experiments/plcs.py` writes this section: points, segments and polygons. Both engines without a trace, `--min-dihedral 0`, at
the default quality (2D: √2, 3D: 2); seconds are of processor time, without reading and writing files;
vertices are all, those of the domain's border among them. "judge" is `dynmesh verify` of SVR's mesh, with its
input. Of TetGen (`-pq2`) the mesh ends at the input's hull, so it has fewer vertices; in "refused" input
meets itself or has angles below the bounds of 3D, and both engines refuse it alike.

![A cut through SVR's mesh of a box in a box](deploy/pictures/svr_boxes.svg)

*A cut through SVR's mesh of `deploy/data/boxes.dynmesh` (the thesis's Fig. 3.3 has such pictures).*
"""


def judged(program: pathlib.Path, path: pathlib.Path, flags: list[str]) -> str:
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "mesh.node"
        made = subprocess.run([program, "mesh", path, *flags, "--engine", "svr", "-o", out],
                              capture_output=True, check=False)
        if made.returncode != 0:
            return "refused"
        verdict = subprocess.run([program, "verify", out, "--input", path, *flags],
                                 capture_output=True, check=False)
        return "good" if verdict.returncode == 0 else "FAILED"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--corpus", type=pathlib.Path)
    parser.add_argument("--limit", type=float, default=200, help="seconds of a run")
    flags = parser.parse_args()
    program = flags.bin / "dynmesh"
    paths = [ROOT / "deploy/data/coastline-110m.poly", ROOT / "deploy/data/boxes.dynmesh"]
    if flags.corpus and not flags.quick:
        for pattern in ("2d/*.poly", "plc3/*.off", "2d/*.node", "3d/*.node"):
            paths += sorted(flags.corpus.glob(pattern))
    rows = []
    for path in paths:
        options = ["--merge-coplanar"] if path.suffix == ".off" else []
        dihedral = ["--min-dihedral", "0"]
        runs = {engine: meshers.dynmesh_of_file(
            program, path, [*options, *dihedral, "--engine", engine], flags.limit)
            for engine in ("svr", "dynamic")}
        if path.suffix == ".off" and meshers.has_tetgen():
            runs["TetGen"] = meshers.tetgen_of_file(path, "-pq2", flags.limit)
        verdict = judged(program, path, options)
        cells = []
        for method in ("svr", "dynamic", "TetGen"):
            run = runs.get(method)
            cells += ["", ""] if run is None else [f"{run.seconds:.3f}", f"{run.vertices:,}"]
        name = f"{path.stem}, 3D" if path.parent.name == "3d" else path.stem
        rows.append([name, *cells, verdict])
        print(*rows[-1], sep="  ", flush=True)
    head = ["input", "svr, s", "vertices", "dynamic, s", "vertices", "TetGen, s", "vertices",
            "judge"]
    write_csv(flags.out / "plcs.csv", head, rows)
    picture = flags.out / "svr_boxes.svg"
    subprocess.run([program, "mesh", paths[1], "--engine", "svr", "-o", picture, "--cut", "z=2"],
                   stdout=subprocess.DEVNULL, check=True)
    if not flags.quick:
        show(flags.page, picture)
        section(flags.page, "plcs.py", TEXT + "\n" + markdown(head, rows))


if __name__ == "__main__":
    main()
