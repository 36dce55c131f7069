"""The foot of a body that stands: the plane faces on which it does, and the size that its contact is judged by.

A body on a foot narrower than itself, such as a pole, tilts on its springs, and what it tilts by takes from the lever arm
of its weight. They are as stiff as those of a cube on that foot, so that the arm is shorter by the same share.

A body with plane faces that does not lie flat stands on an edge or a corner (`stands_on_edge`): soil is in contact there
with one row of places, on one face of the body, whose normal is not that of the ground.
"""

import numpy as np

from hybrid.scene.ground import heights_at
from hybrid.soil.points import extent

STANDS = 20.0       # times W h, h the height of its centre: stiffness by which a body keeps upright, which needs once
LEANS = np.cos(np.radians(30.0))    # cosine to the vertical of the normal of a foot
ALIKE = 1e-4                        # of unit normals; of the radius: faces in one plane
TOUCHES = 0.125     # of a cell over its lowest vertex: what lies flat; the spacing of places of contact on elastic soil
MOSTLY = 0.5        # of a face that does, and of a cell, or of the body where that is less, across which it does
TURNS = 36                          # directions in half a turn that widths are measured along


def sides_of_contact(size, surface, rotation, collapsed):
    """Lengths [m] of what a body of a `size` [m] is judged by across its foot, least first: two in space, one in plane
    strain; the size where it has no foot. rotation: (3, 3) at the start; collapsed: (3,) bool axes."""
    dimensions = 3 - int(np.sum(collapsed))
    widths = _widths(surface, rotation, collapsed)
    return tuple(min(size, np.sqrt(dimensions) * width) for width in widths) or (size,) * (dimensions - 1)


def stands_on_edge(body, motion, soil):
    """Whether a body at its BodyState, which is not in the soil by more than a cell, is lowest over the ground with an edge
    or a corner, and not with a plane face."""
    surface, cell, top = body.surface, soil.grid.smallest_cell, extent(soil.constants, 2)[1]
    vertices = surface.vertices @ motion.rotation.T + motion.position
    ground = top if soil.heights is None else np.minimum(heights_at(soil.heights[0], vertices[:, :2]), top)
    above = vertices[:, 2] - ground
    if above.min() < -cell:
        return False
    low, level = above < above.min() + TOUCHES * cell, vertices[:, :2][:, ~soil.grid.collapsed[:2]]
    from_middle = level[low] - level[low].mean(axis=0)
    axes = np.linalg.eigh(from_middle.T @ from_middle)[1]      # in columns
    widths, whole = np.ptp(level[low] @ axes, axis=0), np.ptp(level @ axes, axis=0)
    if (widths < MOSTLY * np.minimum(cell, whole)).any():       # a chamfer is a face too
        return True
    flat = low[surface.triangles].all(axis=1)
    area = 0.5 * np.linalg.norm(np.cross(*np.moveaxis(np.diff(surface.vertices[surface.triangles], axis=1), 1, 0)), axis=1)
    if not flat.any():
        return True
    largest = int(np.argmax(np.where(flat, area, 0.0)))
    normal, centres = surface.normals[largest], surface.vertices[surface.triangles].mean(axis=1)
    face = surface.normals @ normal > 1.0 - ALIKE
    face &= np.abs((centres - centres[largest]) @ normal) < ALIKE * body.radius
    return bool(area[flat & face].sum() < MOSTLY * area[face].sum())


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
