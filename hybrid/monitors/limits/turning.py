"""Bodies that are turned in soil that flows: torque of few cells, measured on bodies set up afresh.

    vane that clay sticks to                 (1 + 1.3/n)³        n cells in its diameter: 1.65, 1.43 with 7, 10;
                                                                  2.44 with 5, whose blades are a cell thick
    the same in plan view, z collapsed       (1 + 1.3/n)²        1.08 to 1.25 with 16, α = 0; 0.98 to 1.08 with 32
    round pile along which clay slips        -13, -6, +12 %      with 4, 6, 8 in its diameter, α = 0.5, length 1.5 D;
                                                                  -25 % with 4 where α = 1
    vane with its axis in the ground, all of  (1 + 2.6/n)²        1.4 to 1.7, 1.28 with 10, 20, of 2 π R² s_u
    it in clay, in plane strain
    footing or wall turned over              1 + 2.2/n           n cells in its width, or its depth if that is more
    footing in space                         1 + 2.6/n

Turned over about a horizontal axis, M/(s_u B²) of strips that clay sticks to, and M [kN m/m] of walls of 1.6 m, about their
head, in clay and in sand:

| n                            | 8     | 16    | 32    | towards |
|------------------------------|-------|-------|-------|---------|
| strip, about its base        | 0.989 | 0.883 | 0.828 | 0.77    |
| wall in clay, α = 0.5        | 101.2 | 91.7  | 85.9  | 81      |
| wall in sand                 | 134.5 | 122.4 |       |         |
| disc, M over π/4 s_u A D     | 1.33  |       |       | < 1     |

Between blades clay is sheared in the cell beyond them (`cells`), so that the torque is that of a body 1.3 cells larger.
Along a round body it slips, at its outline, and the torque depends on where lines of the grid cut that.
"""

import numpy as np

from hybrid.body.attitude import exp_so3
from hybrid.body.paths import driven_by
from hybrid.monitors.limits.base import hard_bases
from hybrid.monitors.limits.cell_size import EXCESS, ON_LINE, smaller_cells
from hybrid.monitors.limits.materials import CLAY, SAND, law_at, material_at
from hybrid.monitors.limits.shape import faces
from hybrid.monitors.limits.stages import displacement_per_step
from hybrid.monitors.limits.start import initial_pose, outline, top_of
from hybrid.soil.points import extent

SHEARED = 1.3                   # cells by which the sheared surface is wider, and longer, than the body
BLADES = 0.1                    # share of its surface with which a body pushes soil as it turns; of a round one 0
SLIPPING = 16.0                 # cells in the diameter of a round body, twice the most that were measured
SUNK = 0.05                     # of its width: depth of a round body up to which it stands on the ground
OVER, OVER_IN_SPACE = 2.2, 2.6  # of bodies turned over
BURIED = 2.6                    # cells by which a body all of which is in clay is wider, in plane strain
IN_SAND = 1.2                   # of a box of 1 m, half of it in sand: 24.8, 21.9 kN m with 4, 8 cells after 0.12 rad
# Of s_u/G [rad], and of the largest moment LARGEST s_u B² L, up to which clay under a strip is hardly more than elastic; and
# angle [rad] up to which sand is
FLOWS, LARGEST, TINY = 0.5, 0.77, 1e-4
# Cells under a body of 1 m, α = 1, 50 mm above the base, turned by 0.02 rad: 3.1, 1.57, 1.26 times 30 kN m with 0.5, 1, 2;
# and its height above that over its width
SQUEEZED, THIN = 3.0, 0.25
ANGLES = 61         # places looked at on the way of a body that is turned


def turned(scene, model):
    """Bodies in clay that are turned about z, or that a moment turns, with so few cells in them that the torque is more
    than EXCESS too high."""
    soil = model.soil
    if soil.held or not soil.law.plastic or soil.grid.collapsed[:2].any():
        return
    in_plan = soil.grid.collapsed[2]
    for described, body in zip(scene.bodies, model.bodies):
        if not _turns(scene, described, body, 2):       # of those about other axes `turned_over` tells
            continue
        whole, place = outline(described, body, soil)
        top = np.inf if in_plan else top_of(soil)       # what stands above the ground bears nothing
        place = np.column_stack([place[:, :2], np.minimum(place[:, 2], top)])
        middle = 0.5 * (place[:, 2].min() + place[:, 2].max())
        if middle >= top or law_at(scene, soil, middle) != CLAY:
            continue
        yield from _torque(whole, place, soil.grid.resolution, not in_plan)


