"""A square in two parts with attributes and areas of their own, then refined; hull, dual."""
import numpy as np
import triangle as tr

points = [(0, 0), (2, 0), (2, 1), (0, 1), (1, 0), (1, 1)]
A = {"vertices": np.array(points, dtype=float),
     "segments": np.array([(0, 4), (4, 1), (1, 2), (2, 5), (5, 3), (3, 0), (4, 5)]),
     "segment_markers": np.array([[7], [7], [1], [1], [1], [1], [9]]),
     "regions": [[0.5, 0.5, 11, 0.1], [1.5, 0.5, 22, 0.01]]}
t = tr.triangulate(A, "pq25aAe")


def area(mesh):
    a, b, c = np.moveaxis(mesh["vertices"][mesh["triangles"]], 1, 0)
    u, v = (b - a).T, (c - a).T
    return np.abs(u[0] * v[1] - u[1] * v[0]) / 2


kind = t["triangle_attributes"].ravel()
assert set(kind) == {11, 22}
middle = t["vertices"][t["triangles"]].mean(axis=1)
assert ((middle[:, 0] < 1) == (kind == 11)).all()
assert area(t)[kind == 11].max() <= 0.1 and area(t)[kind == 22].max() <= 0.01
assert np.isclose(area(t)[kind == 22].sum(), 1)
between = t["vertices"][t["segments"][t["segment_markers"].ravel() == 9]]
assert (between[..., 0] == 1).all()
assert np.isclose(np.abs(between[:, 0, 1] - between[:, 1, 1]).sum(), 1)
assert len(t["edges"]) == len(t["vertices"]) + len(t["triangles"]) - 1

finer = tr.triangulate(t, "rpqa0.005")
assert area(finer).max() <= 0.005 and np.isclose(area(finer).sum(), 2)
assert sorted(map(tuple, np.sort(tr.convex_hull(points), axis=1))) == [
    (0, 3), (0, 4), (1, 2), (1, 4), (2, 5), (3, 5)]
assert len(tr.delaunay(points)) == 4
dual, edges, rays, directions = tr.voronoi(np.random.default_rng(3).random((20, 2)))
assert edges.max() < len(dual) and len(rays) == len(directions)
