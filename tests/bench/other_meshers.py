"""The unit square or cube meshed by Gmsh, TetGen and Triangle: for remesh_table.py.

A mesher is a function of a scene that returns points and cells. TetGen and Triangle are run as
programs, from files to files, as their users do. They have no sizing function: where the scene
wants a finer mesh they refine a first mesh once, by a bound for each cell.
"""
from __future__ import annotations

import math
import pathlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from typing import Optional

import numpy as np

Arrays = tuple[np.ndarray, np.ndarray]  # points, cells


@dataclass(frozen=True)
class Scene:
    """A target length of edges everywhere, and one feature at `at`."""

    dimension: int
    edge: float
    at: tuple[float, ...]
    radius: float  # within which the target is half as long; 0: the feature is a point

    def target(self, x: np.ndarray) -> np.ndarray:
        inside = np.linalg.norm(x - np.array(self.at), axis=1) < self.radius
        return np.where(inside, self.edge / 2, self.edge)


Mesher = Callable[[Scene], Arrays]


def by_gmsh(scene: Scene) -> Arrays:
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{option}", 0)
    if scene.dimension == 2:
        gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    else:
        gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    at = (*scene.at, 0.0)[:3]
    point = gmsh.model.occ.addPoint(*at) if scene.radius == 0 else None
    gmsh.model.occ.synchronize()
    if point is not None:
        gmsh.model.mesh.embed(0, [point], scene.dimension, 1)
    ball = gmsh.model.mesh.field.add("Ball")
    inside = scene.edge if scene.radius == 0 else scene.edge / 2
    for key, value in dict(Radius=scene.radius, Thickness=scene.edge, VIn=inside, VOut=scene.edge,
                           XCenter=at[0], YCenter=at[1], ZCenter=at[2]).items():
        gmsh.model.mesh.field.setNumber(ball, key, value)
    gmsh.model.mesh.field.setAsBackgroundMesh(ball)
    gmsh.model.mesh.generate(scene.dimension)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    _, nodes = gmsh.model.mesh.getElementsByType(2 if scene.dimension == 2 else 4)
    number = np.zeros(int(tags.max()) + 1, int)
    number[tags.astype(int)] = np.arange(len(tags))
    gmsh.finalize()
    cells = number[nodes.astype(int)].reshape(-1, scene.dimension + 1)
    return coordinates.reshape(-1, 3)[:, :scene.dimension].copy(), cells


def _write_border(path: pathlib.Path, scene: Scene) -> None:
    """The square or cube, and the feature if it is a point, as a .poly file."""
    dimension = scene.dimension
    corners = np.array([[i >> k & 1 for k in range(dimension)] for i in range(1 << dimension)])
    points = corners if scene.radius > 0 else np.vstack([corners, scene.at])
    lines = [f"{len(points)} {dimension} 0 0"]
    lines += [f"{i} " + " ".join(repr(float(x)) for x in p) for i, p in enumerate(points)]
    if dimension == 2:
        lines += ["4 0", "0 0 1", "1 1 3", "2 3 2", "3 2 0"]
    else:
        lines.append("6 0")
        for axis in range(3):
            first, second = (1 << k for k in range(3) if k != axis)
            for side in (0, 1 << axis):
                lines += ["1 0", f"4 {side} {side + first} {side + first + second} {side + second}"]
    path.write_text("\n".join([*lines, "0", ""]), encoding="ascii")


def _read(stem: pathlib.Path) -> Arrays:
    def rows(suffix: str) -> np.ndarray:
        with open(f"{stem}.{suffix}", encoding="ascii") as file:
            count = int(file.readline().split()[0])
            return np.loadtxt(file, max_rows=count, comments="#", ndmin=2)

    nodes, elements = rows("node"), rows("ele")
    dimension = 2 if elements.shape[1] < 5 else 3
    return nodes[:, 1:1 + dimension].copy(), elements[:, 1:2 + dimension].astype(int)


def program_mesher(program: str) -> Mesher:
    """TetGen or Triangle: `-pq`, with bounds on areas or volumes."""
    def mesh(scene: Scene) -> Arrays:
        with tempfile.TemporaryDirectory() as folder:
            stem = pathlib.Path(folder) / "scene"

            def run(switches: str, part: int) -> Arrays:
                source = f"{stem}.poly" if part == 0 else f"{stem}.{part}"
                subprocess.run([program, switches, source], check=True, stdout=subprocess.DEVNULL)
                return _read(pathlib.Path(f"{stem}.{part + 1}"))

            # Of a triangle, or tetrahedron, with edges of the target length.
            share = math.sqrt(3) / 4 if scene.dimension == 2 else 1 / (6 * math.sqrt(2))
            quality = "q" if scene.dimension == 2 else "q2"
            bound = share * scene.edge ** scene.dimension
            _write_border(pathlib.Path(f"{stem}.poly"), scene)
            points, cells = run(f"-p{quality}a{bound:.12f}Q", 0)
            if scene.radius > 0:
                middles = points[cells].mean(axis=1)
                bounds = share * scene.target(middles) ** scene.dimension
                suffix = "area" if scene.dimension == 2 else "vol"
                np.savetxt(f"{stem}.1.{suffix}",
                           np.column_stack([np.arange(len(cells)), bounds]), fmt=("%d", "%.17g"),
                           header=str(len(cells)), comments="")
                points, cells = run(f"-rp{quality}aQ" if scene.dimension == 2
                                    else f"-r{quality}aQ", 1)
            return points, cells

    return mesh


def installed(triangle: Optional[str]) -> dict[int, dict[str, Mesher]]:
    """By dimension, the meshers that are here; `triangle` is Triangle's program or None."""
    found: dict[int, dict[str, Mesher]] = {2: {}, 3: {}}
    try:
        import gmsh  # noqa: F401

        found[2]["Gmsh"] = found[3]["Gmsh"] = by_gmsh
    except ImportError:
        pass
    if triangle is not None:
        found[2]["Triangle"] = program_mesher(triangle)
    tetgen = shutil.which("tetgen")
    if tetgen is not None:
        found[3]["TetGen"] = program_mesher(tetgen)
    return found
