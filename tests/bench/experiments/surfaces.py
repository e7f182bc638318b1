#!/usr/bin/python3
"""Everyday solids and surfaces with small angles, by the dynamic mesher and TetGen.

    tests/bench/experiments/surfaces.py [--quick] [--only WORD] [--more FILE...] [--limit SECONDS]

Each mesh is judged by `dynmesh verify`. FILE: surfaces of one's own, in any format that both read.
"""
from __future__ import annotations

import json
import pathlib
import subprocess
import tempfile
from dataclasses import dataclass
from typing import Optional

import inputs
import meshers
import numpy as np
import solids
from output import arguments, markdown, section, write_csv

TEXT = """\
# Everyday solids, and surfaces with small angles

`tests/bench/experiments/surfaces.py` writes this section. The dynamic mesher without a trace and with
`--min-dihedral 0`, at ρ = 2, and TetGen (`-pq2`). Of a closed surface the inside is meshed (`--inside`); others
are meshed in a box of eight times their extent, and vertices of the bare box do not count. Seconds are of
processor time, without files; an empty cell: not ended within {limit:.0f} s. "exempt" counts tetrahedra that an
angle of the input forces over ρ. "judge" is `dynmesh verify` with the input. "merged": with
`--merge-coplanar`, the others with `--keep-facets`; TetGen always joins faces of one plane.
"""
# Surfaces whose triangles have a plane in common with others.
MERGED = ("cylinder 32, triangles", "terrain 10, flat")


@dataclass
class Result:
    seconds: float
    vertices: int
    exempt: int
    verdict: str


def is_closed(surface: solids.Surface) -> bool:
    """Each edge is of an even number of polygons."""
    count: dict[tuple[int, int], int] = {}
    for p in surface.polygons:
        for a, b in zip(p, (*p[1:], p[0])):
            edge = (min(a, b), max(a, b))
            count[edge] = count.get(edge, 0) + 1
    return all(n % 2 == 0 for n in count.values())


def by_dynmesh(program: pathlib.Path, path: pathlib.Path, closed: bool, limit: float,
               folder: pathlib.Path, merged: bool = False) -> Result | str:
    """What was made, or the reason for a refusal."""
    out = folder / "mesh.node"
    flags = ["--min-dihedral", "0", "--merge-coplanar" if merged else "--keep-facets"]
    command = [str(program), "mesh", str(path), *flags, "--inside" if closed else "--surroundings",
               "--max-vertices", "400000", "-o", str(out), "--json"]
    try:
        made = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        return f"over {limit:.0f} s"
    if made.returncode != 0:
        return made.stderr.strip().splitlines()[-1][:120]
    figures = json.loads(made.stdout)
    judged = subprocess.run([program, "verify", out, "--input", path, *flags],
                            capture_output=True, check=False)
    vertices = int(out.read_text(encoding="ascii").split(maxsplit=1)[0])
    return Result(figures["build_seconds"],
                  vertices - (0 if closed else meshers.BOX_VERTICES["dynmesh"]),
                  figures["exempt"], "good" if judged.returncode == 0 else "FAILED")


def by_tetgen(path: pathlib.Path, surface: Optional[solids.Surface], closed: bool, limit: float,
              folder: pathlib.Path) -> Optional[meshers.Run]:
    if closed or surface is None:
        return meshers.tetgen_of_file(path, "-pq2", limit)
    in_cube = folder / "in_cube.poly"
    inputs.write_poly_in_cube(in_cube, np.array(surface.corners, dtype=float), surface.polygons)
    run = meshers.tetgen_of_file(in_cube, "-pq2", limit)
    if run is not None:
        run.vertices -= meshers.BOX_VERTICES["TetGen"]
    return run


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--only", default="", help="surfaces with this in their name")
    parser.add_argument("--more", type=pathlib.Path, nargs="*", default=[])
    parser.add_argument("--limit", type=float, default=40, help="seconds of a run")
    flags = parser.parse_args()
    surfaces: dict[str, Optional[solids.Surface]] = dict(solids.everyday())
    if not flags.quick:
        surfaces |= solids.large() | {path.stem: None for path in flags.more}
    files = {path.stem: path for path in flags.more}
    runs = [(title, surface, False) for title, surface in surfaces.items()]
    runs += [(title, surfaces[title], True) for title in MERGED]
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for title, surface, merged in sorted(runs, key=lambda run: list(surfaces).index(run[0])):
            if flags.only not in title:
                continue
            path = folder / "surface.off" if surface else files[title]
            if surface:
                solids.write_off(path, surface)
            closed = surface is None or is_closed(surface)
            made = by_dynmesh(flags.bin / "dynmesh", path, closed, flags.limit, folder, merged)
            cells = ([f"{made.vertices:,}", f"{made.seconds:.2f}", f"{made.exempt:,}", made.verdict]
                     if isinstance(made, Result) else ["", "", "", made])
            peer = (by_tetgen(path, surface, closed, flags.limit, folder)
                    if meshers.has_tetgen() else None)
            cells += ["", ""] if peer is None else [f"{peer.vertices:,}", f"{peer.seconds:.2f}"]
            polygons = len(surface.polygons) if surface else ""
            rows.append([title + (", merged" if merged else ""), polygons, *cells])
            print(*rows[-1], sep="  ", flush=True)
    head = ["surface", "polygons", "vertices", "seconds", "exempt", "judge", "TetGen: vertices",
            "seconds"]
    write_csv(flags.out / "surfaces.csv", head, rows)
    if not flags.quick and not flags.only:
        section(flags.page, "surfaces.py", TEXT.format(limit=flags.limit) + "\n" + markdown(head, rows))


if __name__ == "__main__":
    main()
