"""Arrays of triangles and tetrahedra: faces, neighbours, parts, places."""
from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np

from dynmesh._types import Array


def keys(faces: Array, vertices: int) -> Array:
    """A number for each row of corners, in any order: the same for equal sets of corners."""
    corners = np.sort(faces, axis=1).astype(np.int64)
    result: Array = corners[:, 0]
    for column in corners.T[1:]:
        if vertices and len(result) and result.max() >= 2**62 // vertices:
            result = np.unique(result, return_inverse=True)[1].astype(np.int64)
        result = result * vertices + column
    return result


def common_keys(first: Array, second: Array, vertices: int) -> tuple[Array, Array]:
    """`keys` of two arrays of faces, comparable with each other."""
    both = keys(np.concatenate([first, second]), vertices)
    return both[:len(first)], both[len(first):]


def faces_of(cells: Array) -> Array:
    """The face opposite to each corner: (cells, corners, corners - 1)."""
    width = cells.shape[1]
    return np.stack([cells[:, [j for j in range(width) if j != i]] for i in range(width)], axis=1)


def neighbours_of(cells: Array, vertices: int) -> Array:
    """The cell opposite to each corner, -1 where there is none: (cells, corners), int32."""
    result = np.full(cells.shape, -1, np.int32)
    if len(cells) == 0:
        return result
    faces = faces_of(cells)
    face_keys = keys(faces.reshape(-1, faces.shape[2]), vertices)
    order = np.argsort(face_keys, kind="stable")
    same = np.flatnonzero(face_keys[order][1:] == face_keys[order][:-1])
    one, two = order[same], order[same + 1]
    flat = result.reshape(-1)
    flat[one], flat[two] = two // cells.shape[1], one // cells.shape[1]
    return result


def edges_of(cells: Array) -> Array:
    """The edges of cells, each once, with ascending ends, in order: (edges, 2)."""
    width = cells.shape[1]
    pairs = [cells[:, pair] for pair in itertools.combinations(range(width), 2)]
    result: Array = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
    return result.reshape(-1, 2)


def flood(neighbours: Array, blocked: Array, seeds: Array) -> Array:
    """Mask of the cells that are reached from the seeds over faces that are not blocked."""
    reached = np.zeros(len(neighbours), bool)
    front = np.unique(seeds)
    reached[front] = True
    while len(front):
        ahead = neighbours[front][~blocked[front]]
        ahead = np.unique(ahead[ahead >= 0])
        front = ahead[~reached[ahead]]
        reached[front] = True
    return reached


def measures_of(points: Array, cells: Array) -> Array:
    """Areas of triangles, volumes of tetrahedra; positive for positive orientation."""
    corners = points[cells]
    edges = corners[:, 1:] - corners[:, :1]
    measures: Array = np.linalg.det(edges) / math.factorial(points.shape[1])
    return measures


def weights_in(points: Array, cells: Array, places: Array) -> Array:
    """Barycentric coordinates of a place in each cell: (cells, corners)."""
    corners = points[cells]
    edges = (corners[:, 1:] - corners[:, :1]).transpose(0, 2, 1)
    inner = np.linalg.solve(edges, (places - corners[:, 0])[:, :, None])[:, :, 0]
    return np.concatenate([1 - inner.sum(axis=1, keepdims=True), inner], axis=1)


