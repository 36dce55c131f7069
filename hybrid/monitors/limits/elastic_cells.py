"""Contact on soil that is elastic, or hardly yields, on few cells: spheres pressed into elastic soil are too stiff, bases on
soil that can yield too soft.

Excess [%] of the force of a smooth sphere pressed into a block 40 contact radii wide and deep by δ = a²/R, a up to 0.1 R,
ν = 0.3, over 4/3 E/(1 - ν²) √(R δ³), at three places of its axis between a node and the middle of a cell; 3.6 % of them
are the block's and those of strains that are not small:

| a/h        | 0.75 | 1.06 | 1.3 | 1.5 |  2 | 3 |
|------------|------|------|-----|-----|----|---|
| node       | 33   | 29   | 22  | 14  | 10 | 6 |
| between    | 47   | 25   | 17  | 14  |    |   |
| mid cell   | 62   | 17   | 15  | 16  |    |   |

a is the radius of contact, h the cell. A sphere that carries a given load sinks in by less, as δ goes with the power 2/3
of the force. A flat disc of 5 cells in its radius has no such excess: 1 % pressed, 5 % rocked, -7 % turned about its axis.

Soil that can yield has contact springs of 20/h, whose overlap is out of sight where it flows (`hybrid.setup.penalty`). As
long as it does not, they let a base sink in at its edges. Displacement [%] above that with 500/h, which is the same with 4
and 8 cells, of a square and a strip on clay, n cells in the width, far below what they can carry:

| n                  |  4 |  8 | 16 | law    |
|--------------------|----|----|----|--------|
| square, pressed    | 28 | 14 |    | 1.15/n |
| square, tilted     | 66 | 29 |    | 2.6/n  |
| strip, pressed     |  8 |  4 |  2 | 0.35/n |
| strip, tilted      | 37 | 22 | 15 | 1.6/n  |
| disc, pressed      | 17 |  8 |    | 0.68/n |
| disc, tilted       | 64 | 30 |    | 2.6/n  |

Pressed with a third of what it can carry the square has 28 and 15 % too. What joints hand on is not known before the run:
legs of 1 m, two cells wide, under a hull of 5.4 t settle by 4.29 mm with these springs and by 2.66 mm with 500/h.
"""

import numpy as np

from hybrid.body.guides import forces_of
from hybrid.body.paths import travel_along
from hybrid.body.symmetry import copies
from hybrid.laws.von_mises import BEARING
from hybrid.monitors.limits.cell_size import EXCESS
from hybrid.monitors.limits.loading import Loading, loadings
from hybrid.monitors.limits.materials import CLAY, material_at
from hybrid.monitors.limits.rolling import contact_radius
from hybrid.monitors.limits.shape import is_round, leads, narrowest, sides
from hybrid.monitors.limits.start import covers, outline, top_of
from hybrid.monitors.limits.travels import bodies_joined_to

HIGHEST = ((0.75, 0.58), (1.06, 0.26), (1.3, 0.18), (1.6, 0.1))     # (a/h, excess [-] at the worst place in a cell)
SOFT = {False: (1.15, 2.6), True: (0.35, 1.6)}  # pressed and tilted, in space and in plane strain
ROUND = 0.68                    # pressed
SOFTEST, STIFF = 40.0, 500.0        # p_f h: of stiffer ones nothing is reported; of those that are right
COARSE, RESOLVED = HIGHEST[0][0], HIGHEST[-1][0]                    # a/h