def turned_over(scene, model):
    """Bodies on or in soil that are turned about a horizontal axis, or that a moment turns, with so few cells in them that
    the moment is more than EXCESS too high."""
    soil, collapsed = model.soil, model.soil.grid.collapsed
    if soil.held or not soil.law.plastic:
        return
    across = [axis for axis in range(2) if collapsed[axis] or not collapsed.any()]
    for number, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        whole, place = outline(described, body, soil)
        place = _widest(scene, model, number, place)
        top, bottom = top_of(soil), place[:, 2].min()
        cell, base = soil.grid.resolution, place[place[:, 2] <= max(top, bottom) + ON_LINE * soil.grid.resolution]
        above_base = bottom > max(soil.grid.extent[2, 0] + cell, extent(soil.constants, 2)[0] - ON_LINE * cell)
        if not above_base or bottom >= top + cell:      # beside all of the soil, or under it, as a tray that carries it
            continue
        material, deep = material_at(scene, soil, bottom - 0.5 * cell), not collapsed.any() and top - bottom > cell
        if material.law not in {CLAY, *SAND}:
            continue
        for axis in [axis for axis in across if _turns(scene, described, body, axis)]:
            width, buried = _width(place, top, axis, material, collapsed.any(), cell)
            factor = OVER if collapsed.any() else IN_SAND if deep and material.law != CLAY else OVER_IN_SPACE
            excess = factor * cell / width if width else 0.0
            excess = (1.0 + BURIED * cell / width)**2 - 1.0 if buried else excess
            strength = _strength(material, width, np.ptp(base[:, axis]))
            if excess > EXCESS and _pushes(whole, place, axis) > BLADES and _flows(scene, described, body, axis, *strength):
                yield (f"{body.name} is turned about {'xy'[axis]}, {width / cell:.2g} cells of {cell:.3g} m across: its "
                       f"moment, where soil flows under it, is up to {excess:.0%} too high, limit {EXCESS:.0%}, as it "
                       f"drives the next cells too. {smaller_cells(EXCESS / excess * cell, ' at it')}")


def turned_on_base(scene, model):
    """Bodies in soil that yields that are turned about a horizontal axis so near above a fixed base or a harder layer that
    the soil under their edges is squeezed out in few cells."""
    soil, collapsed = model.soil, model.soil.grid.collapsed
    if soil.held or not soil.law.plastic or collapsed[2]:
        return
    cell, bases = soil.grid.resolution, [(height, name) for height, name, _ in hard_bases(scene, model)]
    for described, body in zip(scene.bodies, model.bodies):
        place = outline(described, body, soil)[1]
        bottom = place[:, 2].min()
        height, name = max([base for base in bases if base[0] <= bottom], default=(-np.inf, ""))
        clear = (bottom - height) / cell
        if not ON_LINE < clear < SQUEEZED or bottom >= top_of(soil):
            continue
        thin = [bottom - height < THIN * np.ptp(place[:, 1 - axis]) and _turns(scene, described, body, axis)
                for axis in range(2) if collapsed[axis] or not collapsed.any()]
        if any(thin):
            yield (f"{body.name} is turned {clear:.2g} cells of {cell:.3g} m above the {name}, limit {SQUEEZED:g}: the soil "
                   "under its edges is squeezed out in so few cells that its moment is too high, by 26 % with two cells "
                   "there, 57 % with one, up to 3 times with half of one. "
                   f"{smaller_cells((bottom - height) / SQUEEZED, ' under it')}")


def _widest(scene, model, number, place):
    """`place` (V, 3) [m] of the vertices of a body where most of it is in the soil on the way on which stages turn it about
    a hinge to the ground, or about its held centre."""
    def engaged(place):     # about an `axis`
        below = place[place[:, 2] <= top_of(model.soil) + ON_LINE * model.soil.grid.resolution]
        return max(np.ptp(below[:, 1 - axis]), top_of(model.soil) - below[:, 2].min()) if len(below) else -np.inf

    body = model.bodies[number]
    hinges = [joint for joint in model.joints if joint.bodies == (number, None) and joint.at_point]
    centre, rotation = initial_pose(scene.bodies[number], body)
    if not hinges and body.free[[0, 2]].any() and body.free[[1, 2]].any():
        return place
    pivot = centre + rotation @ hinges[0].points[0] if hinges else centre
    for axis in range(2):
        turns = [_turn_of(scene, stage, scene.bodies[number], axis) for stage in scene.stages]
        ends = np.cumsum([0.0, *(turn for stage in turns for turn in stage)])
        angles = np.linspace(ends.min(), ends.max(), ANGLES) if np.ptp(ends) else ()
        turned = [pivot + (place - pivot) @ exp_so3(angle * np.eye(3)[axis]).T for angle in angles]
        place = max([place, *turned], key=engaged)
    return place


