"""Whether soil that can yield bears what stages put on a body without flowing: contact may then be as stiff as on elastic
soil.

    V + 6 M/B < N A s_u/2      N = 1 + π - arcsin h + √(1 - h²),  h = 2 H/(A s_u) < 1,  in space 6/(2 + π) times that

for a force V down and H along, a moment M about the base, of an area A and a width B: the pressure at its edge if it were
spread in a line, against half of what clay bears under an inclined load (Green, J. Appl. Mech. 21 (1954) 367). Each of them
alone would let them act together up to 0.8 of what clay bears: strips on 8 cells, V = 0.48 of 5.14 s_u B, H = 0.46 s_u B,
M = 0.28 s_u B², then tilted by 0.6 to 0.7 of what finite elements have. Loads of bodies that stand above a body, or that
joints connect with it, count as its own: under 60 kN through a block on it, a strip with 0.5 kN of its own, which carries
100 kN, settled by 0.73 to 0.95 of the strip that has the 60 kN itself.
"""

import numpy as np

from hybrid.body.joints import connected
from hybrid.laws.user import is_of_user
from hybrid.laws.von_mises import BEARING
from hybrid.runtime.comm import minimum
from hybrid.soil.points import extent

TIPPED = 0.7    # moment that clay bears on a base, over s_u, its area and its width
USED = 0.5      # share of what soil bears from which on a base moves by flow more than by what is elastic
OTHER = 0.1     # share of a base that need not be plane, as fillets
FLUSH = 1e-3    # of a cell between a base and the soil on which it stands,
NEAR = 0.02     # and to which it comes down
NOTHING = 0.0, 0.0, 0.0     # force along z and across it, moment
LEVEL = 0.02    # sine of the angle between triangles of one plane, and of its size, their distance from it


def stands_on(body, motion, soil, gravity):
    """Whether a body, at its BodyState at the start, stands on level soil, and its weight presses it down."""
    if soil.held or soil.heights is not None or gravity[2] >= 0.0 or gravity[:2].any():
        return False
    gap = motion.position[2] - body.outline.extent(-motion.rotation[2]) - extent(soil.constants, 2)[1]
    return -FLUSH <= gap / soil.grid.smallest_cell <= NEAR


def undisturbed(number, placed, falling, carried):
    """Whether no other body of the `placed` (RigidBody, BodyState) than this one moves by a guide, a line or a velocity at
    the start, is one of the `falling`, or has loads, but for what loads those that are `carried` by it."""
    names = {placed[number][0].name, *(body.name for body, _, _ in carried)}     # whose loads count for it
    others = [(body, motion) for body, motion in placed if body.name != placed[number][0].name]
    moving = any(body.line or body.driven.any() or motion.velocity.any() or motion.spin.any() for body, motion in others)
    changed = any(control.points or control.released.any() or control.loads and body.name not in names
                  for body, _ in others for control in body.stages)
    return not (moving or changed or falling - {number})


def falling_bodies(placed, joints, soil):
    """Numbers of the bodies that are free to come down, and that neither a joint nor soil or a body under them holds."""
    boxes, near = [_box(*each) for each in placed], NEAR * soil.grid.smallest_cell
    top, held = extent(soil.constants, 2)[1], {number for joint in joints for number in joint.bodies}
    found = set()
    for number, (low, high) in enumerate(boxes):
        under = [top, *(end[2] for other, (start, end) in enumerate(boxes)
                        if other != number and (start < high)[:2].all() and (end > low)[:2].all() and start[2] < low[2])]
        if placed[number][0].free[2] and number not in held and low[2] > max(under) + near:
            found.add(number)
    return found


def carried_by_each(placed, joints, soil):
    """[[(RigidBody, BodyState, share [-])]] of the bodies that each of the `placed` (RigidBody, BodyState) carries: those
    that are above it, over it, and may come down, and those that joints connect with it, over any number of others. Bodies
    that reach down to the soil carry what is on them alone, and share what several of them carry."""
    boxes = [_box(*each) for each in placed]
    top = extent(soil.constants, 2)[1] + FLUSH * soil.grid.smallest_cell
    feet = {number for number, (low, _) in enumerate(boxes) if low[2] <= top}
    carried = [connected({number}, joints) | _above(number, placed, boxes) for number in range(len(placed))]
    feet_under = [sum(other in carried[foot] for foot in feet) for other in range(len(placed))]
    return [[(*placed[other], 1.0 / max(feet_under[other], 1)) for other in sorted(found - feet - {number})]
            for number, found in enumerate(carried)]


