"""Places on the sharp edges, corners and tips of a body, at which its contact with another body is evaluated.

On a curved edge x(s) = (1 - s) a + s b - s (1 - s) c, c of its patch; the normal of a place is the mean of the two faces'.
"""

import numpy as np

from hybrid.body.sharp_edges import SHARP_ANGLE
from hybrid.body.smooth import shared_edges

RIM = 4.0       # times the width of edges: of curved ones over held ground


def places_on_edges(surface, spacing, width, corner, sagitta):
    """Places (e, 3) [m] on sharp convex edges, at the corners where three of them end and at tips, normals (e, 3) there,
    areas (e,) [m²], and normals (e, 2, 3) of the curved faces beside them; arguments: those of
    `hybrid.contact.samples.sample`."""
    t, k = shared_edges(surface.triangles)
    ends = surface.triangles[t[:, 0], k[:, 0]], surface.triangles[t[:, 0], (k[:, 0] + 1) % 3]
    of_corner = surface.corner_normals
    start = of_corner[t[:, 0], k[:, 0]], of_corner[t[:, 1], (k[:, 1] + 1) % 3]
    end = of_corner[t[:, 0], (k[:, 0] + 1) % 3], of_corner[t[:, 1], k[:, 1]]
    corners = surface.vertices[surface.triangles]
    behind = corners[t[:, 1]].mean(axis=1) - corners[t[:, 0]].mean(axis=1)
    bend = np.minimum(*(np.arccos(np.clip(np.einsum("ei,ei->e", *pair), -1.0, 1.0)) for pair in (start, end)))
    chosen = np.flatnonzero((bend > SHARP_ANGLE) & (np.einsum("ei,ei->e", surface.normals[t[:, 0]], behind) < 0.0))
    found, turning = [], surface.turning
    for e in chosen:
        a, b = surface.vertices[ends[0][e]], surface.vertices[ends[1][e]]
        length = np.linalg.norm(b - a)
        bow = _bow(surface, t[e, 0], k[e, 0])
        count = max(1, int(np.ceil(length / spacing)), int(np.ceil(np.sqrt(np.linalg.norm(bow) / (4.0 * sagitta)))))
        s = (np.arange(count) + 0.5)[:, None] / count
        sides = (1 - s)[:, None] * np.stack([start[0][e], start[1][e]]) + s[:, None] * np.stack([end[0][e], end[1][e]])
        own = sides.sum(axis=1)
        rim = RIM if np.isfinite(sagitta) and bow.any() else 1.0
        found.append(((1 - s) * a + s * b - s * (1 - s) * bow, own / np.linalg.norm(own, axis=1)[:, None],
                      np.full(count, rim * width * length / count),
                      sides * turning[t[e]][:, None] / np.linalg.norm(sides, axis=2)[:, :, None]))
    found.append(_at_vertices(surface, np.concatenate([ends[0][chosen], ends[1][chosen]]), corner))
    return tuple(np.concatenate(each) for each in zip(*found))


def _at_vertices(surface, ends, corner):
    """The same at corners, with three sharp edges or more of those with these `ends` (2 e,), and at tips."""
    normal = np.zeros((len(surface.vertices), 3))
    np.add.at(normal, surface.triangles, surface.tree.normals[:, 4:7])      # of their features 4, 5, 6
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    at, count = np.unique(ends, return_counts=True)
    tips = np.setdiff1d(_tips(surface, normal), at)
    at = np.concatenate([at[count >= 3], tips])
    beside = [np.zeros((len(at) - len(tips), 2, 3)), *(_beside_tip(surface, tip) for tip in tips)]
    return surface.vertices[at], normal[at], np.full(len(at), corner), np.concatenate(beside)


def _tips(surface, normal):
    """Vertices (m,) of tips without edges, as of a cone: faces around them look far from a `normal` (V, 3) at the vertex and
    lie below it."""
    count = len(surface.vertices)
    along, low = np.ones(count), np.zeros(count, bool)
    looks = np.einsum("tki,tki->tk", surface.corner_normals, normal[surface.triangles])
    np.minimum.at(along, surface.triangles, looks)
    corners = surface.vertices[surface.triangles]
    for step in (1, 2):
        above = np.einsum("tki,tki->tk", np.roll(corners, -step, axis=1) - corners, normal[surface.triangles]) >= 0.0
        np.logical_or.at(low, surface.triangles, above)
    return np.flatnonzero((along < np.cos(SHARP_ANGLE)) & ~low)


def _beside_tip(surface, tip):
    """Normal (1, 2, 3), twice, of one of the curved faces at the vertex of a tip, 0 of plane ones."""
    t, k = np.argwhere(surface.triangles == tip)[0]
    return np.tile(surface.turning[t] * surface.corner_normals[t, k], (1, 2, 1))


def _bow(surface, t, k):
    """Curvature c (3,) [m] of an edge of a patch, 0 of a straight one."""
    nodes = surface.tree.patches.nodes
    return nodes[t, 6 + k] if len(nodes) else np.zeros(3)