def unresolved_contact(scene, model):
    """Spheres driven into elastic soil, or loaded on it, with so few cells in the radius of contact that the force is too
    high by up to EXCESS, or the travel too short."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.any():
        return
    material, cell = material_at(scene, soil, top_of(soil)), soil.grid.resolution
    if material.law != "hencky":
        return
    for described, body in zip(scene.bodies, model.bodies):
        whole, place = outline(described, body, soil)
        distance = np.linalg.norm(place - 0.5 * (place.min(axis=0) + place.max(axis=0)), axis=1)
        if not is_round(whole.surface, distance):
            continue
        radius, travel = distance.mean(), travel_along(scene, described, "z")
        driven = travel < 0.0 and body.guided[2]
        a = _driven(soil, place, travel, radius) if driven else _loaded(scene, model, body, radius, material)
        if 0.0 < a < RESOLVED * cell * (1 - 1e-6):
            yield _text(body, a, cell, driven)


def _driven(soil, place, travel, radius):
    """Radius of contact [m] of a sphere with its vertices at `place` at the end of its `travel` [m]."""
    depth = top_of(soil) - place[:, 2].min() - travel
    return np.sqrt(np.clip(depth, 0.0, radius) * radius)


def _loaded(scene, model, body, radius, material):
    """That of one that is free to follow a load, or without inertia its weight; 0 of others."""
    if not body.free[2]:
        return 0.0
    force = max((-values[:, 2].min() for values in forces_of(body)), default=0.0)
    force += 0.0 if model.scheme.inertia and not force else body.mass.mass * -scene.gravity[2]
    return contact_radius(copies(body.mirrors) * force, radius, material, model.soil) if force > 0.0 else 0.0


def _text(body, a, cell, driven):
    """Text about a contact with a radius `a` [m] on cells of `cell` [m]."""
    excess = np.interp(a / cell, *np.transpose(HIGHEST))
    words = f"up to {excess:.0%} above Hertz's" if a >= COARSE * cell else f"{excess:.0%} above Hertz's, or more"
    effect = (f"its force is {words}" if driven else
              f"the force at a depth is {words}, so that it sinks in by up to {1 - (1 + excess)**(-2 / 3):.0%} too little")
    return (f"{body.name} is pressed into elastic soil on a contact with a radius of {a:.2g} m, {a / cell:.2g} cells of "
            f"{cell:.3g} m, limit {RESOLVED:g}: {effect}, limit {EXCESS:.0%}, by where it stands in a cell. Use cells of at "
            f"most {a / RESOLVED:.2g} m under it")


def soft_springs(scene, model):
    """Bodies pressed on soil that can yield, by less than it carries, on so few cells that they settle or tilt by EXCESS too
    much."""
    soil, down = model.soil, np.array([0.0, 0.0, -1.0])
    if soil.held or soil.grid.collapsed.sum() > 1 or soil.grid.collapsed[2]:
        return
    pressed = loadings(scene, model)
    known = {found.body.name for found in pressed}
    pressed += [] if model.scheme.inertia else _under_joints(scene, model, known)
    for body, travel, place, plane, by_force, _, arm in pressed:
        cell, width, bottom = soil.grid.resolution, narrowest(soil.grid, place, down), place[:, 2].min()
        stands = plane and width > 0.0 and bottom < top_of(soil) + cell and travel[2] < 0.0
        depth = None
        if not by_force:
            depth = -travel[2] + min(top_of(soil) - bottom, 0.0)    # of that what is in the soil
            stands &= depth > 0.0
        lid = covers(place, soil)      # of a specimen, which is as soft as its soil
        if not stands or lid or body.places.at_corners or body.penalty * cell > SOFTEST:
            continue
        space = not soil.grid.collapsed.any()
        settled, tilted = SOFT[not space]
        if space and not any(leads(body, place, side.direction) for side in sides(soil.grid, place, down)):
            settled = ROUND
        moves = {"settles": settled * cell / width, "tilts": (arm > 0.0) * tilted * cell / width}
        excess = max(moves.values())
        material = material_at(scene, soil, bottom - 0.5 * cell)
        if excess > EXCESS and (body.name not in known or _little(body, material, depth, width)):
            does = " and ".join(f"{how} by about {much:.0%}" for how, much in moves.items() if much > EXCESS)
            yield (f"{body.name} is pressed on soil that can yield, on a base {width / cell:.2g} cells of {cell:.3g} m "
                   f"wide, with soft contact springs: as long as the soil hardly yields it {does} too "
                   f"much, limit {EXCESS:.0%}. Set body.penalty = {STIFF / cell:.4g}, which takes more iterations where the "
                   f"soil flows, or use cells of at most {EXCESS / excess * cell:.2g} m under it")


def _under_joints(scene, model, known):
    """[Loading] as of bodies `loaded` along z, those of which it is not `known` because joints hand on to them what others
    carry."""
    found = []
    for i, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        if bodies_joined_to(scene, i) - {None} and body.free[2] and body.name not in known:
            whole, place = outline(described, body, model.soil)
            travel = np.array([0.0, 0.0, -1.0])
            found.append(Loading(whole, travel, place, leads(whole, place, travel), by_force=True))
    return found


def _little(body, material, depth, width):
    """Whether a base of a `width` [m] is driven by a `depth` [m], or pressed by forces, None, of which soil carries most
    without yielding. Of sand only forces count, whatever they are."""
    if material.law != CLAY:
        return depth is None
    return body.below_capacity if depth is None else depth < BEARING * material.strength * width / (material.young or np.inf)


LIMITS = (unresolved_contact, soft_springs)
