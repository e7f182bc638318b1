"""Combinations of switches: what Triangle and TetGen make of them, and what dynmesh does.

    python3 compat_table.py >docs/compat_table.md     with `triangle` and `tetgen` in the PATH

Everything is computed from the meshes' arrays, by the checks beside this file. A program that is not
there has empty columns.
"""
import dataclasses
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import numpy as np

import compat_checks as checks
import dynmesh.compat.triangle as tr
from compat_inputs import AREAS, NESTED, TOWER
from dynmesh import DynmeshError
from dynmesh.compat.meshpy.tet import MeshInfo, Options, build

PLANAR = [
    *(("box", switches) for switches in (
        "p", "pc", "pe", "pn", "pj", "pD", "pq", "pq0", "pq10", "pq20", "pq25", "pq30", "pq33",
        "pa0.1", "pqa0.1", "pqa0.01", "pq30a0.02", "pqY", "pqo2", "pqen", "pqS200", "pqQz",
        "pqi", "pqF", "pqC")),
    *(("ell", switches) for switches in ("p", "pq", "pq30", "pqa0.01")),
    *(("halves", switches) for switches in (
        "pA", "pqA", "pqa", "pqaA", "pq30aA", "pqa0.05A", "pqYY")),
    *(("face", switches) for switches in ("p", "pq", "pq30", "pqa0.01"))]
SOLID = [
    *(("tower", switches) for switches in (
        "p", "pq", "pq2", "pq1.5", "pq1.4", "pq1.2", "pq2/10", "pq1.5/15", "pqa0.1", "pq1.5a0.02",
        "pqY", "pqn", "pqS300", "pqQz")),
    *(("nested", switches) for switches in ("pq", "pqA", "pqa0.1", "pqaA", "pq1.4/10aA", "pqAn"))]
BODIES = {"tower": (TOWER, 48.0), "nested": (NESTED, 27.0)}
# Seed, attribute, largest volume: of the regions of `nested`.
SEEDS = [(0.5, 0.5, 0.5, 3, 0.5), (1.5, 1.5, 1.5, 7, 0.05)]


class Failed(Exception):
    """Triangle or TetGen makes no mesh."""


@dataclasses.dataclass
class Mesh:
    """Cells, and if they were asked for neighbours, attributes of cells; pieces are segments or facets
    of the border with the markers of input."""
    points: np.ndarray
    cells: np.ndarray
    neighbours: np.ndarray = None
    attributes: np.ndarray = None
    pieces: np.ndarray = None
    markers: np.ndarray = None


def number_after(switch, switches):
    found = re.search(switch + r"(\d[\d.]*)", switches)
    return float(found[1]) if found else None


def markers_of_segments(tri):
    return tri.get("segment_markers", range(1, len(tri["segments"]) + 1))


# --- what is measured -----------------------------------------------------------------------------

def exceeded(mesh, switches, seeds, sizes, dimension):
    """True if a cell is larger than asked: than all may be, or than its region's may."""
    largest = number_after("a", switches)
    if largest is not None:
        return sizes.max() > largest * (1 + 1e-9)
    if "a" not in switches or not seeds:
        return False
    centres = mesh.points[mesh.cells[:, :dimension + 1]].mean(axis=1)
    return any((sizes[where(centres)] > seed[-1] * (1 + 1e-9)).any()
               for where, seed in zip(REGIONS[dimension], seeds))


def in_inner(places):
    return ((places > 1) & (places < 2)).all(axis=1)


# Which cells are in the region of each seed: of `halves` and `nested`.
REGIONS = {2: (lambda places: places[:, 0] < 1, lambda places: places[:, 0] > 1),
           3: (lambda places: ~in_inner(places), in_inner)}


def false_markers(mesh, lines):
    """Whether a segment is no chain of edges with its marker."""
    for a, b, marker in lines:
        at, covered = checks.parts_of(mesh.points, mesh.pieces.tolist(), a, b)
        rows = {frozenset(pair) for pair in at}
        marks = {int(mark) for pair, mark in zip(mesh.pieces.tolist(), mesh.markers)
                 if frozenset(pair) in rows}
        if abs(covered - np.linalg.norm(np.subtract(a, b))) > 1e-9 or marks != {marker}:
            return True
    return False


def false_faces(mesh, body):
    """Whether the faces of a marker do not cover the facet of that number."""
    for number, facet in enumerate(body[1], 1):
        corners = mesh.points[mesh.pieces[mesh.markers == number]]
        a, b, _, d = (np.asarray(body[0][i], float) for i in facet)
        normal = np.cross(b - a, d - a)
        area = np.linalg.norm(normal)
        covered = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0],
                                          corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
        if abs((corners - a) @ normal).max(initial=0) > 1e-9 or abs(covered - area) > 1e-9 * area:
            return True
    return False


