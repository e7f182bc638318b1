"""meshpy, 3D: a tower as a list of facets, with markers and a largest volume, written for VTK."""
import numpy as np
from meshpy.tet import MeshInfo, Options, build

mesh_info = MeshInfo()
mesh_info.set_points([
    (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 5), (1, 0, 5), (1, 1, 5), (0, 1, 5)])
mesh_info.set_facets([
    [0, 1, 2, 3], [4, 5, 6, 7], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]],
    markers=[1, 2, 3, 3, 3, 3])
mesh = build(mesh_info, options=Options("pq1.5"), max_volume=0.05)

print("Mesh Points:")
for i, p in enumerate(mesh.points):
    print(i, p)
print("Point numbers in tetrahedra:")
for i, t in enumerate(mesh.elements):
    print(i, t)
mesh.write_vtk("tower.vtk")

points = np.array(mesh.points)
a, b, c, d = np.moveaxis(points[np.array(mesh.elements)], 1, 0)
volumes = np.abs(np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a))) / 6
assert volumes.max() <= 0.05 and np.isclose(volumes.sum(), 5)
a, b, c = np.moveaxis(points[np.array(mesh.faces)], 1, 0)
areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
markers = np.array(mesh.face_markers)
for marker, area in ((1, 1), (2, 1), (3, 20)):
    assert np.isclose(areas[markers == marker].sum(), area)
with open("tower.vtk", encoding="ascii") as file:
    assert file.readline().startswith("# vtk DataFile")
