#!/usr/bin/python3
"""The everyday commands on a corpus, beside Triangle, TetGen and Gmsh.

    tests/bench/experiments/everyday.py [--quick] [--corpus FOLDER] [--triangle PROGRAM]
                                        [--limit SECONDS]

Files of FOLDER/2d and FOLDER/plc3; without FOLDER, deploy/data's coastline alone. A program that is
not installed is left out. Processor time of whole processes, from file to file: the least of three.
"""
from __future__ import annotations

import math
import pathlib
import shutil
import tempfile
from dataclasses import dataclass
from typing import Optional

import numpy as np

import geo_files
import meshers
from output import ROOT, arguments, markdown, section, write_csv
from tetrahedra import least_angles

PLANE = ["guitar", "island", "sweden", "city50", "hex20", "land110", "usstates", "uscounties"]
SPACE = ["unitbox", "boxinbox", "boxes125", "cgal_pipe", "cgal_cross", "bunny_small"]
CELLS = 20_000  # of the largest size, in the box around the input
RUNS = 3

TEXT = f"""\
# Everyday commands

`tests/bench/experiments/everyday.py` writes this section. Seconds are of processor time of whole processes,
from file to file, the least of {RUNS} runs. Vertices are those of the written cells. The angle is the least of
all triangles, in 3D of all dihedral angles, by the script's own code; sharper angles of the input limit it for
all programs. The script also checks that all programs mesh the same area or volume.

| task | dynmesh | {{triangle}}TetGen | Gmsh |
| --- | --- | {{dashes}}--- | --- |
| all | `mesh F`: with the surroundings, six times the input's size | {{none}} | |
| inside | `mesh F --inside`, in 3D with `--merge-coplanar` | {{inside}}`-pq2/10` | sizes from the border alone |
| 30° | `mesh F --inside -q 30` | {{thirty}} | |
| size | `mesh F --inside -q 30 -a A`, in 3D `--inside --max-volume V` | {{size}}`-pq2/10aV` | the edge of a regular cell of size A or V |

A dash: the program refuses the input (docs/input.md has the angles that dynmesh wants in 3D).
A and V are the area and volume of the box around the input / {CELLS:,}. Gmsh takes no bound on angles or sizes.
It meshes surfaces, and outlines that are disjoint loops. Where more than two segments meet in a point, as in
`hex20`, `land110` and the states, its input would have to be made by hand, from faces.
"""


@dataclass
class Result:
    """A mesh made: processor seconds, and what the script measures of it."""

    seconds: float
    vertices: int
    angle: float  # the least one, in degrees
    largest: float  # area or volume of a cell
    total: float


def measure(seconds: float, points: np.ndarray, cells: np.ndarray) -> Result:
    corners = points[cells]
    edges = corners[:, 1:] - corners[:, :1]
    if cells.shape[1] == 3:
        sizes = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / 2
        angle = 180.0
        for k in range(3):
            u, w = (corners[:, (k + j) % 3] - corners[:, k] for j in (1, 2))
            cross = np.abs(u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0])
            angle = min(angle, float(np.degrees(np.arctan2(cross, (u * w).sum(axis=1))).min()))
    else:
        sizes = np.abs(np.linalg.det(edges)) / 6
        angle = float(least_angles(points, cells).min())
    return Result(seconds, len(np.unique(cells)), angle, float(sizes.max()), float(sizes.sum()))


def best(command: list[str], limit: float) -> Optional[float]:
    """The least processor seconds; None if it fails or takes too long."""
    seconds = math.inf
    for _ in range(RUNS):
        timed = meshers.timed(command, limit)
        if timed is None:
            return None
        seconds = min(seconds, timed[0])
        if seconds > 20:
            break
    return seconds


class Programs:
    """The programs that are here, each as a function from a task to its result."""

    def __init__(self, flags, folder: pathlib.Path) -> None:
        self.flags = flags
        self.folder = folder
        self.triangle = flags.triangle or shutil.which("triangle")
        self.tetgen = shutil.which("tetgen")
        self.gmsh = shutil.which("gmsh")

    def dynmesh(self, path: pathlib.Path, dimension: int, task: str,
                bound: float) -> Optional[Result]:
        flags = []
        if dimension == 3:
            flags.append("--merge-coplanar")
        if task != "all":
            flags.append("--inside")
        if dimension == 2 and task in ("30°", "size"):
            flags += ["-q", "30"]
        if task == "size":
            flags += ["-a" if dimension == 2 else "--max-volume", repr(bound)]
        out = self.folder / f"out{dimension}d.node"
        seconds = best([str(self.flags.bin / "dynmesh"), "mesh", str(path), *flags, "-o", str(out)],
                       self.flags.limit)
        return self._read(seconds, out.with_suffix(""), dimension)

    def classic(self, path: pathlib.Path, dimension: int, task: str,
                bound: float) -> Optional[Result]:
        """Triangle in 2D, TetGen in 3D."""
        program = self.triangle if dimension == 2 else self.tetgen
        if program is None or task == "all":
            return None
        quality = {"inside": "q20.7", "30°": "q30", "size": "q30"}[task] if dimension == 2 else "q2/10"
        size = f"a{bound:.17f}" if task == "size" else ""
        copy = self.folder / f"in{dimension}d{path.suffix}"
        shutil.copy(path, copy)
        seconds = best([program, f"-p{quality}{size}Q", str(copy)], self.flags.limit)
        return self._read(seconds, self.folder / f"in{dimension}d.1", dimension)

    def by_gmsh(self, path: pathlib.Path, dimension: int, task: str,
                bound: float) -> Optional[Result]:
        if self.gmsh is None or task not in ("inside", "size"):
            return None
        edge = None
        if task == "size":
            edge = math.sqrt(4 / math.sqrt(3) * bound) if dimension == 2 else (
                6 * math.sqrt(2) * bound) ** (1 / 3)
        text = (geo_files.of_poly if dimension == 2 else geo_files.of_off)(path, edge)
        if text is None:
            return None
        source, out = self.folder / "in.geo", self.folder / "out.msh"
        source.write_text(text, encoding="ascii")
        seconds = best([self.gmsh, f"-{dimension}", "-format", "msh22", "-nt", "1", "-v", "1",
                        "-o", str(out), str(source)], self.flags.limit)
        if seconds is None:
            return None
        points, cells = geo_files.read_msh(out, dimension)
        return measure(seconds, points, cells) if len(cells) else None

    @staticmethod
    def _read(seconds: Optional[float], stem: pathlib.Path, dimension: int) -> Optional[Result]:
        if seconds is None:
            return None
        nodes, cells = meshers.read_rows(f"{stem}.node"), meshers.read_rows(f"{stem}.ele")
        first = int(nodes[0, 0])
        return measure(seconds, nodes[:, 1:1 + dimension],
                       cells[:, 1:2 + dimension].astype(int) - first)