def overlaps(points, cells):
    """Whether a cell is there twice or turned over, or a face has more than two cells."""
    sizes = checks.measures(points, cells)
    rows = np.sort(cells, axis=1)
    faces = np.concatenate([np.delete(rows, i, axis=1) for i in range(rows.shape[1])])
    return bool((sizes.min() < 0 < sizes.max()) or len(np.unique(rows, axis=0)) < len(rows)
                or np.unique(faces, axis=0, return_counts=True)[1].max() > 2)


def faults(mesh, name, switches):
    """What of the promises does not hold, in words; and the measures of the row."""
    dimension = mesh.points.shape[1]
    cells = mesh.cells[:, :dimension + 1]
    sizes = np.abs(checks.measures(mesh.points, cells))
    found = []
    if dimension == 2:
        tri, size = AREAS[name]
        seeds = tri.get("regions", [])
        least = checks.angles(mesh.points, cells).min()
        bound = number_after("q", switches)
        shape = f"{least:.1f}"
        if ("q" in switches and least < (20 if bound is None else bound) - 1e-9
                and "Y" not in switches):
            found.append("angle")
        if mesh.pieces is not None and false_markers(mesh, [
                (tri["vertices"][a], tri["vertices"][b], int(marker)) for (a, b), marker in
                zip(tri["segments"], markers_of_segments(tri))]):
            found.append("markers")
    else:
        body, size = BODIES[name]
        seeds = SEEDS if name == "nested" else []
        ratio = checks.radius_edge(mesh.points, cells).max()
        least = checks.dihedral_angles(mesh.points, cells).min()
        shape = f"{ratio:.2f}/{least:.0f}"
        if "q" in switches and ratio > (number_after("q", switches) or 2) * (1 + 1e-9):
            found.append("ratio")
        asked = number_after("/", switches)
        if asked is not None and least < asked - 1e-6:
            found.append("angle")
        if mesh.pieces is not None and false_faces(mesh, body):
            found.append("markers")
    if abs(sizes.sum() - size) > 1e-9 * size or overlaps(mesh.points, cells):
        found.append("domain")
    if exceeded(mesh, switches, seeds, sizes, dimension):
        found.append("size")
    if mesh.neighbours is not None and (mesh.neighbours != checks.neighbours(cells)).any():
        found.append("neighbours")
    if mesh.attributes is not None and seeds:
        centres = mesh.points[cells].mean(axis=1)
        if any((mesh.attributes[where(centres)] != seed[-2]).any()
               for where, seed in zip(REGIONS[dimension], seeds)):
            found.append("attributes")
    return found, shape, f"{sizes.max():.2g}"


# --- dynmesh --------------------------------------------------------------------------------------

def planar(name, switches):
    tri = dict(AREAS[name][0])
    tri["segment_markers"] = list(markers_of_segments(tri))
    made = tr.triangulate(tri, switches)
    get = made.get
    markers = get("segment_markers")
    return Mesh(made["vertices"], made["triangles"], get("neighbors"),
                np.ravel(get("triangle_attributes")) if "A" in switches else None,
                get("segments"), None if markers is None else np.ravel(markers))


def solid(name, switches):
    body = BODIES[name][0]
    info = MeshInfo()
    info.set_points(body[0])
    info.set_facets(body[1], list(range(1, len(body[1]) + 1)))
    if name == "nested":
        info.regions.resize(len(SEEDS))
        for i, seed in enumerate(SEEDS):
            info.regions[i] = list(seed)
    made = build(info, Options(switches))
    neighbours = np.array(made.neighbors) if "n" in switches else None
    return Mesh(np.array(made.points), np.array(made.elements), neighbours,
                np.ravel(np.array(made.element_attributes)) if "A" in switches else None,
                np.array(made.faces), np.ravel(np.array(made.face_markers)))


def ours(name, switches):
    try:
        return planar(name, switches) if name in AREAS else solid(name, switches)
    except DynmeshError as refusal:
        return refusal


# --- Triangle and TetGen --------------------------------------------------------------------------

def rows(path):
    lines = [line.split("#")[0].split() for line in path.read_text().splitlines()]
    return [line for line in lines if line]


def table(path, header=0):
    """The rows behind a header without their numbers, and the first number."""
    lines = rows(path)[header:]
    data = np.array(lines[1:1 + int(lines[0][0])], float)
    return data[:, 1:], int(data[0, 0])


