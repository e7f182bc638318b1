"""Tetrahedra in files, judged by code that is not dynmesh's: for dihedral_table.py.

TetGen's formats: .node, .ele, .face and .edge, as dynmesh, TetGen and cgal_mesh_3.cc write them.
"""
from __future__ import annotations

import pathlib
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

# Each pair of a tetrahedron's corners, and the other two.
_EDGES = ((0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 2, 0), (2, 3, 0, 1))


def least_angles(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The least dihedral angle of each tetrahedron, in degrees; 0 of a flat one."""
    p = points[cells]
    least = np.full(len(cells), 180.0)
    for a, b, c, d in _EDGES:
        edge, u, w = (p[:, k] - p[:, a] for k in (b, c, d))
        m, n = np.cross(edge, u), np.cross(edge, w)
        across = np.linalg.norm(np.cross(m, n), axis=1)
        least = np.minimum(least, np.degrees(np.arctan2(across, (m * n).sum(axis=1))))
    return least


def _rows(path: pathlib.Path, width: int) -> np.ndarray:
    with open(path, encoding="ascii") as file:
        count = int(file.readline().split()[0])
        if count == 0:
            return np.zeros((0, width))
        return np.loadtxt(file, max_rows=count, comments="#", ndmin=2)


@dataclass
class Mesh:
    points: np.ndarray
    cells: np.ndarray
    inside: np.ndarray  # of each cell: does it lie in the domain?
    dimensions: np.ndarray  # of each vertex: 0 given, 1 on a segment, 2 on a facet, 3 free

    def vertices_inside(self) -> int:
        return len(np.unique(self.cells[self.inside]))

    def edge_inside(self) -> float:
        """The mean length of the edges of the domain's cells."""
        cells = self.cells[self.inside]
        pairs = np.unique(np.sort(np.vstack([cells[:, e[:2]] for e in _EDGES]), axis=1), axis=0)
        return float(np.linalg.norm(self.points[pairs[:, 0]] - self.points[pairs[:, 1]],
                                    axis=1).mean())


def _within_walls(cells: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """False for the cells that are joined to the mesh's border without crossing a wall."""
    count = len(cells)
    faces = np.sort(np.vstack([cells[:, [k for k in range(4) if k != i]] for i in range(4)]), axis=1)
    owners = np.tile(np.arange(count), 4)
    all_faces = np.vstack([faces, np.sort(walls, axis=1)])
    _, numbers = np.unique(all_faces, axis=0, return_inverse=True)
    is_wall = np.zeros(numbers.max() + 1, bool)
    is_wall[numbers[len(faces):]] = True
    numbers = numbers[:len(faces)]
    order = np.argsort(numbers, kind="stable")
    same = numbers[order[1:]] == numbers[order[:-1]]
    through = same & ~is_wall[numbers[order[1:]]]
    first, second = owners[order[:-1]][through], owners[order[1:]][through]
    _, part = connected_components(
        coo_matrix((np.ones(len(first)), (first, second)), (count, count)), directed=False)
    alone = np.ones(len(order), bool)
    alone[:-1] &= ~same
    alone[1:] &= ~same
    at_border = owners[order[alone & ~is_wall[numbers[order]]]]
    return ~np.isin(part, part[at_border])


def read(stem: pathlib.Path, is_of_dynmesh: bool) -> Mesh:
    """dynmesh's mesh goes on outside the domain, and its files tell what vertices lie on."""
    nodes = _rows(stem.with_suffix(".node"), 4)
    elements = _rows(stem.with_suffix(".ele"), 5)
    first = int(nodes[0, 0])
    points, cells = nodes[:, 1:4].copy(), elements[:, 1:5].astype(int) - first
    inside = np.ones(len(cells), bool)
    dimensions = np.full(len(points), 3)
    if is_of_dynmesh:
        faces, edges = (_rows(stem.with_suffix(f".{kind}"), width).astype(int)
                        for kind, width in (("face", 5), ("edge", 4)))
        walls = faces[faces[:, 4] > 0, 1:4] - first
        dimensions[walls] = 2
        dimensions[edges[edges[:, 3] > 0, 1:3] - first] = 1
        dimensions[nodes[:, 4] > 0] = 0
        inside = _within_walls(cells, walls)
    return Mesh(points, cells, inside, dimensions)
