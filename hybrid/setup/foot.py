"""The foot of a body that stands: the plane faces on which it does, and the size that its contact is judged by.

A body on a foot narrower than itself, such as a pole, tilts on its springs, and what it tilts by takes from the lever arm
of its weight. They are as stiff as those of a cube on that foot, so that the arm is shorter by the same share.
"""

import numpy as np

STANDS = 20.0       # times W h, h the height of its centre: stiffness by which a body keeps upright, which needs once
LEANS = np.cos(np.radians(30.0))    # cosine to the vertical of the normal of a foot
ALIKE = 1e-4                        # of unit normals; of the radius: faces in one plane
TURNS = 36                          # directions in half a turn that widths are measured along


def sides_of_contact(size, surface, rotation, collapsed):
    """Lengths [m] of what a body of a `size` [m] is judged by across its foot, least first: two in space, one in plane
    strain; the size where it has no foot. rotation: (3, 3) at the start; collapsed: (3,) bool axes."""
    dimensions = 3 - int(np.sum(collapsed))
    widths = _widths(surface, rotation, collapsed)
    return tuple(min(size, np.sqrt(dimensions) * width) for width in widths) or (size,) * (dimensions - 1)


def standing_stiffness(surface, rotation, collapsed, weight, thickness):
    """Least stiffness [N/m³] of springs under the foot of a body of a `weight` [N] on which it keeps upright, 0 without a
    foot: STANDS W h = k b³ c/12, b and c its widths; in plane strain c is the `thickness` [m] of the slice."""
    widths = _widths(surface, rotation, collapsed)
    if not widths:
        return 0.0
    height = 0.5 * np.ptp(surface.vertices @ rotation[2])
    return 12.0 * STANDS * weight * height / (widths[0]**3 * (thickness if len(widths) == 1 else widths[1]))


def standing_overlap(surface, rotation, collapsed):
    """Largest overlap δ [m] of a cylinder that lies on its curved side at which it keeps upright there: W/δ of its springs,
    3/2 of that in a small motion, along its width t, STANDS W h = t²/12 3 W/(2 δ)."""
    if collapsed.any():
        return np.inf
    extent = np.ptp(surface.vertices @ rotation.T, axis=0)
    return extent[:2].min()**2 / (4.0 * STANDS * extent[2])


def _widths(surface, rotation, collapsed):
    """Widths [m] of a body's foot, least first; none where it has no foot."""
    down = np.where(surface.turning, -1.0, -surface.normals @ rotation[2])
    if not down.max(initial=-1.0) > LEANS:
        return ()
    normal = surface.normals[down.argmax()]
    height = (surface.vertices[surface.triangles] @ normal).max(axis=1)
    lowest = height[down > down.max() - ALIKE].max()
    foot = (down > down.max() - ALIKE) & (height > lowest - ALIKE * surface.radius)
    across = surface.vertices[np.unique(surface.triangles[foot])] @ rotation[:2][~collapsed[:2]].T
    if across.shape[1] < 2:
        return tuple(np.ptp(across, axis=0))
    angle = np.pi / TURNS * np.arange(TURNS)
    widths = np.ptp(across @ np.array([np.cos(angle), np.sin(angle)]), axis=0)
    least = int(widths.argmin())
    return widths[least], widths[least - TURNS // 2]