def _above(number, placed, boxes):
    """Numbers of the bodies that are above one, over it, and free to come down."""
    low, high = boxes[number]
    least = high[2] - FLUSH * (high[2] - low[2])
    return {other for other, (start, end) in enumerate(boxes)
            if placed[other][0].free[2] and start[2] > least and (start < high)[:2].all() and (end > low)[:2].all()}


def _box(body, motion):
    """Lowest and highest place [m] of a body along each axis."""
    place = motion.position + body.outline.vertices @ motion.rotation.T
    return place.min(axis=0), place.max(axis=0)


def bears(body, motion, soil, gravity, stands=False, carried=()):
    """Whether the cohesion of soil that can yield bears the forces of all stages and the weight of a body with a plane base,
    at its initial BodyState, and of its share of those `carried` by it, without flowing: friction bears more. stands:
    whether nothing but its weight presses one without such forces."""
    rotation, every = motion.rotation, [(body, motion, 1.0), *carried]
    base = motion.position - (0.0, 0.0, body.outline.extent(-rotation[2]))
    stages, bearers = [], every if stands else every[:1]
    if any(control.loads for each, _, _ in bearers for control in each.stages):
        stages = [[_largest_of(load, place, base, share) for control, place, share in controls for load in control.loads]
                  or [NOTHING] for controls in _by_stage(every)]
    elif stands and body.free[2]:
        stages = [[NOTHING]]
    filled = base_share(body.outline, rotation) if stages else 0.0
    guided = body.driven.any() or any(control.points for control in body.stages)
    if not filled or guided or not soil.law.plastic or is_of_user(soil.law):
        return False
    level = np.ptp(body.surface.vertices @ rotation.T, axis=0)
    part = 0.5 ** sum(not mirror.cut for mirror in body.mirrors)     # of the base, as of the load and the weight
    width = np.where(soil.grid.collapsed, np.ptp(soil.grid.extent, axis=1), level)[:2]
    most = USED * minimum(soil.law.shear_strength(0.0), np.inf) * part * filled * width.prod()
    down, along, moment = np.max([np.sum(loads, axis=0) for loads in stages], axis=0)
    for each, place, share in every:
        weight = share * each.mass.mass * np.linalg.norm(gravity)
        down += weight
        moment += weight * np.linalg.norm((place.position - base)[:2]) * (share == 1.0)
    narrow = width[~soil.grid.collapsed[:2]].min(initial=np.inf)
    if along >= most or moment >= TIPPED * most * narrow:
        return False
    factor = 1.0 + np.pi - np.arcsin(along / most) + np.sqrt(1.0 - (along / most) ** 2)
    if not soil.grid.collapsed.any():
        factor *= BEARING / (2.0 + np.pi)
    return bool(down + 6.0 * moment / narrow < factor * most)


def base_share(surface, rotation):
    """Share [-] of the rectangle around a surface, seen from below, that it covers; 0 where less than all but OTHER of what
    is seen is the plane of its lowest triangle."""
    corners, normals = surface.vertices @ rotation.T, surface.normals @ rotation.T
    triangles = corners[surface.triangles]
    edges, centres = np.diff(triangles, axis=1)[..., :2], triangles.mean(axis=1)
    below = np.where(normals[:, 2] < -LEVEL, 0.5 * np.abs(np.linalg.det(edges)), 0.0)
    covered, size = below.sum(), np.ptp(corners[:, :2], axis=0)
    if not covered:
        return 0.0
    lowest = np.argmin(np.where(below > 0.0, centres[:, 2], np.inf))
    normal, level = normals[lowest], np.abs((centres - centres[lowest]) @ normals[lowest])
    plane = below[(normals @ normal > 1.0 - LEVEL) & (level < LEVEL * size.min())].sum()
    return covered / size.prod() if plane > (1.0 - OTHER) * covered else 0.0


def _by_stage(every):
    """[[(StageControl, BodyState, share) of each body that one changes] of each stage] of bodies with their shares."""
    changed = [[(control, motion, share) for control in body.stages] for body, motion, share in every if body.stages]
    return [list(controls) for controls in zip(*changed)]


def _largest_of(load, motion, base, share):
    """Share of the largest force along z and across it [N], and of the moment across z about the `base` (3,) [m], of a
    PointLoad on a body at its BodyState; none of a moment that several share: how, the soil decides."""
    force, moment = (np.zeros((1, 3)) if table is None else table.values for table in (load.force, load.moment))
    arm = np.cross(motion.position + motion.rotation @ load.point - base, force)
    across = np.linalg.norm(arm[:, :2], axis=1).max() + np.linalg.norm(moment[:, :2], axis=1).max()
    return (share * np.abs(force[:, 2]).max(), share * np.linalg.norm(force[:, :2], axis=1).max(),
            across * (share == 1.0))
