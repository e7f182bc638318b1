#!/usr/bin/env python3
"""Heat conduction with FreeFEM (Debian's freefem++) on a mesh that changes.

    examples/plate_freefem.py [--edge 0.03] [--out out/plate_freefem] [--server HOST:PORT]

A disc moves and a wire grows in a plate. After each edit FreeFEM gets the present mesh as a file
with regions and labels, with the transferred temperature; plate_freefem.edp solves. Writes a series
for ParaView; plate.py, shared by all packages, describes the checks.
"""
from __future__ import annotations

import pathlib
import shutil
import subprocess
import tempfile

import numpy as np

import plate

SCRIPT = pathlib.Path(__file__).resolve().with_suffix(".edp")


def write(part: plate.Part, path: pathlib.Path) -> None:
    """Writes FreeFEM's .msh: vertices, triangles and edges, each with a label, numbered from 1."""
    rows = [f"{len(part.points)} {len(part.cells)} {len(part.facets)}"]
    rows += [f"{x!r} {y!r} 0" for x, y in part.points.tolist()]
    for corners, labels in ((part.cells, part.cell_markers), (part.facets, part.facet_markers)):
        rows += [" ".join(map(str, row)) for row in np.column_stack([corners + 1, labels]).tolist()]
    path.write_text("\n".join(rows) + "\n", encoding="ascii")


def solve(part: plate.Part) -> plate.Answer:
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write(part, folder / "plate.msh")
        numbers = [plate.TIME_STEP, *plate.CONDUCTIVITY.values(),
                   *(plate.HEATING[key] for key in (plate.DISC, plate.WIRE, plate.LEFT)), *part.u]
        (folder / "before.txt").write_text("\n".join(repr(float(n)) for n in numbers) + "\n",
                                           encoding="ascii")
        done = subprocess.run(["FreeFem++", "-nw", "-v", "0", SCRIPT], cwd=folder, text=True,
                              capture_output=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        found = np.loadtxt(folder / "after.txt")
    areas, lengths, heat, u = found[:2], found[2:6], found[6:8], found[8:]
    return plate.Answer(
        areas=dict(zip((plate.IN_PLATE, plate.IN_DISC), areas)),
        lengths=dict(zip((plate.LEFT, plate.PLATE, plate.DISC, plate.WIRE), lengths)),
        heat=heat[0], u=u, heat_after=heat[1])


if __name__ == "__main__":
    if shutil.which("FreeFem++") is None:
        plate.missing("freefem++")
    plate.run("freefem", solve)