def poly_of(name):
    if name in AREAS:
        tri = AREAS[name][0]
        text = [f"{len(tri['vertices'])} 2 0 0"]
        text += [f"{i} {x!r} {y!r}" for i, (x, y) in enumerate(np.array(tri["vertices"], float).tolist())]
        text += [f"{len(tri['segments'])} 1"]
        text += [f"{i} {a} {b} {marker}" for i, ((a, b), marker) in
                 enumerate(zip(tri["segments"], markers_of_segments(tri)))]
        holes, seeds = tri.get("holes", []), tri.get("regions", [])
    else:
        points, facets = BODIES[name][0]
        text = [f"{len(points)} 3 0 0"] + [f"{i} {x} {y} {z}" for i, (x, y, z) in enumerate(points)]
        text += [f"{len(facets)} 1"]
        for marker, facet in enumerate(facets, 1):
            text += [f"1 0 {marker}", f"{len(facet)} {' '.join(map(str, facet))}"]
        holes, seeds = [], SEEDS if name == "nested" else []
    for places in (holes, seeds):
        text += [str(len(places))] + [f"{i} {' '.join(map(str, p))}" for i, p in enumerate(places)]
    return "\n".join(text) + "\n"


def theirs(program, name, switches):
    with tempfile.TemporaryDirectory() as where:
        folder = pathlib.Path(where)
        (folder / "in.poly").write_text(poly_of(name))
        said = subprocess.run([program, "-" + switches, "in.poly"], cwd=folder, timeout=60,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if said.returncode != 0 or not (folder / "in.1.ele").exists():
            return Failed(said.stdout)
        dimension = 2 if name in AREAS else 3
        nodes, first = table(folder / "in.1.node")
        elements, _ = table(folder / "in.1.ele")
        attributes = 1 if "A" in switches else 0
        corners = elements.shape[1] - attributes
        mesh = Mesh(nodes[:, :dimension], elements[:, :corners].astype(int) - first)
        if attributes:
            mesh.attributes = elements[:, corners]
        if "n" in switches and (folder / "in.1.neigh").exists():
            neighbours = table(folder / "in.1.neigh")[0].astype(int)
            mesh.neighbours = np.where(neighbours < 0, -1, neighbours - first)
        if dimension == 2:
            pieces, _ = table(folder / "in.1.poly", header=1)  # behind that of no vertices
        else:
            pieces, _ = table(folder / "in.1.face")
        mesh.pieces, mesh.markers = pieces[:, :-1].astype(int)[:, :dimension] - first, pieces[:, -1]
        return mesh


# --- the table ------------------------------------------------------------------------------------

def cells_of(found, name, switches):
    """Vertices, cells, shape, largest cell, verdict."""
    if found is None:
        return ["", "", "", "", ""]
    if isinstance(found, Exception):
        return ["–", "–", "–", "–", "an error"]
    wrong, shape, largest = faults(found, name, switches)
    return [f"{len(found.points):,}", f"{len(found.cells):,}", shape, largest,
            f"not {', '.join(wrong)}" if wrong else "holds"]


def print_table(title, shape, program, cases):
    print(f"\n## {title}\n")
    print(f"| input | switches | vertices | | {'triangles' if program == 'triangle' else 'tetrahedra'} | "
          f"| {shape} | | largest | | all that is asked | |")
    print("|" + "---|" * 12)
    there = shutil.which(program)
    for name, switches in cases:
        row = zip(cells_of(theirs(there, name, switches) if there else None, name, switches),
                  cells_of(ours(name, switches), name, switches))
        print(f"| {name} | `{switches}` | " + " | ".join(f"{a} | {b}" for a, b in row) + " |")


if __name__ == "__main__":
    sys.stdout.write("""# Sixty combinations of switches

This document answers: what do Triangle and TetGen make of these switches, and what does `dynmesh.compat`?
Left in each pair of columns is the program, right dynmesh. `tests/client/python/compat_table.py` prints it and
computes all from the arrays; a test checks the right side. The inputs are in `compat_inputs.py`.

The last columns: the domain's area or volume, angles or ratios, sizes (also of regions), segments or facets with
their markers, neighbours, attributes of regions, as far as the switches ask for them. What does not hold is
named. [What differs](compat.md) has the reasons of the errors, whose messages name the switch or the place.
Triangle 1.6, TetGen 1.5.0.
""")
    print_table("Triangle", "least angle", "triangle", PLANAR)
    print_table("TetGen", "ratio / least dihedral angle", "tetgen", SOLID)
