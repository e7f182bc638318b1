"""PyVista's tetgen: a ball between triangles, with bounds of quality, and a hollow in it."""
import numpy as np
import tetgen


def ball(rings, sectors, radius):
    """Vertices and triangles of a sphere by rings of latitude."""
    vertices = [(0, 0, radius)]
    for i in range(1, rings):
        for j in range(sectors):
            up, around = np.pi * i / rings, 2 * np.pi * j / sectors
            vertices.append((radius * np.sin(up) * np.cos(around), radius * np.sin(up) * np.sin(around),
                             radius * np.cos(up)))
    vertices.append((0, 0, -radius))
    last = len(vertices) - 1
    faces = []
    for j in range(sectors):
        k = (j + 1) % sectors
        faces.append((0, 1 + j, 1 + k))
        faces.append((last, last - 1 - j, last - 1 - k))
        for i in range(rings - 2):
            a, b = 1 + i * sectors + j, 1 + i * sectors + k
            faces += [(a, a + sectors, b + sectors), (a, b + sectors, b)]
    return np.array(vertices, dtype=float), np.array(faces)


def enclosed(v, f):
    a, b, c = np.moveaxis(v[f], 1, 0)
    return abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6


v, f = ball(6, 10, 1.0)
inner_v, inner_f = ball(4, 6, 0.4)
tet = tetgen.TetGen(np.vstack([v, inner_v]), np.vstack([f, inner_f + len(v)]))
tet.add_hole((0, 0, 0))
nodes, elems = tet.tetrahedralize(order=1, mindihedral=10, minratio=1.6)

a, b, c, d = np.moveaxis(nodes[elems], 1, 0)
volumes = np.abs(np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a))) / 6
assert elems.shape[1] == 4 and volumes.min() > 0
assert np.isclose(volumes.sum(), enclosed(v, f) - enclosed(inner_v, inner_f))
sides = np.stack([np.linalg.norm(p - q, axis=1) for p, q in ((a, b), (a, c), (a, d), (b, c), (b, d), (c, d))])
x, y, z = (sides[i] * sides[5 - i] for i in range(3))
s = (x + y + z) / 2
radius = np.sqrt(s * (s - x) * (s - y) * (s - z)) / (6 * volumes)
assert (radius <= 1.6 * (1 + 1e-9) * sides.min(axis=0)).all()
