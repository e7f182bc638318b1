#!/usr/bin/python3
"""Dihedral angles with and without min_dihedral, beside TetGen and CGAL's Mesh_3. Writes a section
of RESULTS.md.

    tests/bench/dihedral_table.py [--quick] [--bin build/release/bin] [--corpus FOLDER] [--out RESULTS.md]

FOLDER has boxes125.off, cgal_pipe.off, cgal_P.off, cgal_cross.off and cgal_cube.off; without it only
generated input is meshed: points, a box, a box in a box. Skips methods without an installed program.
Tetrahedra below the bound are listed on standard error, and counted in the table.
"""
from __future__ import annotations

import argparse
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from typing import Iterator, Optional

import numpy as np

import tetrahedra
from results_page import put_section

BOUNDS = (5, 10, 15)
MOST_RATIO = {False: 1.12, True: 1.06}  # of vertices with the option; True: with max_edge

BEFORE = """\
# Dihedral angles

What `min_dihedral` is worth and what it costs. `tests/bench/dihedral_table.py` writes this section; it
reads the angles off the files.

Points are uniform in a unit box of six facets. `h` is `max_edge`: no edge is longer than √2 `h`. Counts
are of the domain, that is, within the walls: there the other meshes end, while dynmesh's goes on outside.
`<5 / <10 / <15` counts tetrahedra whose least dihedral angle, `least`, is below so many degrees. The ratio
is that of vertices in the domain to those without the option. `everywhere` is of the whole mesh: its
vertices, and the tetrahedra that are left below the bound (`off`: below 10). Seconds are of processor time,
from file to file; the machine was shared, so trust ratios.

TetGen's `-pq2/10` is radius-edge ratio 2 and 10 degrees. With `h` its volumes are bounded by that of the
regular tetrahedron with edges `h`, so its tetrahedra are smaller. CGAL's Mesh_3 makes edges as long as
the mean of dynmesh's without the option, perturbs, then exudes. It makes the same size everywhere, and
takes no points.
"""

HEAD = ("| input | method | vertices | tetrahedra | least | <5 / <10 / <15 | ratio | everywhere | s |\n"
        "|---|---|---|---|---|---|---|---|---|")


@dataclass
class Input:
    name: str
    points: np.ndarray
    facets: list[list[int]]  # rings of corners
    h: float = 0

    def write(self, stem: pathlib.Path) -> pathlib.Path:
        """An OFF file if all points are corners, else a .smesh."""
        lines = [" ".join(repr(float(x)) for x in p) for p in self.points]
        facets = [f"{len(ring)} " + " ".join(map(str, ring)) for ring in self.facets]
        if len({v for ring in self.facets for v in ring}) == len(self.points):
            path = stem.with_suffix(".off")
            lines = ["OFF", f"{len(lines)} {len(facets)} 0", *lines, *facets]
        else:
            path = stem.with_suffix(".smesh")
            numbered = [f"{i} {line}" for i, line in enumerate(lines)]
            lines = [f"{len(lines)} 3 0 0", *numbered, f"{len(facets)} 0", *facets, "0", "0"]
        path.write_text("\n".join([*lines, ""]), encoding="ascii")
        return path


def box(lo: float, hi: float, first: int = 0) -> tuple[np.ndarray, list[list[int]]]:
    corners = [[hi if i >> k & 1 else lo for k in range(3)] for i in range(8)]
    facets = []
    for axis in range(3):
        a, b = (1 << k for k in range(3) if k != axis)
        for side in (0, 1 << axis):
            ring = [side, side + a, side + a + b, side + b]
            # Outwards: a, b and the axis turn right if the axis is the second.
            facets.append([first + v for v in (ring if (side > 0) != (axis == 1) else ring[::-1])])
    return np.array(corners, float), facets


def read_off(path: pathlib.Path) -> tuple[np.ndarray, list[list[int]]]:
    lines = [line.split("#")[0].split() for line in path.read_text(encoding="ascii").splitlines()]
    rows = [row for row in lines if row][1:]
    count, facets = int(rows[0][0]), int(rows[0][1])
    points = np.array([[float(x) for x in row[:3]] for row in rows[1:1 + count]])
    return points, [[int(v) for v in row[1:1 + int(row[0])]]
                    for row in rows[1 + count:1 + count + facets]]


def inputs(corpus: Optional[pathlib.Path], quick: bool) -> Iterator[Input]:
    corners, walls = box(0, 1)
    rng = np.random.default_rng(11)
    for count in (3000,) if quick else (3000, 20_000, 100_000):
        yield Input(f"{count:,} points", np.vstack([corners, rng.random((count, 3))]), walls)
    inner, inner_walls = box(0.3, 0.7, 8)
    solids = {"box": (corners, walls),
              "box in box": (np.vstack([corners, inner]), walls + inner_walls)}
    if corpus is not None:
        for name in ("boxes125", "pipe", "P", "cross", "cube"):
            path = corpus / f"{name}.off"
            solids[name] = read_off(path if path.exists() else corpus / f"cgal_{name}.off")
    for name, solid in solids.items():
        yield Input(name, *solid)
    for name, h in {"box": 0.07, "box in box": 0.05, "boxes125": 0.25, "pipe": 0.03,
                    "P": 0.15}.items():
        if name in solids and not quick:
            yield Input(name, *solids[name], h)


