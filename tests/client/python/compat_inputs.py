"""Inputs of the tests of `dynmesh.compat`: those of documents, written anew."""
import math

import numpy as np

import compat_checks as checks


def ring_of(n, first=0):
    return [(first + i, first + (i + 1) % n) for i in range(n)]


SQUARE = dict(vertices=[(0, 0), (1, 0), (1, 1), (0, 1)], segments=ring_of(4))
# A box with a square hole, as in the documents of the package.
BOX = dict(vertices=[(0, 0), (3, 0), (3, 3), (0, 3), (1, 1), (2, 1), (2, 2), (1, 2)],
           vertex_markers=[1, 1, 1, 1, 5, 5, 5, 5],
           segments=ring_of(4) + ring_of(4, 4),
           segment_markers=[1, 2, 3, 4, 10, 10, 10, 10],
           holes=[(1.5, 1.5)])
# An L with a crack, whose corners are obtuse or right.
ELL = dict(vertices=[(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (0.4, 0.5), (0.8, 0.5)],
           segments=[*ring_of(6), (6, 7)])
# A face: outline, two eyes that are holes, a mouth that is a hole, and a nose of two segments.
_OUTLINE = [(math.cos(t), 1.2 * math.sin(t)) for t in np.arange(16) * math.pi / 8]
_EYES = [(x + 0.15 * math.cos(t), 0.4 + 0.15 * math.sin(t))
         for x in (-0.4, 0.4) for t in np.arange(6) * math.pi / 3]
_MOUTH = [(-0.4, -0.5), (0, -0.7), (0.4, -0.5), (0, -0.6)]
FACE = dict(vertices=[*_OUTLINE, *_EYES, *_MOUTH, (0, 0.2), (-0.15, -0.2), (0.15, -0.2)],
            segments=[*ring_of(16), *ring_of(6, 16), *ring_of(6, 22), *ring_of(4, 28),
                      (32, 33), (33, 34)],
            holes=[(-0.4, 0.4), (0.4, 0.4), (0, -0.65)])
# Two halves with attributes and areas.
HALVES = dict(vertices=[(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)],
              segments=[*ring_of(6), (1, 4)],
              regions=[(0.5, 0.5, 7, 0.02), (1.5, 0.5, -2.5, 0.002)])


def area_of(ring):
    x, y = np.transpose(ring)
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


AREAS = {
    "square": (SQUARE, 1.0), "box": (BOX, 8.0), "ell": (ELL, 3.0), "halves": (HALVES, 2.0),
    "face": (FACE, area_of(_OUTLINE) - area_of(_EYES[:6]) - area_of(_EYES[6:]) - area_of(_MOUTH)),
}

TOWER = checks.box_of((0, 0, 0), (2, 2, 12))
# A box with a box in it.
_OUTER, _OUTER_FACES = checks.box_of((0, 0, 0), (3, 3, 3))
_INNER, _INNER_FACES = checks.box_of((1, 1, 1), (2, 2, 2), 8)
NESTED = _OUTER + _INNER, _OUTER_FACES + _INNER_FACES
