"""Limits of bodies and of their contact with soil."""

import numpy as np

from hybrid.body.attitude import rotation_from_axis_angle

SOFT = 10.0     # p_f times the depth that a body presses: below it contact takes a tenth of the way (failure, penalty)
STUCK = 0.3     # ε_T/ε_N: below it a rolling sphere creeps by 5 % and more (failure, stick)

NARROW = 2.0    # spacings of corners: below it rows of them under a body come and go by chance (failure, thin, nails)

LIGHT = 1.5     # rows of cells under a body: lighter ones are thrown back by the nodes they hit (failure, light)


def soft(scene, model):
    """Penalties so low that contact gives way instead of the soil: springs in series, 1/p_f against their depth."""
    if model.soil.held:
        return
    soil, across = model.soil.constants, ~model.soil.grid.collapsed[:2]
    deep = float((soil.position + soil.half_width)[:, 2].max() - (soil.position - soil.half_width)[:, 2].min())
    for described, body in zip(scene.bodies, model.bodies):
        depth = min([deep, *np.ptp(started(described, body), axis=0)[:2][across]])
        stiff = described.penalty * depth
        if stiff < SOFT and not body.augmented:
            yield (f"{body.name}: penalty {described.penalty:g} /m over a depth of {depth:.3g} m makes {stiff:.3g}, "
                   f"limit {SOFT:g}: contact takes {1 / (1 + stiff):.0%} of what the soil should give. Set "
                   f'body.penalty to {SOFT / depth:.3g} or more, or body.enforcement = "augmented"')


def creeping(scene, model):
    """Springs of stuck friction so soft that what rolls or sticks creeps."""
    for body in model.bodies:
        if body.friction > 0 and body.tangential < STUCK:
            yield (f"{body.name}: tangential {body.tangential:g} of the normal stiffness, limit {STUCK:g}: what sticks "
                   "creeps, a rolling sphere by 5 % of its way and more. Set body.tangential to 1")


def narrow(scene, model):
    """Bodies that the corners of the soil see more or less of by chance."""
    half, across = model.soil.constants.half_width, ~model.soil.grid.collapsed[:2]
    if model.soil.basis != "gimp" or not across.any():
        return
    spacing, cell = 2 * float(half[:, :2][:, across].min()), model.soil.grid.smallest_cell
    for described, body in zip(scene.bodies, model.bodies):
        if body.second_pass == 1.0:
            continue
        width = _width(started(described, body)[:, :2] * across)
        if width < NARROW * spacing:
            yield (f"{body.name} is {width:.3g} m narrow, {width / spacing:.2g} spacings of corners, limit {NARROW:g}: "
                   "the first pass of contact sees more or less of it by chance, or nothing. Set body.second_pass = 1, "
                   f"or cells of at most {cell * width / (NARROW * spacing):.2g} m")


def light_body(scene, model):
    """Free bodies lighter than the soil that an impact sets in motion first."""
    soil, grid = model.soil, model.soil.grid
    if soil.held or not model.scheme.inertia:
        return
    density = float(soil.constants.mass.sum() / soil.constants.volume.sum())
    for described, body in zip(scene.bodies, model.bodies):
        across = np.minimum(np.ptp(started(described, body), axis=0), np.ptp(grid.extent, axis=1))[:2]
        rows = body.mass.mass / (density * across.prod() * grid.smallest_cell)
        if rows < LIGHT and body.free[:3].any():
            yield (f"{body.name} has the mass of {rows:.2g} rows of cells under it, limit {LIGHT:g}: where it falls on "
                   "the soil it is thrown back. Use cells of a size of "
                   f"{grid.smallest_cell * rows / LIGHT:.2g} m at most, drive it, or set time.inertia = false")


def beyond(scene, model):
    """Bodies that are driven or pulled past the end of the grid."""
    for described, body in zip(scene.bodies, model.bodies):
        place = started(described, body)
        for axis, name in enumerate("xyz"):
            way, grid = _way(scene, described, name), getattr(scene.grid, name)
            side, end = ("end", grid.end) if way > 0 else ("start", grid.start)
            at = (place.max(axis=0) if way > 0 else place.min(axis=0))[axis]
            passes = (at - end) * way < 0 < (at + way - end) * way
            if not passes or grid.collapsed or (name == "z" and way > 0):
                continue
            yield (f"{body.name} will have come to {name} = {at + way:.3g} m when the stages end, limit {name} = "
                   f"{end:g} m, where the grid does: there is no soil beyond. Move grid.{name}.{side} outwards (with "
                   f"grid.{name}.window a long grid costs no more than a short one), or take fewer stage.steps")


def _way(scene, described, name):
    """Way [m] that a body is driven, or its line pulled, along an axis in all stages."""
    axis, way = "xyz".index(name), 0.0
    for stage in scene.stages:
        length = stage.steps * (stage.step or scene.time.step)
        if name in described.driven and name not in stage.held:
            way += described.velocity[axis] * length
        elif described.pull and stage.pull and name not in {*stage.held, *described.held, *described.driven}:
            way += described.pull.velocity[axis] * length
    return way


def _width(place):
    """Smallest width [m] of places (V, 2) between parallel lines; an axis along which all are 0 does not count."""
    turn = np.linspace(0.0, np.pi, 37)[:-1]
    widths = np.ptp(place @ np.array([np.cos(turn), np.sin(turn)]), axis=0)
    return float(widths.min() if np.ptp(place, axis=0).all() else widths.max())


def started(described, body):
    """Vertices (V, 3) [m] of a body's surface where it starts."""
    rotation = np.eye(3)
    if described.rotation:
        rotation = rotation_from_axis_angle(described.rotation[:3], np.radians(described.rotation[3]))
    place = np.array(described.position or (0.0, 0.0, 0.0)) + (body.surface.vertices + body.mass.centre) @ rotation.T
    if described.rest_on is not None:
        place[:, 2] += described.rest_on - place[:, 2].min()
    return place


LIMITS = (soft, creeping, narrow, light_body, beyond)
