"""Programs that mesh points in 3D: dynmesh with both engines, and TetGen if it is installed."""
from __future__ import annotations

import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from typing import Optional

import numpy as np

import inputs

BOX_VERTICES = {"dynmesh": 386, "TetGen": 8}  # of the domain's border: not counted


@dataclass
class Run:
    """A mesh made: seconds of processor time and peak memory of the program, vertices without those
    of the box's border."""

    seconds: float
    vertices: int
    tetrahedra: int
    megabytes: float


def _limited(seconds: float) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 1))


def timed(command: list[str], limit: float) -> Optional[tuple[float, float, str]]:
    """Processor seconds, peak megabytes and output; None if it took longer than `limit`."""
    with tempfile.TemporaryFile("w+") as out:
        process = subprocess.Popen(["/usr/bin/env", "LC_ALL=C", *command], stdout=out,
                                   stderr=subprocess.DEVNULL,
                                   preexec_fn=lambda: _limited(limit))
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = status
        if status != 0:
            return None
        out.seek(0)
        return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, out.read()


def read_rows(path: pathlib.Path | str) -> np.ndarray:
    """The rows of a file whose first line begins with their number."""
    with open(path, encoding="ascii") as file:
        count = int(file.readline().split()[0])
        return np.loadtxt(file, max_rows=count, comments="#", ndmin=2)


def dynmesh(program: pathlib.Path, engine: str, points: np.ndarray, limit: float) -> Optional[Run]:
    """Reads a file, makes the mesh, and writes none."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "points.node"
        inputs.write_node(path, points)
        run = dynmesh_of_file(program, path, ["--engine", engine, "--min-dihedral", "0"], limit)
    if run is not None and points.shape[1] == 3:
        run.vertices -= BOX_VERTICES["dynmesh"]
    return run


def dynmesh_of_file(program: pathlib.Path, path: pathlib.Path, flags: list[str],
                    limit: float) -> Optional[Run]:
    """All vertices count."""
    measured = timed([str(program), "mesh", str(path), "--surroundings", *flags, "--json"], limit)
    if measured is None:
        return None
    figures = json.loads(measured[2])
    return Run(figures["build_seconds"], figures["vertices"], figures["simplices"], measured[1])


def tetgen(points: np.ndarray, limit: float) -> Optional[Run]:
    """-pq2 in a cube as large as dynmesh's domain."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "points.poly"
        inputs.write_poly_in_cube(path, points)
        run = tetgen_of_file(path, "-pq2", limit)
    if run is not None:
        run.vertices -= BOX_VERTICES["TetGen"]
    return run


def tetgen_of_file(path: pathlib.Path, flags: str, limit: float) -> Optional[Run]:
    """Without files of the result; its own count of seconds. All vertices count."""
    measured = timed(["tetgen", f"{flags}NEF", str(path)], limit)
    if measured is None:
        return None

    def number(pattern: str) -> float:
        return float(re.findall(pattern, measured[2])[-1])

    return Run(number(r"Total running seconds:\s*([\d.e+-]+)"),
               int(number(r"Mesh points:\s*(\d+)")),
               int(number(r"Mesh tetrahedra:\s*(\d+)")), measured[1])


def has_tetgen() -> bool:
    return shutil.which("tetgen") is not None
