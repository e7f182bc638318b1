"""A ring between two circles, with a hole: a bound of areas, least angles, neighbours."""
import numpy as np
import triangle as tr


def circle(count, radius):
    i = np.arange(count)
    angle = 2 * np.pi * i / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1), np.stack([i, (i + 1) % count], axis=1)


outer, outer_segments = circle(30, 1.4)
inner, inner_segments = circle(16, 0.6)
A = dict(vertices=np.vstack([outer, inner]), segments=np.vstack([outer_segments, inner_segments + len(outer)]),
         holes=[[0, 0]])
B = tr.triangulate(A, "qpa0.05n")

corners = B["vertices"][B["triangles"]]
sides = np.roll(corners, -1, axis=1) - corners
areas = (sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]) / 2
assert 0 < areas.min() and areas.max() <= 0.05
ring = (30 * 1.4**2 * np.sin(2 * np.pi / 30) - 16 * 0.6**2 * np.sin(2 * np.pi / 16)) / 2
assert np.isclose(areas.sum(), ring)
lengths = np.hypot(sides[..., 0], sides[..., 1])
sine = 2 * areas[:, None] / (lengths * np.roll(lengths, 1, axis=1))
assert np.degrees(np.arcsin(sine.min())) >= 20
assert (B["neighbors"] == -1).sum() >= 46
assert (np.hypot(*B["vertices"].T) > 0.58).all()
