#!/usr/bin/python3
"""What SVR's point location costs (the thesis's sec. 3.1), and its k (Fig. 3.2); SVR in 4D.

    tests/bench/experiments/locations.py [--quick] [--corpus FOLDER]

FOLDER has bunny.node. Without it, generated points alone are meshed.
"""
from __future__ import annotations

import pathlib
import tempfile

import inputs
import programs
from output import arguments, markdown, plot, section, show, write_csv

DEFAULT_K = "0.90"
TEXT = """\
# SVR: where uninserted points are kept

`tests/bench/experiments/locations.py` writes this section. Uninserted points are kept in one of four
structures (the thesis's sec. 3.1): in the circumscribed balls that have them, in the simplices, in the
Voronoi cells, or in these by shells of distance, the default. Points looked at are those of queries and of
updates. In the cluster all but two of the points are in a cube of 2^-30 of the extent (the thesis's
Fig. 3.1). Points are reassigned when they come into another list, once for each list. Predicates are exact
tests of a point in updates: in a ball, or beside a plane; Voronoi cells need none. Circumradius / shortest
edge is at most 2. Vertices are without those of the box's border; they differ because the structure chooses
among points. "Shells after a tree" is the product: a tree of the uninserted points says first whether one may
be near (core/svr/waiting_tree.h). That changes no mesh, and counts no looks. Seconds are of processor time, the least of three runs on a shared machine: trust ratios, not
digits.
"""
TEXT_RATIOS = """
Times as many as with shells:

"""
TEXT_K = """
## How far uninserted points attract a circumcenter

The thesis's Fig. 3.2: a circumcenter moves to an uninserted point that is nearer than k times the
circumradius. Shells; the default is k = 0.9.

![Vertices and seconds by k](deploy/pictures/warp.svg)

"""
TEXT_4D = """
## SVR in 4D

Uniform points, circumradius / shortest edge at most 2, on the exact kernel for any dimension. Each mesh
is checked: neighbours, orientations, and that it is Delaunay.

"""


def for_reading(rows: list[list[str]]) -> list[list[str]]:
    """With commas in counts."""
    return [[f"{int(cell):,}" if cell.isdigit() else cell for cell in row] for row in rows]


def by_default(rows: list[list[str]]) -> dict[str, tuple[list[float], list[float]]]:
    """Vertices and seconds of each input by k, as parts of those at the default k."""
    series: dict[str, tuple[list[float], list[float]]] = {}
    for name in dict.fromkeys(row[0] for row in rows):
        own = [row for row in rows if row[0] == name]
        base = next(row for row in own if row[2] == DEFAULT_K)
        for what, column in (("vertices", 3), ("seconds", 6)):
            series[f"{name}: {what}"] = ([float(row[2]) for row in own],
                                         [float(row[column]) / float(base[column]) for row in own])
    return series


def ratios(rows: list[list[str]], structure: str, column: int) -> str:
    """The figures of a structure by those of shells, over the inputs."""
    shells = {row[0]: float(row[column]) for row in rows if row[2] == "shells"}
    of = [float(row[column]) / shells[row[0]] for row in rows if row[2] == structure]
    least, most = f"{min(of):.1f}", f"{max(of):.1f}"
    return least if least == most else f"{least} to {most}"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--corpus", type=pathlib.Path, help="with bunny.node")
    flags = parser.parse_args()
    program = flags.bin / "dynmesh_location_tables"
    scenes = {"line & circle 2,000": inputs.line_and_circle(2_000)}
    if not flags.quick:
        scenes["uniform 10,000"] = inputs.uniform(10_000)
    if flags.corpus:
        scenes["bunny"] = inputs.read_node(flags.corpus / "bunny.node")
    scenes["cluster 10,000"] = inputs.cluster(10_000)  # for the structures alone
    with tempfile.TemporaryDirectory() as name:
        paths = []
        for scene, points in scenes.items():
            paths.append(str(pathlib.Path(name) / f"{scene}.node"))
            inputs.write_node(pathlib.Path(paths[-1]), points)
        structures = programs.table(program, "structures", *paths)
        warps = programs.table(program, "warp", *paths[:-1])
    in_4d = programs.table(program, "4d", *(["100"] if flags.quick else ["1000", "10000"]))
    write_csv(flags.out / "locations.csv", *structures)
    write_csv(flags.out / "warp.csv", *warps)
    write_csv(flags.out / "svr_4d.csv", *in_4d)
    picture = flags.out / "warp.svg"
    plot(picture, by_default(warps[1]), "k", "part of that at k = 0.9", logarithmic=False)
    if flags.quick:
        return
    show(flags.page, picture)
    rows = structures[1]
    by_shells = [[kind, *(ratios(rows, kind, column) for column in (5, 6, 8))]
                 for kind in ("balls", "simplices", "Voronoi cells")]
    section(flags.page, "locations.py",
            TEXT + "\n" + markdown(structures[0], for_reading(rows)) + TEXT_RATIOS
            + markdown(["structure", "looked at", "reassigned", "seconds"], by_shells) + TEXT_K
            + markdown(warps[0], for_reading(warps[1])) + TEXT_4D
            + markdown(in_4d[0], for_reading(in_4d[1])))


if __name__ == "__main__":
    main()