def used() -> float:
    """Processor time of the programs that were run so far."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


class Runner:
    """Runs programs on one input after another, in a folder of its own."""

    def __init__(self, programs: pathlib.Path, folder: pathlib.Path) -> None:
        self.folder = folder
        self.dynmesh = programs / "dynmesh"
        mesh_3 = programs / "dynmesh_cgal_mesh_3"
        self.mesh_3 = mesh_3 if mesh_3.exists() else None
        self.tetgen = shutil.which("tetgen")

    def run(self, stem: str, *command: object) -> tuple[tetrahedra.Mesh, float]:
        start = used()
        subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)
        seconds = used() - start
        return tetrahedra.read(self.folder / stem, command[0] == self.dynmesh), seconds

    def methods(self, source: pathlib.Path, given: Input
                ) -> Iterator[tuple[str, float, tetrahedra.Mesh, float]]:
        """Name, bound, mesh and seconds of each."""
        edge = 0.0
        for bound in (0, 10, 15):
            mesh, seconds = self.run("out.node", *self.dynmesh_command(source, given, bound))
            edge = edge or mesh.edge_inside()
            yield f"dynmesh, {bound}" if bound else "dynmesh, off", bound, mesh, seconds
        for file in self.folder.glob("out.*"):
            file.unlink()
        if self.tetgen is not None:
            for switches, bound in (("q2", 0), ("q2/10", 10)):
                volume = f"a{given.h ** 3 / 72 ** 0.5:.12f}" if given.h > 0 else ""
                stem = source.with_suffix(".1")
                mesh, seconds = self.run(stem.name + ".node", self.tetgen,
                                         f"-p{switches}{volume}Q", source)
                yield f"TetGen -p{switches}", bound, mesh, seconds
        if self.mesh_3 is not None and source.suffix == ".off":
            mesh, seconds = self.run("mesh_3.node", self.mesh_3, source, edge,
                                     self.folder / "mesh_3")
            yield "Mesh_3, perturbed, exuded", 0, mesh, seconds

    def dynmesh_command(self, source: pathlib.Path, given: Input, bound: float) -> list[object]:
        command: list[object] = [self.dynmesh, "mesh", "--merge-coplanar", source, "-o",
                                 self.folder / "out.node"]
        if given.h > 0:
            command += ["--hmax", given.h]
        return command + ["--min-dihedral", bound]


def report_left(mesh: tetrahedra.Mesh, angles: np.ndarray, bound: float, of: str) -> None:
    for t in np.flatnonzero(angles < bound):
        corners = mesh.points[mesh.cells[t]]
        place = ", ".join(f"{x:.9g}" for x in corners.mean(axis=0))
        edges = [np.linalg.norm(corners[i] - corners[j]) for i in range(4) for j in range(i)]
        print(f"left: {of}: {angles[t]:.4f} degrees at ({place}), "
              f"{'inside' if mesh.inside[t] else 'outside'}, dimensions "
              f"{''.join(map(str, sorted(mesh.dimensions[mesh.cells[t]])))}, "
              f"edges {min(edges):.4g} to {max(edges):.4g}; corners {corners.tolist()}",
              file=sys.stderr, flush=True)


def rows_of(runner: Runner, given: Input) -> Iterator[str]:
    source = given.write(runner.folder / "input")
    name = f"{given.name}, h {given.h:g}" if given.h > 0 else given.name
    before = 0
    for method, bound, mesh, seconds in runner.methods(source, given):
        angles = tetrahedra.least_angles(mesh.points, mesh.cells)
        within = angles[mesh.inside]
        vertices = mesh.vertices_inside()
        ratio, everywhere = "", ""
        if method.startswith("dynmesh"):
            before = before or vertices
            everywhere = f"{len(mesh.points):,}; {(angles < (bound or 10)).sum():,}"
            ratio = f"{vertices / before:.3f}"
            if bound > 0:
                report_left(mesh, angles, bound, f"{name}, {method}")
            if bound == 10 and vertices / before > MOST_RATIO[given.h > 0]:
                print(f"many: {name}, {method}: {ratio}", file=sys.stderr)
        counts = " / ".join(f"{(within < b).sum():,}" for b in BOUNDS)
        row = (f"| {name if method == 'dynmesh, off' else ''} | {method} | {vertices:,} | "
               f"{len(within):,} | {within.min():.2f} | {counts} | {ratio} | {everywhere} | "
               f"{seconds:.2f} |")
        print(f"{name}: {row}", file=sys.stderr, flush=True)
        yield row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="3,000 points, and no max_edge")
    parser.add_argument("--bin", type=pathlib.Path, default="build/release/bin",
                        help="where dynmesh and dynmesh_cgal_mesh_3 are")
    parser.add_argument("--corpus", type=pathlib.Path, help="a folder of OFF files")
    parser.add_argument("--out", type=pathlib.Path, default="RESULTS.md")
    parser.add_argument("--only", help="inputs with names that begin so; writes no section")
    arguments = parser.parse_args()
    rows: list[str] = []
    for given in inputs(arguments.corpus, arguments.quick):
        if arguments.only and not given.name.startswith(arguments.only):
            continue
        with tempfile.TemporaryDirectory() as folder:
            rows += rows_of(Runner(arguments.bin.resolve(), pathlib.Path(folder)), given)
    if not arguments.only:
        put_section(arguments.out, "dihedral_table.py", "\n".join([BEFORE, HEAD, *rows, ""]))


if __name__ == "__main__":
    main()
