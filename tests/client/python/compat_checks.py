"""Independent checks of triangle and tetrahedron arrays, the slow and obvious way."""
import itertools
import math

import numpy as np


def measures(points, cells):
    corners = np.asarray(points)[np.asarray(cells)]
    edges = corners[:, 1:] - corners[:, :1]
    return np.linalg.det(edges) / math.factorial(edges.shape[2])


def angles(points, triangles):
    """Degrees, (triangles, 3), by the law of cosines."""
    corners = np.asarray(points)[np.asarray(triangles)]
    lengths = [np.linalg.norm(corners[:, (i + 1) % 3] - corners[:, (i + 2) % 3], axis=1)
               for i in range(3)]
    result = []
    for i in range(3):
        a, b, c = lengths[i], lengths[(i + 1) % 3], lengths[(i + 2) % 3]
        result.append(np.arccos(np.clip((b * b + c * c - a * a) / (2 * b * c), -1, 1)))
    return np.degrees(np.stack(result, axis=1))


def faces(cells):
    """The cells and corners at each face, by the set of its vertices."""
    result = {}
    for number, cell in enumerate(np.asarray(cells).tolist()):
        for corner in range(len(cell)):
            key = frozenset(cell[:corner] + cell[corner + 1:])
            result.setdefault(key, []).append((number, corner))
    assert all(len(rows) <= 2 for rows in result.values())
    return result


def border(cells):
    return {face for face, rows in faces(cells).items() if len(rows) == 1}


def edges(cells):
    return {frozenset(pair) for cell in np.asarray(cells).tolist()
            for pair in itertools.combinations(cell, 2)}


def neighbours(cells):
    result = np.full(np.shape(cells), -1)
    for rows in faces(cells).values():
        if len(rows) == 2:
            (one, i), (two, j) = rows
            result[one, i], result[two, j] = two, one
    return result


def parts_of(points, pairs, begin, end):
    """The pairs of vertices that lie on the line from begin to end, and the length that they cover."""
    begin, end = np.asarray(begin, float), np.asarray(end, float)
    along = end - begin
    length = np.linalg.norm(along)
    on = []
    for pair in pairs:
        ends = np.asarray(points)[list(pair)] - begin
        off = np.abs(along[0] * ends[:, 1] - along[1] * ends[:, 0]) / length
        where = ends @ along / length
        if (off < 1e-9).all() and (where > -1e-9).all() and (where < length + 1e-9).all():
            on.append((pair, abs(where[1] - where[0])))
    return [pair for pair, _ in on], sum(part for _, part in on)


def check_follows(points, triangles, vertices, segments):
    """Each segment is a chain of edges, without gaps and overlaps."""
    there = [sorted(edge) for edge in edges(triangles)]
    for a, b in segments:
        length = np.linalg.norm(np.subtract(vertices[a], vertices[b]))
        _, covered = parts_of(points, there, vertices[a], vertices[b])
        assert math.isclose(covered, length, rel_tol=1e-9)


def check_delaunay(points, triangles):
    """No vertex of a neighbour is in the circle of a triangle."""
    points = np.asarray(points)
    for rows in faces(triangles).values():
        if len(rows) < 2:
            continue
        (one, _), (two, j) = rows
        a, b, c = points[triangles[one]]
        d = points[triangles[two][j]]
        rows = np.array([[*(p - d), (p - d) @ (p - d)] for p in (a, b, c)])
        scale = np.abs(rows).max()
        assert np.linalg.det(rows / scale) <= 1e-9


def is_inside(ring, places):
    """Even-odd rule."""
    ring = np.asarray(ring, float)
    result = np.zeros(len(places), bool)
    for (ax, ay), (bx, by) in zip(ring, np.roll(ring, -1, axis=0)):
        crosses = (ay > places[:, 1]) != (by > places[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            x = ax + (places[:, 1] - ay) * (bx - ax) / (by - ay)
        result ^= crosses & (places[:, 0] < x)
    return result


def box_of(low, high, first=0):
    """The corners of a box and its six faces, counter-clockwise from outside."""
    (a, b, c), (d, e, f) = low, high
    points = [(a, b, c), (d, b, c), (d, e, c), (a, e, c), (a, b, f), (d, b, f), (d, e, f), (a, e, f)]
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return points, [tuple(first + i for i in face) for face in faces]


def dihedral_angles(points, cells):
    """Degrees, (cells, 6)."""
    corners = np.asarray(points)[np.asarray(cells)]
    result = []
    for i, j in itertools.combinations(range(4), 2):
        k, m = (x for x in range(4) if x not in (i, j))
        along = corners[:, j] - corners[:, i]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        sides = []
        for other in (k, m):
            side = corners[:, other] - corners[:, i]
            side = side - (side * along).sum(axis=1, keepdims=True) * along
            sides.append(side / np.linalg.norm(side, axis=1, keepdims=True))
        result.append(np.degrees(np.arccos(np.clip((sides[0] * sides[1]).sum(axis=1), -1, 1))))
    return np.stack(result, axis=1)


def radius_edge(points, cells):
    """Circumradius / shortest edge of each tetrahedron."""
    corners = np.asarray(points)[np.asarray(cells)]
    edges = corners[:, 1:] - corners[:, :1]
    centres = np.linalg.solve(2 * edges, (edges**2).sum(axis=2)[:, :, None])[:, :, 0]
    shortest = np.min([np.linalg.norm(corners[:, i] - corners[:, j], axis=1)
                       for i, j in itertools.combinations(range(4), 2)], axis=0)
    return np.linalg.norm(centres, axis=1) / shortest
