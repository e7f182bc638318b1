"""meshpy, 2D: triangles that a function wants finer around a point; markers; boundary faces."""
import numpy as np
from meshpy import triangle


def round_trip_connect(start, end):
    return [(i, i + 1) for i in range(start, end)] + [(end, start)]


def needs_refinement(vertices, area):
    bary = np.sum(np.array(vertices), axis=0) / 3
    return bool(area > 0.002 + 0.02 * np.linalg.norm(bary - (1, 1)))


points = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
info = triangle.MeshInfo()
info.set_points(points)
info.set_facets(round_trip_connect(0, len(points) - 1), facet_markers=[1, 2, 3, 4, 5, 6])
mesh = triangle.build(info, refinement_func=needs_refinement, min_angle=28, generate_faces=True)

mesh_points = np.array(mesh.points)
mesh_tris = np.array(mesh.elements)
a, b, c = np.moveaxis(mesh_points[mesh_tris], 1, 0)
u, v = (b - a).T, (c - a).T
areas = np.abs(u[0] * v[1] - u[1] * v[0]) / 2
assert np.isclose(areas.sum(), 3)
for tri, size in zip(mesh_points[mesh_tris], areas):
    assert not needs_refinement(tri, size)
markers = np.array(mesh.face_markers)
faces = mesh_points[np.array(mesh.faces)]
lengths = np.linalg.norm(faces[:, 0] - faces[:, 1], axis=1)
for marker, length in zip(range(1, 7), (2, 1, 1, 1, 1, 2)):
    assert np.isclose(lengths[markers == marker].sum(), length)
