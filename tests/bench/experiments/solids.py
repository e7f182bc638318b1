"""Everyday shapes as surfaces: corners, and polygons by the corners' numbers."""
from __future__ import annotations

import math
import pathlib
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

Corner = tuple[float, float, float]


@dataclass
class Surface:
    corners: list[Corner] = field(default_factory=list)
    polygons: list[tuple[int, ...]] = field(default_factory=list)


def write_off(path: pathlib.Path, surface: Surface) -> None:
    rows = ["OFF", f"{len(surface.corners)} {len(surface.polygons)} 0"]
    rows += [" ".join(map(repr, map(float, corner))) for corner in surface.corners]
    rows += [" ".join(map(str, (len(polygon), *polygon))) for polygon in surface.polygons]
    path.write_text("\n".join(rows) + "\n", encoding="ascii")


def triangulated(surface: Surface) -> Surface:
    """Each polygon as a fan of triangles; right for convex ones."""
    triangles = [(p[0], p[i], p[i + 1])
                 for p in surface.polygons for i in range(1, len(p) - 1)]
    return Surface(surface.corners, triangles)


def joined(*parts: Surface) -> Surface:
    """The parts in one surface; corners at the same place become one, and so do equal polygons."""
    numbers: dict[Corner, int] = {}
    polygons: dict[tuple[int, ...], tuple[int, ...]] = {}
    for part in parts:
        of = [numbers.setdefault(corner, len(numbers)) for corner in part.corners]
        for polygon in part.polygons:
            renumbered = tuple(of[i] for i in polygon)
            polygons.setdefault(tuple(sorted(renumbered)), renumbered)
    return Surface(list(numbers), list(polygons.values()))


def extruded(outline: Sequence[tuple[float, float]], height: float) -> Surface:
    n = len(outline)
    corners = [(x, y, z) for z in (0.0, height) for x, y in outline]
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return Surface(corners, [tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides])


def regular(n: int, radius: float = 1.0) -> list[tuple[float, float]]:
    return [(radius * math.cos(2 * math.pi * i / n), radius * math.sin(2 * math.pi * i / n))
            for i in range(n)]


def box(lo: Corner = (0, 0, 0), hi: Corner = (1, 1, 1)) -> Surface:
    (a, b, c), (x, y, z) = lo, hi
    flat = extruded([(a, b), (x, b), (x, y), (a, y)], z - c)
    return Surface([(p, q, r + c) for p, q, r in flat.corners], flat.polygons)


def cone(outline: Sequence[tuple[float, float]], height: float) -> Surface:
    """Its tip is over the origin."""
    n = len(outline)
    corners = [(x, y, 0.0) for x, y in outline] + [(0.0, 0.0, height)]
    return Surface(corners, [tuple(range(n))[::-1], *((i, (i + 1) % n, n) for i in range(n))])


def fan(sheets: int, degrees: float) -> Surface:
    """Squares with a common edge; the first and the last are (sheets - 1) * degrees apart."""
    corners: list[Corner] = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    polygons: list[tuple[int, ...]] = []
    for i in range(sheets):
        at = math.radians(degrees * i)
        x, y = math.cos(at), math.sin(at)
        n = len(corners)
        corners += [(x, y, 1.0), (x, y, 0.0)]
        polygons.append((0, 1, n, n + 1))
    return Surface(corners, polygons)


def wedge(degrees: float) -> Surface:
    half = math.radians(degrees) / 2
    x, y = math.cos(half), math.sin(half)
    return extruded([(0.0, 0.0), (x, -y), (x, y)], 1.0)


def revolved(profile: Sequence[tuple[float, float]], n: int) -> Surface:
    """A profile of (radius, height), turned about the z axis in n steps; radius 0 at both ends."""
    inner = profile[1:-1]
    corners: list[Corner] = [(0.0, 0.0, profile[0][1])]
    for radius, z in inner:
        corners += [(x, y, z) for x, y in regular(n, radius)]
    corners.append((0.0, 0.0, profile[-1][1]))
    last = len(corners) - 1
    polygons: list[tuple[int, ...]] = []
    for i in range(n):
        j = (i + 1) % n
        polygons.append((0, 1 + j, 1 + i))
        for k in range(len(inner) - 1):
            a, b = 1 + k * n, 1 + (k + 1) * n
            polygons += [(a + i, a + j, b + j), (a + i, b + j, b + i)]
        top = last - n
        polygons.append((last, top + i, top + j))
    return Surface(corners, polygons)


