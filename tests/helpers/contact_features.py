"""Places in bodies whose closest feature is a face, an edge, a vertex or a curved patch, and the tangent of contact there.

Seen from inside, where gaps are negative, the closest feature is an edge or a vertex where the body is
re-entrant. The body is a cube of 2 m without its octant x, y, z > 0: three re-entrant edges that meet in a
re-entrant vertex. Curved faces are those of a torus, a curved edge that of a shaft with a shoulder.
"""

import itertools

import numpy as np
from smooth_shapes import revolved, torus

from hybrid.body.attitude import exp_so3, skews
from hybrid.body.surface import build_surface
from hybrid.contact import assembly
from hybrid.contact.contact_points import ContactPoints

SHIFT = np.array([0.2, 0.1, -0.3])  # of the notch from the body's centre
INSIDE = {  # places from the notch whose closest feature is that of the name
    "face": [(-0.5, -0.4, 0.97), (-0.03, -0.6, 0.98), (-0.7, 0.96, -0.5), (0.99, -0.4, -0.5)],
    "edge": [(-0.02, -0.03, 0.4), (-0.01, 0.7, -0.02), (0.3, -0.02, -0.02)],
    "vertex": [(-0.02, -0.03, -0.01), (-0.01, -0.01, -0.02)],
    # of the torus, 1 m about its centre line of 0.4 m: outer side, inner side, top
    "curved": [(1.36, 0.1, 0.1), (-0.2, 1.32, -0.13), (-0.5, -0.38, 0.05), (0.1, 0.95, 0.385), (0.73, 0.74, -0.37)],
    # about the circle of radius 0.5 m at z = 0
    "shoulder": [(0.46, 0.15, -0.02), (-0.3, 0.37, -0.03), (0.02, -0.46, -0.01)],
}
KIND = {"face": (0,), "edge": (1, 2, 3), "vertex": (4, 5, 6), "curved": (0,), "shoulder": (1, 2, 3)}
SHAFT = [(0.0, -1.0), (1.0, -1.0), (1.0, 0.0), (0.5, 0.0), (0.5, 1.0), (0.0, 1.0)]
RATIO = 0.5
CENTRE, ROTATION = np.array([0.3, -0.2, 0.5]), exp_so3(np.array([0.4, -0.7, 0.2]))


def notched_cube():
    """ContactSurface of [-1, 1]³ without the octant x, y, z > 0, two triangles per square of 1 m."""
    filled = set(itertools.product((-1, 0), repeat=3)) - {(0, 0, 0)}
    index, triangles = {}, []
    for cell in filled:
        for axis, side in itertools.product(range(3), (0, 1)):
            beyond = tuple(c + (2 * side - 1) * (a == axis) for a, c in enumerate(cell))
            if beyond in filled:
                continue
            square = []
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = list(cell)
                corner[axis] += side
                corner[(axis + 1) % 3] += u
                corner[(axis + 2) % 3] += v
                square.append(index.setdefault(tuple(corner), len(index)))
            square = square if side else square[::-1]
            triangles += [(square[0], square[1], square[2]), (square[0], square[2], square[3])]
    return build_surface(SHIFT + np.array(list(index)), np.array(triangles))


def shifted(vertices, triangles, normals):
    return build_surface(SHIFT + vertices, triangles, normals)


NOTCH = notched_cube()
SURFACE = {"face": NOTCH, "edge": NOTCH, "vertex": NOTCH, "curved": shifted(*torus(1)),
           "shoulder": shifted(*revolved(SHAFT, 12))}


def corners_at(feature, seed=4, places=None):
    """Corners at the places of a feature, or those given, with anchors some millimetres away in all directions."""
    y = SHIFT + (INSIDE[feature] if places is None else places)
    m, rng = len(y), np.random.default_rng(seed)
    anchor = y + 0.004 * rng.standard_normal((m, 3))
    place = CENTRE + y @ ROTATION.T
    return ContactPoints(np.arange(m), np.zeros(m, np.int64), place, y, np.zeros((m, 8), np.int64), np.full((m, 8), 0.125),
                   1e5 * (1 + np.arange(m)), np.ones(m, bool), anchor, np.zeros((m, 3)), np.zeros(m),
                   np.zeros(m))


def tangent(contact):
    """Derivative of `residual` from D, Q and K_ww, and the block ∂(body residual)/∂x_c as it enters K_wu."""
    ww, Q = assembly.body_tangent(contact)
    m = len(contact)
    K = np.zeros((3 * m + 6, 3 * m + 6))
    for n in range(m):
        own = slice(3 * n, 3 * n + 3)
        K[own, own] = contact.tangent[n]
        K[own, -6:] = Q[n]
        arm, force = skews(contact.arm[n:n + 1])[0], skews(contact.force[n:n + 1])[0]
        K[-6:-3, own] = -contact.tangent[n]
        K[-3:, own] = force - arm @ contact.tangent[n]
    K[-6:, -6:] = ww
    return K
