#!/usr/bin/python3
"""How much of a mesh moves if one input point goes (the thesis's Fig. 4.1).

    tests/bench/experiments/stability.py [--quick]

A point is left out of uniform points in a cube, and both inputs are meshed from scratch, by SVR and by
the dynamic mesher. Vertices and tetrahedra of the second mesh that the first did not have, in percent.
"""
from __future__ import annotations

import pathlib
import statistics
import subprocess
import tempfile

import numpy as np

import inputs
from output import arguments, markdown, section, write_csv

TEXT = """\
# One point less

`tests/bench/experiments/stability.py` writes this section (the thesis's Fig. 4.1, its reason for a
second, stable mesher): how much of a mesh from scratch is another one if one of n uniform points is left
out. Means of 20 such points. SVR decides by the order of its work, and one decision moves all that
follow; the dynamic mesher's decisions are local.
"""


def vertices_and_cells(stem: pathlib.Path) -> tuple[set[str], set[tuple[str, ...]]]:
    """By the text of their coordinates."""
    def rows(suffix: str) -> list[list[str]]:
        lines = pathlib.Path(f"{stem}.{suffix}").read_text(encoding="ascii").splitlines()
        kept = [line.split() for line in lines if line and not line.startswith("#")]
        return kept[1:1 + int(kept[0][0])]

    position = {row[0]: " ".join(row[1:4]) for row in rows("node")}
    cells = {tuple(sorted(position[corner] for corner in row[1:5])) for row in rows("ele")}
    return set(position.values()), cells


def mesh(program: pathlib.Path, engine: str, points: np.ndarray, folder: pathlib.Path,
         box: str) -> tuple[set[str], set[tuple[str, ...]]]:
    inputs.write_node(folder / "points.node", points)
    subprocess.run([str(program), "mesh", str(folder / "points.node"), "--engine", engine,
                    "--min-dihedral", "0", "--box", box, "-o", str(folder / "mesh.node")],
                   check=True, stdout=subprocess.DEVNULL)
    return vertices_and_cells(folder / "mesh")


def main() -> None:
    flags = arguments(__doc__).parse_args()
    head = ["points", "engine", "vertices moved, %", "tetrahedra changed, %"]
    rows = []
    for n in [300] if flags.quick else [300, 3_000, 30_000]:
        points = inputs.uniform(n)
        for engine in ["svr", "dynamic"]:
            shares: list[tuple[float, float]] = []
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                before = mesh(flags.bin / "dynmesh", engine, points, folder, "0,0,0,1,1,1")
                for i in range(20):
                    less = np.delete(points, i * n // 20, axis=0)
                    after = mesh(flags.bin / "dynmesh", engine, less, folder, "0,0,0,1,1,1")
                    shares.append(tuple(100 * len(a - b) / len(a)
                                        for a, b in zip(after, before)))
            means = [statistics.mean(share) for share in zip(*shares)]
            rows.append([n, engine, f"{means[0]:.3g}", f"{means[1]:.3g}"])
            print(*rows[-1], sep="  ", flush=True)
    write_csv(flags.out / "stability.csv", head, rows)
    if not flags.quick:
        section(flags.page, "stability.py",
                TEXT + "\n" + markdown(head, [[f"{row[0]:,}", *row[1:]] for row in rows]))


if __name__ == "__main__":
    main()
