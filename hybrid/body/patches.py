"""Kernels of the curved patches over a body's triangles: projection onto the smooth surface that facets approximate.

    x(w) = Σ w_i x_i - Σ w_i w_j c_ij       w = (1 - v - w, v, w), sum over the three edges
    N(w) = m/|m|,  m = Σ w_i n_i
    y = x(w) + g N(w)                       solved for (v, w, g) by Newton's method; g is the gap

n_i are the normals of the surface at the corners of the triangle and c_ij its curvature along the edges
(`hybrid.body.smooth`). x and N on an edge depend on data of the edge alone, so the prisms {x(w) + g N(w)} of the
triangles of a smooth surface fill its neighbourhood without overlap, and (v, w, g), hence gap and normal, are
continuous from triangle to triangle. A point whose weights leave a triangle is passed on to its neighbour. With
a = x_v + g N_v, b = x_w + g N_w and D = (a × b)·N, the rows of [a, b, N]^-1 give

    ∂v/∂y = b × N/D      ∂w/∂y = N × a/D      ∂g/∂y = a × b/D      G = ∂N/∂y = N_v ∂v/∂y + N_w ∂w/∂y

N is normal to the patch up to second order in the triangle's size, so ∂g/∂y differs from N by as little; G is not
symmetric in general, but N·G = G N = 0.

Sources: T. Nagata, Comput. Aided Geom. Des. 22 (2005) 327-347 (patch); L. Kobbelt, J. Vorsatz and H.-P. Seidel,
Comput. Geom. 14 (1999) 5-24 (projection along interpolated normals).
"""

import math
from typing import NamedTuple

import numpy as np

from hybrid.runtime.jit import njit

HOPS = 12             # triangles that a projection may pass through
ITERATIONS = 15       # of Newton's method on one triangle
CONVERGED = 1e-8      # last update of the weights; the convergence is quadratic
BEYOND = -0.5         # weight at which a triangle is left before convergence
STEP = 0.5            # largest change of a weight in an iteration
ON_EDGE = -1e-10      # weights down to here count as on the triangle
FOCUS = 0.05          # smallest D relative to that on the surface: nearer to a centre of curvature facets are used
SMOOTH = 1            # an edge that is none of the body, only of its triangles
INSIDE, FAILED = -1, -2   # outcomes of a projection, besides the number of the sharp edge that it left by


class Patches(NamedTuple):
    """Patches over the t triangles of a surface; `nodes` and `across` are empty if no triangle is curved.

    nodes (t, 9, 3)    v0, v1 - v0, v2 - v0 [m]; n0, n1 - n0, n2 - n0; c of the edges v0v1, v1v2, v2v0 [m]
    across (t, 3, 2)   of each edge: 3 t' + e' for the neighbour t' and the number e' that the edge has there, -1 at the
                       rim of a cut; and SMOOTH where the normal is continuous across the edge, else 0
    bulge              largest distance [m] of a patch from its facet; 0 if no triangle is curved
    steepness          largest change of the gap, over the distance moved; 1 if no triangle is curved
    """

    nodes: np.ndarray
    across: np.ndarray
    bulge: float
    steepness: float


@njit(cache=True)
def _row(nodes, t, k):
    return nodes[t, k, 0], nodes[t, k, 1], nodes[t, k, 2]


