"""Inputs as Gmsh's .geo, and its meshes as arrays: for everyday.py."""
from __future__ import annotations

import pathlib
from typing import Optional

import numpy as np


def _lines(path: pathlib.Path) -> list[list[str]]:
    rows = (line.split("#")[0].split() for line in path.read_text(encoding="ascii").splitlines())
    return [row for row in rows if row]


def _read_poly(path: pathlib.Path) -> tuple[np.ndarray, np.ndarray]:
    """Points and segments."""
    rows = _lines(path)
    count = int(rows[0][0])
    first = int(rows[1][0])
    points = np.array([[float(x) for x in row[1:3]] for row in rows[1:1 + count]])
    segments = int(rows[1 + count][0])
    ends = [[int(x) - first for x in row[1:3]] for row in rows[2 + count:2 + count + segments]]
    return points, np.array(ends)


def _read_off(path: pathlib.Path) -> tuple[np.ndarray, list[list[int]]]:
    """Points and polygons."""
    words = [word for row in _lines(path) for word in row][1:]
    count, polygons = int(words[0]), int(words[1])
    points = np.array([float(x) for x in words[3:3 + 3 * count]]).reshape(-1, 3)
    at, rings = 3 + 3 * count, []
    for _ in range(polygons):
        corners = int(words[at])
        rings.append([int(x) for x in words[at + 1:at + 1 + corners]])
        at += 1 + corners
    return points, rings


def points_of(path: pathlib.Path) -> np.ndarray:
    return (_read_off if path.suffix == ".off" else _read_poly)(path)[0]


def _loops(count: int, segments: np.ndarray) -> Optional[list[list[int]]]:
    """The loops that the segments are; None if they are not disjoint loops."""
    neighbours: list[list[int]] = [[] for _ in range(count)]
    for a, b in segments.tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    if any(len(n) not in (0, 2) for n in neighbours):
        return None
    loops, seen = [], [not n for n in neighbours]
    for start in range(count):
        if seen[start]:
            continue
        loop, last, at = [], -1, start
        while not seen[at]:
            seen[at] = True
            loop.append(at)
            a, b = neighbours[at]
            last, at = at, (b if a == last else a)
        loops.append(loop)
    return loops


def _contains(ring: np.ndarray, p: np.ndarray) -> bool:
    a, b = ring, np.roll(ring, -1, axis=0)
    over = (a[:, 1] > p[1]) != (b[:, 1] > p[1])
    a, b = a[over], b[over]
    x = a[:, 0] + (p[1] - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return bool((x > p[0]).sum() % 2)


def _head(points: np.ndarray, edge: Optional[float]) -> list[str]:
    """Gmsh's options, and the points. Without a length, each segment is one edge or few, and the
    lengths inside are those of the border."""
    rows = ["Mesh.CharacteristicLengthFromPoints = 0;"]
    if edge is not None:
        rows += [f"Mesh.CharacteristicLengthMax = {edge!r};"]
    else:
        rows += ["Mesh.CharacteristicLengthMax = 1e22;"]
    padded = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    rows += [f"Point({i + 1}) = {{{x!r}, {y!r}, {z!r}}};"
             for i, (x, y, z) in enumerate(padded.tolist())]
    return rows


def of_poly(path: pathlib.Path, edge: Optional[float]) -> Optional[str]:
    """Loops, each with those in it: also the insides of inner ones are meshed. None if the segments
    are not disjoint loops."""
    points, segments = _read_poly(path)
    loops = _loops(len(points), segments)
    if loops is None:
        return None
    rings = [points[loop] for loop in loops]
    low = np.array([ring.min(axis=0) for ring in rings])
    high = np.array([ring.max(axis=0) for ring in rings])
    area = np.prod(high - low, axis=1)
    children: list[list[int]] = [[] for _ in loops]
    for i, ring in enumerate(rings):
        around = np.flatnonzero((low < low[i]).all(axis=1) & (high > high[i]).all(axis=1))
        around = [j for j in around if _contains(rings[j], ring[0])]
        if around:
            children[min(around, key=lambda j: area[j])].append(i)
    rows, line = _head(points, edge), 0
    for i, loop in enumerate(loops):
        names = []
        for a, b in zip(loop, loop[1:] + loop[:1]):
            line += 1
            rows.append(f"Line({line}) = {{{a + 1}, {b + 1}}};")
            names.append(str(line))
        rows.append(f"Curve Loop({i + 1}) = {{{', '.join(names)}}};")
    for i, inner in enumerate(children):
        rows.append(f"Plane Surface({i + 1}) = {{{', '.join(str(k + 1) for k in [i, *inner])}}};")
    return "\n".join([*rows, ""])


def of_off(path: pathlib.Path, edge: Optional[float]) -> str:
    """A surface of planar polygons, or several: the others lie in the largest one."""
    points, rings = _read_off(path)
    rows, lines = _head(points, edge), {}
    part = list(range(len(points)))

    def root(v: int) -> int:
        while part[v] != v:
            part[v] = part[part[v]]
            v = part[v]
        return v

    for i, ring in enumerate(rings):
        names = []
        for a, b in zip(ring, ring[1:] + ring[:1]):
            key = (min(a, b), max(a, b))
            if key not in lines:
                lines[key] = len(lines) + 1
                rows.append(f"Line({lines[key]}) = {{{key[0] + 1}, {key[1] + 1}}};")
            names.append(str(lines[key] if a < b else -lines[key]))
            part[root(a)] = root(b)
        rows.append(f"Curve Loop({i + 1}) = {{{', '.join(names)}}};")
        rows.append(f"Plane Surface({i + 1}) = {{{i + 1}}};")
    bodies: dict[int, list[int]] = {}
    for i, ring in enumerate(rings):
        bodies.setdefault(root(ring[0]), []).append(i + 1)
    extents = {body: float(np.ptp(points[[v for i in sides for v in rings[i - 1]]], axis=0).max())
               for body, sides in bodies.items()}
    order = sorted(bodies, key=lambda body: -extents[body])
    for k, body in enumerate(order):
        rows.append(f"Surface Loop({k + 1}) = {{{', '.join(map(str, bodies[body]))}}};")
    every = ", ".join(str(k + 1) for k in range(len(order)))
    rows.append(f"Volume(1) = {{{every}}};")
    rows += [f"Volume({k + 1}) = {{{k + 1}}};" for k in range(1, len(order))]
    return "\n".join([*rows, ""])


def read_msh(path: pathlib.Path, dimension: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and cells of a .msh of version 2.2."""
    rows = _lines(path)
    at = rows.index(["$Nodes"])
    count = int(rows[at + 1][0])
    nodes = rows[at + 2:at + 2 + count]
    number = {row[0]: i for i, row in enumerate(nodes)}
    points = np.array([[float(x) for x in row[1:1 + dimension]] for row in nodes])
    at = rows.index(["$Elements"])
    kind = "2" if dimension == 2 else "4"
    cells = [[number[v] for v in row[3 + int(row[2]):]]
             for row in rows[at + 2:at + 2 + int(rows[at + 1][0])] if row[1] == kind]
    return points, np.array(cells)
