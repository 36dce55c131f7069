"""Overlap of two rigid bodies: refused at the start."""

import numpy as np

from hybrid.body import rigid
from hybrid.contact.search import distances

ALLOWED_OVERLAP = 1e-3  # radii that two bodies may overlap, as facets of curved bodies that touch do


def depth_of_overlap(one, other, collapsed):
    """Depth [m] of the deepest place of either body found in the other one, 0 where they are apart.

    one, other: (RigidBody, BodyState); collapsed: (3,) bool, axes along which only their sections count.
    """
    (body, pose), (second, place) = one, other
    apart = np.where(collapsed, 0.0, place.position - pose.position)
    if np.linalg.norm(apart) > body.radius + second.radius:
        return 0.0
    return max(_depth(body, pose, second, place, collapsed), _depth(second, place, body, pose, collapsed))


def _depth(one, pose, other, place, collapsed):
    """Depth [m] in the `other` body of the deepest of some places in `one`: its vertices, what is over the middles of its
    edges and facets on its smooth surface, as those of the facets of a bore are in the air, and places a little below the
    latter, as bodies at the same place have all others in common."""
    surface = one.surface
    middle, edges = _middles(surface)
    below = middle - 2 * ALLOWED_OVERLAP * one.radius * surface.normals
    below = below[distances(below, surface)[0] < 0.0]
    position = pose.position + np.concatenate([surface.vertices, middle, below, edges]) @ pose.rotation.T
    y = (np.where(collapsed, place.position, position) - place.position) @ place.rotation
    y = y[((y > other.surface.lower) & (y < other.surface.upper)).all(axis=1)]
    return float(np.max(-distances(y, other.surface)[0], initial=0.0)) if len(y) else 0.0


def _middles(surface):
    """Places (F, 3) and (3 F, 3) [m] of a smooth surface over the middles of its facets and of their edges."""
    corners, nodes = surface.vertices[surface.triangles], surface.tree.patches.nodes
    curvature = nodes[:, 6:] if len(nodes) else np.zeros_like(corners)
    edges = 0.5 * (corners + np.roll(corners, -1, axis=1)) - 0.25 * curvature
    return corners.mean(axis=1) - curvature.sum(axis=1) / 9.0, edges.reshape(-1, 3)


def volume_of_overlap(one, other):
    """Volume [m³] that two bodies, each (RigidBody, BodyState), share: by 24³ points at equal distances in the common part
    of their boxes."""
    boxes = np.array([rigid.bounding_box(*pair) for pair in (one, other)])
    lower, upper = boxes[:, 0].max(axis=0), boxes[:, 1].min(axis=0)
    steps = [low + (np.arange(24) + 0.5) / 24 * (high - low) for low, high in zip(lower, upper)]
    points, inside = np.stack([axis.ravel() for axis in np.meshgrid(*steps)], axis=1), True
    for body, pose in (one, other):
        inside &= distances((points - pose.position) @ pose.rotation, body.outline)[0] < 0.0
    return float(np.mean(inside) * np.prod(upper - lower))