@njit(cache=True)
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True)
def _add(a, s, b):
    """a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@njit(cache=True)
def unit_normal(t, v, w, nodes):
    """N at the weights and its derivatives N_v, N_w."""
    n1, n2 = _row(nodes, t, 4), _row(nodes, t, 5)
    m = _add(_add(_row(nodes, t, 3), v, n1), w, n2)
    scale = 1.0 / math.sqrt(dot(m, m))
    zero = 0.0, 0.0, 0.0
    N = _add(zero, scale, m)
    return N, _add(zero, scale, _add(n1, -dot(N, n1), N)), _add(zero, scale, _add(n2, -dot(N, n2), N))


@njit(cache=True)
def point(t, v, w, nodes):
    """x at the weights and its derivatives x_v, x_w."""
    u, d1, d2 = 1.0 - v - w, _row(nodes, t, 1), _row(nodes, t, 2)
    c0, c1, c2 = _row(nodes, t, 6), _row(nodes, t, 7), _row(nodes, t, 8)
    x = _add(_add(_row(nodes, t, 0), v, d1), w, d2)
    x = _add(_add(_add(x, -u * v, c0), -v * w, c1), -w * u, c2)
    return (x, _add(_add(_add(d1, v - u, c0), -w, c1), w, c2), _add(_add(_add(d2, v, c0), -v, c1), w - u, c2))


@njit(cache=True)
def _solve(y, t, v, w, nodes):
    """Weights and gap on the patch of triangle t, from the weights (v, w); and whether the map is regular there.

    Outside of the triangle it stops early."""
    gap = 0.0
    for n in range(ITERATIONS):
        x, x_v, x_w = point(t, v, w, nodes)
        N, N_v, N_w = unit_normal(t, v, w, nodes)
        r = y[0] - x[0], y[1] - x[1], y[2] - x[2]
        if n == 0:
            gap = dot(r, N)
        a, b = _add(x_v, gap, N_v), _add(x_w, gap, N_w)
        D, surface = dot(_cross(a, b), N), dot(_cross(x_v, x_w), N)
        if not D > FOCUS * surface or not surface > 0.0:
            return False, v, w, gap
        r = _add(r, -gap, N)
        dv, dw = dot(_cross(b, N), r) / D, dot(_cross(N, a), r) / D
        size = max(abs(dv), abs(dw), abs(dv + dw))
        scale = min(1.0, STEP / size) if size > 0.0 else 1.0
        v, w, gap = v + scale * dv, w + scale * dw, gap + scale * dot(_cross(a, b), r) / D
        if size < CONVERGED:
            return True, v, w, gap
        if n > 0 and min(v, w, 1.0 - v - w) < BEYOND:
            return True, v, w, gap
    return False, v, w, gap


@njit(cache=True)
def weight_beyond(edge, v, w):
    """Weight that is negative beyond an edge: that of the opposite corner."""
    return w if edge == 0 else (1.0 - v - w if edge == 1 else v)


@njit(cache=True)
def along_edge(edge, v, w):
    """Fraction from the start to the end of an edge at the weights, limited to the edge."""
    u = 1.0 - v - w
    start, end = (u, v) if edge == 0 else ((v, w) if edge == 1 else (w, u))
    return min(max(end / (start + end), 0.0), 1.0) if start + end > 0.0 else 0.5


@njit(cache=True)
def weights_on_edge(edge, s):
    """Weights (v, w) at the fraction s of an edge."""
    return (s, 0.0) if edge == 0 else ((1.0 - s, s) if edge == 1 else (0.0, 1.0 - s))


@njit(cache=True)
def project(y, t, v, w, patches):
    """Projection of y, a tuple of three [m], onto the smooth surface around triangle t, from the weights (v, w).

    Returns (t, v, w, gap, outcome): INSIDE; FAILED near a centre of curvature; or the number of the edge where the
    smooth surface ends and beyond which the point is.
    """
    gap = 0.0
    for _ in range(HOPS):
        regular, v, w, gap = _solve(y, t, v, w, patches.nodes)
        if not regular:
            break
        crossed, ends, lowest, lowest_end = -1, INSIDE, ON_EDGE, ON_EDGE
        for edge in range(3):
            weight = weight_beyond(edge, v, w)
            if patches.across[t, edge, 1] == SMOOTH and weight < lowest:
                crossed, lowest = edge, weight
            elif patches.across[t, edge, 1] != SMOOTH and weight < lowest_end:
                ends, lowest_end = edge, weight
        if crossed < 0:
            return t, v, w, gap, ends
        t, v, w = neighbour(t, crossed, along_edge(crossed, v, w), patches)
    return t, v, w, gap, FAILED


@njit(cache=True)
def neighbour(t, edge, s, patches):
    """Triangle across an edge and the weights (v, w) there at the fraction s of the edge."""
    code = patches.across[t, edge, 0]
    v, w = weights_on_edge(code % 3, 1.0 - s)
    return code // 3, v, w


@njit(cache=True)
def project_on_edge(y, t, edge, s, nodes):
    """Fraction (0 to 1) and place of the point of an edge, curved or straight, that is closest to y, from s."""
    for _ in range(ITERATIONS):
        x, d, c = edge_curve(t, edge, s, nodes)
        r = y[0] - x[0], y[1] - x[1], y[2] - x[2]
        slope = dot(d, d) - 2.0 * dot(r, c)
        if not slope > FOCUS * dot(d, d):
            break
        new = min(max(s + dot(r, d) / slope, 0.0), 1.0)
        if abs(new - s) < CONVERGED:
            s = new
            break
        s = new
    return s, edge_curve(t, edge, s, nodes)[0]


@njit(cache=True)
def edge_curve(t, edge, s, nodes):
    """Point x(s) of an edge, x'(s) and c = x''/2."""
    v, w = weights_on_edge(edge, s)
    x, x_v, x_w = point(t, v, w, nodes)
    if edge == 0:
        d = x_v
    elif edge == 1:
        d = _add(x_w, -1.0, x_v)
    else:
        d = _add((0.0, 0.0, 0.0), -1.0, x_w)
    return x, d, _row(nodes, t, 6 + edge)


@njit(cache=True)
def geometry(t, v, w, gap, nodes):
    """N, ∂g/∂y and the rows of G = ∂N/∂y, G[i][j] = ∂N_i/∂y_j, at the weights and gap of a projection."""
    _, x_v, x_w = point(t, v, w, nodes)
    N, N_v, N_w = unit_normal(t, v, w, nodes)
    a, b = _add(x_v, gap, N_v), _add(x_w, gap, N_w)
    normal = _cross(a, b)
    scale, zero = 1.0 / dot(normal, N), (0.0, 0.0, 0.0)
    v_y, w_y = _add(zero, scale, _cross(b, N)), _add(zero, scale, _cross(N, a))
    return N, _add(zero, scale, normal), (
        _add(_add(zero, N_v[0], v_y), N_w[0], w_y),
        _add(_add(zero, N_v[1], v_y), N_w[1], w_y),
        _add(_add(zero, N_v[2], v_y), N_w[2], w_y))