def bound_of(path: pathlib.Path) -> float:
    """The size of the box around the input / CELLS."""
    points = geo_files.points_of(path)
    return float(np.prod(points.max(axis=0) - points.min(axis=0))) / CELLS


def cells_of(result: Optional[Result], was_run: bool) -> list[str]:
    if result is None:
        return ["–" if was_run else "", "", ""]
    return [f"{result.vertices:,}", f"{result.seconds:.3f}", f"{result.angle:.2f}"]


def check(name: str, task: str, bound: float, results: dict[str, Optional[Result]]) -> None:
    """Fails if a bound is not kept, or if the programs mesh different domains."""
    totals = {program: r.total for program, r in results.items() if r is not None}
    if task != "all" and max(totals.values()) > min(totals.values()) * (1 + 1e-6):
        raise RuntimeError(f"{name}, {task}: the programs meshed different domains: {totals}")
    for program, r in results.items():
        if r is not None and task == "size" and program != "Gmsh" and r.largest > bound * (1 + 1e-9):
            raise RuntimeError(f"{name}: {program}'s largest cell is {r.largest / bound} bounds")


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--corpus", type=pathlib.Path)
    parser.add_argument("--triangle", help="Triangle's program, if it is not in the PATH")
    parser.add_argument("--limit", type=float, default=200, help="seconds of a run")
    flags = parser.parse_args()
    inputs = [(ROOT / "deploy/data/coastline-110m.poly", 2)]
    if flags.corpus:
        inputs = [(flags.corpus / "2d" / f"{name}.poly", 2) for name in PLANE]
        inputs += [(flags.corpus / "plc3" / f"{name}.off", 3) for name in SPACE]
    if flags.quick:
        inputs = inputs[:1] + inputs[-1:]
    rows, largest, beside = [], [], []  # beside: dynmesh and TetGen
    with tempfile.TemporaryDirectory() as folder:
        programs = Programs(flags, pathlib.Path(folder))
        for path, dimension in inputs:
            bound = bound_of(path)
            for task in ("all", "inside", "30°", "size") if dimension == 2 else ("inside", "size"):
                results = {name: run(path, dimension, task, bound) for name, run in
                           (("dynmesh", programs.dynmesh), ("classic", programs.classic),
                            ("Gmsh", programs.by_gmsh))}
                check(path.stem, task, bound, results)
                if task == "size" and results["Gmsh"] is not None:
                    largest.append(results["Gmsh"].largest / bound)
                if dimension == 3 and results["dynmesh"] and results["classic"]:
                    beside.append((task, results["dynmesh"], results["classic"]))
                row = [path.stem if task in ("all", "inside") else "", task]
                for name, result in results.items():
                    row += cells_of(result, name == "dynmesh" or (name, dimension) == ("classic", 3))
                rows.append(row)
                print(*rows[-1], sep="  ", flush=True)
    has_triangle = programs.triangle is not None
    other = "Triangle, TetGen" if has_triangle else "TetGen"
    head = ["input", "task"] + [f"{name}: {what}" if what == "vertices" else what
                                for name in ("dynmesh", other, "Gmsh")
                                for what in ("vertices", "s", "angle")]
    write_csv(flags.out / "everyday.csv", head, rows)
    if flags.quick:
        return
    text = TEXT.format(
        triangle="Triangle; " if has_triangle else "", dashes="", none="",
        inside="`-pq20.7`; " if has_triangle else "", thirty="`-pq30`" if has_triangle else "",
        size="`-pq30aA`; " if has_triangle else "")
    if not has_triangle:
        text += "Triangle was not installed where this ran.\n"
    after = ""
    for task in ("inside", "size"):
        pairs = [(mine, other) for of, mine, other in beside if of == task]
        if not pairs:
            continue
        sizes = [mine.vertices / other.vertices for mine, other in pairs]
        times = [mine.seconds / other.seconds for mine, other in pairs]
        after += (f"\nTask {task} in 3D: dynmesh's meshes have {min(sizes):.2f} to {max(sizes):.2f} "
                  f"times as many vertices as TetGen's, and take {min(times):.1f} to "
                  f"{max(times):.1f} times as long.\n")
    after += (f"\nThe largest cells of dynmesh and {other} keep the bound; Gmsh's are "
             f"{min(largest):.1f} to {max(largest):.1f} times as large.\n") if largest else ""
    section(flags.page, "everyday.py", text + "\n" + markdown(head, rows) + after)


if __name__ == "__main__":
    main()