def sphere(n: int, rings: int) -> Surface:
    angles = [math.pi * k / rings - math.pi / 2 for k in range(rings + 1)]
    return revolved([(math.cos(a), math.sin(a)) for a in angles], n)


def torus(n: int, m: int, radius: float = 1.0, tube: float = 0.4) -> Surface:
    corners: list[Corner] = []
    for i in range(n):
        for j in range(m):
            u, v = 2 * math.pi * i / n, 2 * math.pi * j / m
            r = radius + tube * math.cos(v)
            corners.append((r * math.cos(u), r * math.sin(u), tube * math.sin(v)))

    def at(i: int, j: int) -> int:
        return i % n * m + j % m

    polygons: list[tuple[int, ...]] = []
    for i in range(n):
        for j in range(m):
            polygons += [(at(i, j), at(i + 1, j), at(i + 1, j + 1)),
                         (at(i, j), at(i + 1, j + 1), at(i, j + 1))]
    return Surface(corners, polygons)


def icosphere(halvings: int) -> Surface:
    phi = (1 + math.sqrt(5)) / 2
    points = [np.array(p, dtype=float) for p in (
        (-1, phi, 0), (1, phi, 0), (-1, -phi, 0), (1, -phi, 0), (0, -1, phi), (0, 1, phi),
        (0, -1, -phi), (0, 1, -phi), (phi, 0, -1), (phi, 0, 1), (-phi, 0, -1), (-phi, 0, 1))]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
                 (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8),
                 (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(halvings):
        middles: dict[tuple[int, int], int] = {}

        def middle(a: int, b: int) -> int:
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(points)
                points.append((points[a] + points[b]) / 2)
            return middles[key]

        finer: list[tuple[int, int, int]] = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
        points = [p / np.linalg.norm(p) for p in points]
    corners = [tuple(map(float, p / np.linalg.norm(p))) for p in points]
    return Surface(corners, list(triangles))


def terrain(side: int, height: float, seed: int = 1) -> Surface:
    """2 (side - 1)^2 triangles over a unit square."""
    random = np.random.default_rng(seed)
    phases = random.random((8, 4))
    step = 1 / (side - 1)
    corners: list[Corner] = []
    for i in range(side):
        for j in range(side):
            x, y = i * step, j * step
            z = sum(math.sin(2 * math.pi * (3 * a * x + 3 * b * y + c)) * d
                    for a, b, c, d in phases)
            corners.append((x, y, height * z / 8))
    polygons: list[tuple[int, ...]] = []
    for i in range(side - 1):
        for j in range(side - 1):
            a, b = i * side + j, (i + 1) * side + j
            polygons += [(a, b, b + 1), (a, b + 1, a + 1)]
    return Surface(corners, polygons)


def gear(teeth: int) -> Surface:
    outline: list[tuple[float, float]] = []
    for i in range(4 * teeth):
        at = 2 * math.pi * i / (4 * teeth)
        radius = 1.0 if i % 4 in (1, 2) else 0.8
        outline.append((radius * math.cos(at), radius * math.sin(at)))
    return extruded(outline, 0.4)


def house(roof: float) -> Surface:
    """A box with a gabled roof of that height over a width of 1."""
    outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.0 + roof), (0.0, 1.0)]
    return extruded(outline, 1.5)


def stairs(steps: int) -> Surface:
    outline: list[tuple[float, float]] = [(0.0, 0.0), (float(steps), 0.0)]
    for i in range(steps, 0, -1):
        outline += [(float(i), float(i)), (float(i - 1), float(i))]
    return extruded(outline[:-1], float(steps) / 2)


def moebius(n: int) -> Surface:
    """A strip of triangles; it has one side."""
    corners: list[Corner] = []
    for i in range(n):
        for side in (-0.3, 0.3):
            u = 2 * math.pi * i / n
            r = 1 + side * math.cos(u / 2)
            corners.append((r * math.cos(u), r * math.sin(u), side * math.sin(u / 2)))
    polygons: list[tuple[int, ...]] = []
    for i in range(n):
        a, b = 2 * i, 2 * i + 1
        c, d = (2 * i + 2, 2 * i + 3) if i + 1 < n else (1, 0)
        polygons += [(a, c, d), (a, d, b)]
    return Surface(corners, polygons)


