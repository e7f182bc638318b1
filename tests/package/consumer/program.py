"""The same mesh in Python, with a field on it: prints versions, hash and where the package is."""
import importlib.metadata

import numpy as np

import dynmesh

mesh = dynmesh.open([[0, 0], [10, 10]])
mesh.apply(add_points={1: (2, 2), 2: (7, 4), 3: (2.1, 2.3)})
u = 1 + mesh.points[:, 0] - 2 * mesh.points[:, 1]
diff = mesh.apply(add_segments={4: (1, 2)})
u = diff.transfer(u)
live = mesh.live_vertices
assert np.allclose(u[live], 1 + mesh.points[live, 0] - 2 * mesh.points[live, 1])
print(dynmesh.__version__, importlib.metadata.version("dynmesh"), mesh.hash, dynmesh.__file__)
