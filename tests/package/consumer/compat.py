"""Programs that were written for triangle, meshpy and tetgen, each at one import: prints their names."""
import numpy as np

from dynmesh.compat import tetgen
from dynmesh.compat import triangle as tr
from dynmesh.compat.meshpy import tet
from dynmesh.compat.meshpy import triangle

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
RING = [(0, 1), (1, 2), (2, 3), (3, 0)]
CORNERS = [(x, y, z) for z in (0, 1) for x, y in SQUARE]
FACETS = [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]

made = tr.triangulate({"vertices": SQUARE, "segments": RING}, "pq30a0.05")
assert len(made["triangles"]) >= 20
print("triangle")

info = triangle.MeshInfo()
info.set_points(SQUARE)
info.set_facets(RING)
assert len(triangle.build(info, max_volume=0.05, min_angle=30).elements) >= 20
print("meshpy.triangle")

info = tet.MeshInfo()
info.set_points(CORNERS)
info.set_facets(FACETS)
assert len(tet.build(info, max_volume=0.1).elements) >= 10
print("meshpy.tet")

faces = np.array([t for f in FACETS for t in ([f[0], f[1], f[2]], [f[0], f[2], f[3]])])
nodes, cells = tetgen.TetGen(np.array(CORNERS, float), faces).tetrahedralize()[:2]
assert len(cells) >= 5 and nodes.shape[1] == 3
print("tetgen")