def everyday() -> dict[str, Surface]:
    """What CAD programs make every day, and surfaces with small angles."""
    shapes = {f"cylinder {n}": extruded(regular(n), 1.0) for n in (3, 4, 6, 8, 12, 32, 100)}
    shapes["cylinder 32, triangles"] = triangulated(extruded(regular(32), 1.0))
    shapes["disc 100"] = extruded(regular(100), 0.02)
    shapes["rod 100"] = extruded(regular(100), 20.0)
    square = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    for height in (0.5, 1.0, 2.0):
        shapes[f"pyramid {height}"] = cone(square, height)
    for n in (6, 16, 32):
        shapes[f"cone {n}"] = cone(regular(n), 1.0)
    shapes["cone 8, steep"] = cone(regular(8), 3.0)
    shapes["cone 16, flat"] = cone(regular(16), 0.2)
    shapes["tetrahedron"] = cone(regular(3), math.sqrt(2))
    for halvings in range(4):
        shapes[f"icosphere {halvings}"] = icosphere(halvings)
    for n, rings in ((6, 4), (8, 5), (16, 8), (40, 20)):
        shapes[f"sphere {n} x {rings}"] = sphere(n, rings)
    shapes["torus 16 x 8"] = torus(16, 8)
    shapes["torus 40 x 20"] = torus(40, 20)
    for teeth in (12, 40):
        shapes[f"gear {teeth}"] = gear(teeth)
    for degrees in (120, 90, 75, 60, 45, 30, 20, 15, 10, 5, 2, 1):
        shapes[f"wedge {degrees}"] = wedge(degrees)
    for roof in (0.2, 0.5, 1.0):
        shapes[f"house, roof {roof}"] = house(roof)
    shapes["box"] = box()
    shapes["slab 0.01"] = box(hi=(1, 1, 0.01))
    shapes["beam 0.01"] = box(hi=(1, 0.01, 0.01))
    shapes["boxes at a face"] = joined(box(), box((1, 0, 0), (2, 1, 1)))
    shapes["boxes at an edge"] = joined(box(), box((1, 1, 0), (2, 2, 1)))
    shapes["boxes at a corner"] = joined(box(), box((1, 1, 1), (2, 2, 2)))
    shapes["boxes 0.01 apart"] = joined(box(), box((1.01, 0, 0), (2, 1, 1)))
    shapes["L"] = extruded([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)], 1.0)
    for steps in (5, 30):
        shapes[f"stairs {steps}"] = stairs(steps)
    star = [((1 if i % 2 else 0.4) * math.cos(math.pi * i / 5),
             (1 if i % 2 else 0.4) * math.sin(math.pi * i / 5)) for i in range(10)]
    shapes["star"] = extruded(star, 1.0)
    for n in (12, 40):
        shapes[f"Moebius strip {n}"] = moebius(n)
    for sheets, degrees in ((3, 120), (3, 30), (6, 60), (12, 30), (24, 15), (3, 10), (12, 10),
                            (24, 10), (3, 1), (6, 5), (24, 2)):
        shapes[f"{sheets} sheets, {degrees} degrees"] = fan(sheets, degrees)
    shapes["terrain 10, flat"] = terrain(10, 0.0)
    for height in (0.1, 0.5, 2.0):
        shapes[f"terrain 30, height {height}"] = terrain(30, height)
    shapes["prism, 60 degrees"] = extruded([(0, 0), (1, 0), (0.5, math.sqrt(3) / 2)], 1.0)
    shapes["prism, 45 degrees"] = extruded([(0, 0), (1, 0), (0, 1)], 1.0)
    shapes["chamfered box"] = extruded([(0, 0), (1, 0), (1, 0.8), (0.8, 1), (0, 1)], 1.0)
    shapes["trapezoid"] = extruded(
        [(0, 0), (2, 0), (1.5, math.sqrt(3) / 2), (0.5, math.sqrt(3) / 2)], 1.0)
    return shapes


def large() -> dict[str, Surface]:
    return {"terrain 71": terrain(71, 0.3), "sphere 200 x 100": sphere(200, 100),
            "icosphere 5": icosphere(5), "torus 200 x 80": torus(200, 80)}