def _turn_of(scene, stage, described, axis):
    """[rad] by which Motions of a stage turn a body about x or y, from one row of their tables to the next."""
    length, name = stage.steps * scene.step_of(stage), f"r{'xy'[axis]}"
    for motion in stage.motions:
        if motion.body in (None, described.name) and motion.component == name:
            turned = driven_by(motion, length)
            yield from np.diff([0.0, *turned]) * (1.0 if motion.velocity is not None else np.pi / 180)


def _width(place, top, axis, material, in_plane, cell):
    """(Width [m] that counts of a body turned over about a horizontal axis, whether it is the diameter of one all of which
    is in clay, in plane strain)."""
    across, bottom = place[:, [1 - axis, 2]], place[:, 2].min()
    if in_plane and material.law == CLAY and across[:, 1].max() < top - cell:
        return np.ptp(across, axis=0).max(), True
    base = place[place[:, 2] <= max(top, bottom) + ON_LINE * cell]
    return max(np.ptp(base[:, 1 - axis]), top - bottom), False


def _strength(material, width, length):
    """(Angle [rad], moment [N m]) up to which a Material is hardly more than elastic under a base; of sand, no moment."""
    if material.law != CLAY or material.young is None:      # with `reference_young` it is not one number
        return TINY, 0.0
    angle = FLOWS * material.strength * 2.0 * (1.0 + material.poisson) / material.young
    return angle, FLOWS * LARGEST * material.strength * width**2 * length


def _flows(scene, described, body, axis, angle, moment):
    """Whether a body is turned by more than an `angle` [rad], or a moment of a stage in which it may turn is larger than
    `moment` [N m]."""
    turned = sum(stage.steps * displacement_per_step(scene, stage, described, f"r{'xy'[axis]}") for stage in scene.stages)
    return turned > angle or any(np.abs(values).max() > moment for values in _moments(scene, body, axis))


def _moments(scene, body, axis):
    """Moments [N m] about an axis in the stages that leave a body free to follow them."""
    return [load.moment.values[:, axis] for described, stage in zip(scene.stages, body.stages or ()) for load in stage.loads
            if load.moment is not None and f"r{'xyz'[axis]}" not in described.held and not stage.held[3 + axis]]


def _turns(scene, described, body, axis):
    """Whether a body is driven about an axis, or free to follow a moment of a stage about it."""
    if not body.guided[3 + axis]:
        return any(np.any(values) for values in _moments(scene, body, axis))
    return any(displacement_per_step(scene, stage, described, f"r{'xyz'[axis]}") > 0.0 for stage in scene.stages)


def _torque(body, place, cell, ends):
    """Text, if any, about the torque on a body with its vertices at `place` about z; ends: whether it has any."""
    sizes = np.ptp(place, axis=0)
    length, across = sizes[2], sizes[:2].max()
    begin = f"{body.name} is turned about z in clay, {across / cell:.2g} cells of {cell:.3g} m across"
    if _pushes(body, place, 2) > BLADES:
        longer = cell / length if ends else 0.0
        excess = (1.0 + SHEARED * cell / across) ** 2 * (1.0 + SHEARED * longer) - 1.0
        if excess > EXCESS:
            yield (f"{begin}, and shears it in the next cell: its torque is about {excess:.0%} too high, limit "
                   f"{EXCESS:.0%}, that of a body {SHEARED:g} cells wider{' and longer' * ends}. Use cells of at most "
                   f"{EXCESS / SHEARED / (2 / across + longer / cell):.2g} m at the body, or take the diameter as "
                   f"{across + SHEARED * cell:.3g} m {f'and the length as {length + SHEARED * cell:.3g} m ' * ends}"
                   "where s_u follows from the torque")
    elif body.interface and body.interface.adhesion and across < SLIPPING * cell and length > SUNK * across:
        yield (f"{begin}, limit {SLIPPING:g}, and the clay slips along its round side: the torque of a pile was 13 % and "
               "6 % too low with 4 and 6 cells, and 12 % too high with 8, with half the clay's strength on it. Use cells "
               f"of at most {across / SLIPPING:.2g} m at the body, or compare several sizes of cells")


def _pushes(body, place, axis):
    """Share of a body's surface that it moves towards the soil, or away from it, as it turns about an axis through the
    middle of its outline."""
    normal, area = faces(body, place)
    arm = place[body.surface.triangles].mean(axis=1) - 0.5 * (place.min(axis=0) + place.max(axis=0))
    travel = np.cross(np.eye(3)[axis], arm)
    travel /= np.maximum(np.linalg.norm(travel, axis=1), 1e-12 * np.ptp(place, axis=0).max())[:, None]
    return np.abs((normal * travel).sum(axis=1)).sum() / area.sum()


LIMITS = (turned, turned_over, turned_on_base)
