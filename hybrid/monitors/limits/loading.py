"""How bodies load the soil: which are driven where, their travel, or pushed by which force, with a plane face ahead or not.
"""

from typing import NamedTuple

import numpy as np

from hybrid.body.rigid import FREEDOMS, RigidBody
from hybrid.body.symmetry import copies
from hybrid.monitors.limits.materials import CLAY, material_at
from hybrid.monitors.limits.shape import PLANE, faces, leading_normal, leads, narrowest
from hybrid.monitors.limits.start import initial_pose, initial_vertices, outline, stands_on, top_of
from hybrid.monitors.limits.travels import bodies_joined_to, moved_at_points, travels, travels_of

# Cosine between a travel and the normal of the plane face that leads: a plate moved at 11° to its normal bears 3 % less
ASKEW = 0.75
# Share of a load across its main direction, or of the size that it acts beside the centre: inclined or eccentric
ASIDE = 0.05 * (1.0 + 1e-6)     # not decided by round-off
PUSHED = 5.0                    # s_u: pipes and balls deep in clay carry 9 to 13
HARDLY = 2.0                    # s_u B/E of travel: a strip then bears half of what it can, a plate in deep clay a quarter


class Loading(NamedTuple):
    """How a body loads the soil.

    body      RigidBody with the surface of the whole body
    travel    (3,) [m]; of one that forces push the part [N] of the largest force that is normal to an inclined base, else
              its largest component
    place     (V, 3) [m] of its vertices where it begins
    plane     whether a plane face leads
    by_force  whether forces push it, and how far it goes is not known
    inclined  whether their resultant is, or it is driven along the ground under them
    arm       [m] on which that acts beside the centre, of the base where it presses that
    """

    body: RigidBody
    travel: np.ndarray
    place: np.ndarray
    plane: bool
    by_force: bool = False
    inclined: bool = False
    arm: float = 0.0


def driven(scene, model):
    """Loading by each travel of each body that is driven, or that joints, lines or other bodies move (`travels`), and that
    gets to the soil."""
    if model.soil.held or not model.soil.law.plastic:
        return
    for number, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        ways = travels(scene, model, number)
        whole, place = outline(described, body, model.soil) if ways else (None, None)
        for start, travel in ways:
            if _gets_to(model.soil, place + start, travel):
                straight = _straight(whole, place, travel)
                lower = np.array([0.0, 0.0, min(travel[2] - straight[2], 0.0)])     # it goes forwards as deep as in the end
                yield Loading(whole, straight, place + start + lower, leads(whole, place, straight))


def _gets_to(soil, place, travel):
    """Whether a body with its vertices at `place` (V, 3) [m] gets as low as the soil on its travel."""
    return soil.grid.collapsed[2] or place[:, 2].min() + min(travel[2], 0.0) < top_of(soil) + soil.grid.smallest_cell


def _straight(body, place, travel):
    """A travel that is a little askew to an axis of the grid, along which a plane face leads, without what goes along that
    face and hardly loads it; any other one as it is."""
    normal = leading_normal(body, place, travel)
    if normal is None or np.abs(normal).max() < PLANE:
        return travel
    axis = np.where(np.abs(normal) > PLANE, np.sign(normal), 0.0)
    return (axis @ travel) * axis if axis @ travel > ASKEW * np.linalg.norm(travel) else travel


def loaded(scene, model):
    """Loading by each body that is free to follow forces of a stage, its own and those of bodies that stand on it, or that a
    point of it drives, and that neither another body nor the ground carries above the soil."""
    if model.soil.held or not model.soil.law.plastic:
        return
    outlines = [outline(described, body, model.soil) for described, body in zip(scene.bodies, model.bodies)]
    above = [place[:, 2].min() > top_of(model.soil) + model.soil.grid.smallest_cell for _, place in outlines]
    for i, (described, body, (whole, place)) in enumerate(zip(scene.bodies, model.bodies, outlines)):
        if above[i] and body.name in scene.joined:
            continue        # others carry it, or the ground
        centre, rotation = initial_pose(described, body)
        force, moment, free = _largest_load(scene, body, rotation)
        force = force + (0.0, 0.0, _handed_on(scene, model, outlines, i))
        axis = int(np.argmax(np.abs(force)))
        if not force[axis] or not free[axis] or model.soil.grid.collapsed[axis] or moved_at_points(body)[axis]:
            continue
        below = centre - (0.0, 0.0, body.surface.extent(-rotation[2]))
        on_base = _on_base(whole, initial_vertices(described, whole), force)
        pressing, middle = on_base or (np.where(np.arange(3) == axis, force, 0.0), below)
        aside = np.abs(np.where(free[:3], force - pressing, 0.0)).max() > ASIDE * np.linalg.norm(pressing)
        inclined = aside or bool(axis == 2 and any(way[:2].any() for _, way in travels_of(
            scene, described, model.soil.grid.collapsed)))      # or driven along the ground under it
        if axis == 2 and force[2] < 0.0:    # about the middle of the base
            moment = moment + np.cross(centre - middle, force)
        travel = _over_level_ground(whole, place, pressing) if on_base else pressing
        arm = 0.0       # where the ground or others that touch soil share a moment: how, the soil decides
        if all(j is not None and above[j] for j in bodies_joined_to(scene, i)):
            arm = np.abs(np.where(free[3:], moment, 0.0)).max() / np.linalg.norm(travel)
        yield Loading(whole, travel, place, leads(whole, place, travel), True, inclined,
                      arm if arm > ASIDE * np.ptp(place[:, ~model.soil.grid.collapsed], axis=0).max() else 0.0)