class Grid:
    """Finds the cell of a given mesh around places, by boxes of a grid."""

    def __init__(self, points: Array, cells: Array) -> None:
        self._points, self._cells = points, cells
        corners = points[cells]
        low, high = corners.min(axis=1), corners.max(axis=1)
        self._low = low.min(axis=0)
        extent = np.maximum(high.max(axis=0) - self._low, 1e-300)
        dimension = points.shape[1]
        self._shape = np.full(dimension, max(1, int(len(cells)**(1 / dimension))))
        self._step = extent / self._shape
        first, last = self._box(low), self._box(high)
        counts = np.prod(last - first + 1, axis=1)
        cell = np.repeat(np.arange(len(cells)), counts)
        rank = np.arange(len(cell)) - np.repeat(np.cumsum(counts) - counts, counts)
        box = np.zeros(len(cell), np.int64)
        for axis in range(dimension):
            width = (last - first + 1)[cell, axis]
            box = box * self._shape[axis] + first[cell, axis] + rank % width
            rank = rank // width
        order = np.argsort(box, kind="stable")
        self._cell = cell[order]
        self._start = np.searchsorted(box[order], np.arange(np.prod(self._shape) + 1))

    def _box(self, places: Array) -> Array:
        box = np.floor((places - self._low) / self._step).astype(np.int64)
        return np.clip(box, 0, self._shape - 1)

    def locate(self, places: Array) -> Array:
        """The cell around each place; -1 outside. On a border any of the cells there."""
        result = np.full(len(places), -1, np.int64)
        best = np.full(len(places), -1e-9)
        corner = self._box(places)
        box = np.zeros(len(places), np.int64)
        for axis in range(corner.shape[1]):
            box = box * self._shape[axis] + corner[:, axis]
        at, end = self._start[box], self._start[box + 1]
        left = np.flatnonzero(at < end)
        while len(left):
            cell = self._cell[at[left]]
            least = weights_in(self._points, self._cells[cell], places[left]).min(axis=1)
            better = least >= best[left]
            result[left[better]] = cell[better]
            best[left[better]] = least[better]
            at[left] += 1
            left = left[at[left] < end[left]]
        return result


def _turn(a: Array, b: Array, c: Array) -> float:
    """Exact sign of the turn from a over b to c: positive to the left."""
    left = (b[0] - a[0]) * (c[1] - a[1])
    right = (b[1] - a[1]) * (c[0] - a[0])
    if abs(left - right) > 1e-14 * (abs(left) + abs(right)):
        return float(left - right)
    ax, ay, bx, by, cx, cy = (Fraction(float(x)) for x in (*a, *b, *c))
    turn = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    return float((turn > 0) - (turn < 0))


def hull_of(points: Array) -> Array:
    """The convex hull's edges, counter-clockwise, all points on it included: (edges, 2), int32."""
    order = np.lexsort((points[:, 1], points[:, 0]))
    distinct = np.ones(len(order), bool)
    distinct[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    order = order[distinct]

    def chain(indices: Array) -> list[int]:
        result: list[int] = []
        for index in indices:
            while len(result) > 1 and _turn(points[result[-2]], points[result[-1]],
                                            points[index]) < 0:
                result.pop()
            result.append(int(index))
        return result

    lower, upper = chain(order), chain(order[::-1])
    if len(order) < 3 or sorted(lower) == sorted(upper):
        raise ValueError("vertices: they lie on one line, and have no triangulation")
    ring = np.array(lower[:-1] + upper[:-1], np.int32)
    return np.stack([ring, np.roll(ring, -1)], axis=1)


def pieces_between(points: Array, segments: Array, near: float) -> tuple[Array, Array]:
    """Segments cut at the points that lie on them; of each piece the number of its segment.

    A point lies on a segment if it is within the distance `near`.
    """
    order = np.argsort(points[:, 0], kind="stable")
    sorted_x = points[order, 0]
    rows, owners = [], []
    for number, (a, b) in enumerate(segments):
        p, q = points[a], points[b]
        begin = np.searchsorted(sorted_x, min(p[0], q[0]) - near)
        end = np.searchsorted(sorted_x, max(p[0], q[0]) + near, "right")
        others = order[begin:end]
        others = others[(others != a) & (others != b)]
        along = q - p
        length = float(np.hypot(*along))
        from_p = points[others] - p
        off = np.abs(along[0] * from_p[:, 1] - along[1] * from_p[:, 0])
        where = from_p @ along
        on = (off <= near * length) & (where > 0) & (where < length * length)
        chain = [a, *others[on][np.argsort(where[on])], b]
        rows += list(zip(chain, chain[1:]))
        owners += [number] * (len(chain) - 1)
    return np.array(rows, np.int64).reshape(-1, 2), np.array(owners, np.int64)
