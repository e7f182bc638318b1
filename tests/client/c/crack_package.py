"""The scene of crack.c by the Python package: what the others have to print."""
import numpy as np

import dynmesh

mesh = dynmesh.open(max_edge=0.05)
mesh.apply(add_points={1: (0, 0), 2: (1, 0), 3: (1, 1), 4: (0, 1), 5: (0.125, 0.5)},
           add_polygons={9: [[1, 2, 3, 4]]})
part = mesh.part()
x, y = mesh.points.T
u = x * x + 3 * y
for k in range(100):
    point = 101 + k
    diff = mesh.apply(
        add_points={point: (0.125 + (k + 1) / 160, 0.5 + ((k * 7) % 13 - 6) / 4096)},
        add_segments={301 + k: (5 if k == 0 else point - 1, point)})
    u = diff.transfer(u)
    part.update(diff)
total = 0.0
for value in u[mesh.live_vertices]:
    total += value
print(mesh.hash, f"{np.float64(total).view(np.uint64):016x}", len(part.cells))