def _handed_on(scene, model, outlines, number):
    """Vertical force [N] of stages on bodies that stand on the one of this `number`, not of joined ones, whose moments
    joints hand on; outlines: (RigidBody, places) of all."""
    return sum(_largest_load(scene, body, initial_pose(scene.bodies[j], body)[1])[0][2]
               for j, (body, (_, place)) in enumerate(zip(model.bodies, outlines))
               if j != number and body.name not in scene.joined and stands_on(place, outlines[number][1]))


def _on_base(body, place, force):
    """(Part of a force (3,) [N] normal to the inclined plane base that it presses, middle (3,) [m] of that base); None of
    others, whose force is that along an axis of the grid."""
    normal = leading_normal(body, place, force)
    if normal is None or np.abs(normal).max() > PLANE or normal @ force < ASKEW * np.linalg.norm(force):
        return None
    normals, area = faces(body, place)
    base = np.where(normals @ normal > PLANE * area, area, 0.0)
    return normal @ force * normal, base @ place[body.surface.triangles].mean(axis=1) / base.sum()


def _over_level_ground(body, place, force):
    """A force (3,) [N] normal to an inclined base as one normal to it with its vertices at `place`, over level ground."""
    normal = leading_normal(body, place, force)
    return force if normal is None else np.linalg.norm(force) * normal


def loadings(scene, model):
    """[Loading] by all bodies: those that are driven, then those that forces push."""
    return [*driven(scene, model), *loaded(scene, model)]


def to_failure(scene, model, found):
    """[Loading] of those `found` without the bodies that are driven through clay by so little that it hardly yields."""
    return [each for each in found if each.by_force or not _hardly(scene, model.soil, each)]


def _hardly(scene, soil, found):
    """Whether a Loading moves a body through clay by less than HARDLY."""
    material = material_at(scene, soil, found.place[:, 2].mean())
    if material.law != CLAY or not material.young:
        return False
    width = narrowest(soil.grid, found.place, found.travel)
    return bool(np.linalg.norm(found.travel) < HARDLY * (material.strength or 0.0) * width / material.young)


def through_clay(scene, model):
    """Loading by each driven body, and by each that forces of a stage push by PUSHED of its area across them and more, where
    clay flows around it; the travel [m] is then a cell."""
    yield from to_failure(scene, model, driven(scene, model))
    grid = model.soil.grid
    for found in loaded(scene, model):
        body, force, place, *_ = found
        size = np.minimum(np.ptp(place, axis=0), np.ptp(grid.extent, axis=1))
        strength = material_at(scene, model.soil, place[:, 2].mean()).strength or np.inf
        whole = copies(body.mirrors) * np.linalg.norm(force)
        if whole > PUSHED * strength * np.prod(size[force == 0.0]):
            yield found._replace(travel=grid.smallest_cell * force / np.linalg.norm(force))


def _largest_row(table):
    """Row (3,) of the values of a Table that has the largest norm."""
    return table.values[np.argmax(np.linalg.norm(table.values, axis=1))]


def _change(guide):
    """What is largest in the table of a Guide's rate, or by how much that of its displacement changes, with its sign."""
    return _largest_row(guide.table)[0] if guide.is_rate else guide.table.values[-1, 0] - guide.table.values[0, 0]


def _largest_load(scene, body, rotation):
    """(force [N] (3,), moment [N m] about the centre (3,), free components (6,)) of the stage that loads a body at a
    `rotation` (3, 3) most, moments over its radius, at the rows of its tables that are largest. A stage that drives points
    of it has the forces of 1 N along their travels."""
    found = [(np.zeros(3), np.zeros(3), body.free)]
    for stage, described in zip(body.stages or (), scene.stages):
        force, moment = np.zeros(3), np.zeros(3)
        for driven_point in stage.points:
            one = np.where(np.arange(3) == driven_point.guide.component, np.sign(_change(driven_point.guide)), 0.0)
            force, moment = force + one, moment + np.cross(rotation @ driven_point.point, one)
        for load in stage.loads:
            one = np.zeros(3) if load.force is None else _largest_row(load.force)
            force, moment = force + one, moment + np.cross(rotation @ load.point, one)
            if load.moment is not None:
                moment = moment + _largest_row(load.moment)
        held = stage.held | stage.driven | np.isin(FREEDOMS, described.held)
        found.append((force, moment, (body.free | stage.released) & ~held))
    return max(found, key=lambda one: np.linalg.norm(one[0]) + np.linalg.norm(one[1]) / body.radius)
