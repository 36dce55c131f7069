"""Soil that ends so near a body that is pressed into it that its failure mechanism does not fit: the load is too large.
That of a body that is lifted is too small.

Load of a strip of width B on clay over that far from all ends, 1.6 m wide with cells of 0.1 m, by the distance to a
roller beside it or a fixed base below:

    beside [B]     0.06   0.125   0.19   0.25   0.5       below [B]      0.19   0.25   0.31   0.5
    smooth         1.89   1.15    1.04   1.00   1.00      smooth         1.18   1.07   1.03   1.00
    rough           -     1.28     -     1.08   1.00      rough          1.50    -     1.19   1.05

The limits are those where it is a tenth too high. Of soil with cohesion and friction, φ = ψ = 30°, 1.77, 1.42, 1.12 with
0.375, 0.625, 1 B beside a smooth strip, 1.64, 1.31, 1.02 with 0.625, 1, 2 B beside a rough one, 1.71, 1.05 with 0.5, 1 B
below a smooth one: there limits grow with tan φ.

A blade 1 m deep that is pushed through clay has 10 and 36 to 60 % too much load where the soil ends 1 and 0.5 m ahead
of it, in sand of 32°, whose wedge reaches d tan(45° + φ/2) ahead, 25 to 29 and 60 %; a pipe deep in clay 16 % too little
with 0.5 of its diameter before and behind it, 4 % with one diameter.

A plate 1 m wide that is lifted takes the soil above it up along a roller, as a piston. Load [%] that is missing, by the
distance to the roller over the height H of the soil above the plate:

    clay, H = 1.4 B           0.07   0.18   0.36   0.54     sand, 33°, H = 1.4 B     0.07   0.2   0.36   0.54   0.7
                               83     54     16      0                                44    28     16      6     1
"""

import numpy as np

from hybrid.monitors.limits.base import hard_bases
from hybrid.monitors.limits.loading import driven, loadings
from hybrid.monitors.limits.materials import SAND, material_at
from hybrid.monitors.limits.start import covers, initial_vertices, top_of
from hybrid.runtime.comm import maximum
from hybrid.soil.points import extent

BESIDE = {True: 0.25, False: 0.15}  # widths of the body, by whether it is rough
BELOW = {True: 0.4, False: 0.25}
FRICTIONAL = {True: 1.2, False: 0.85}   # more beside it, and 0.7 of that below, with tan φ = tan 30°
DEEPER = 0.7
DOWN = 0.9      # share of the travel of a body that is pressed down
AHEAD = 1.0     # heights of a body in clay that is pushed sideways
LIFTED = 0.45   # heights of the soil above a body that is lifted, and at most a width
HEAVE, ROOM = 0.25, 0.5     # cells from the highest points to the surface, and above it that are no room


def narrow_margins(scene, model):
    """Bodies pressed down into soil that ends at a face of the grid beside or below them, nearer than their failure
    mechanism reaches."""
    for body, travel, place, _, by_force, *_ in loadings(scene, model):
        if travel[2] > -DOWN * np.linalg.norm(travel):
            continue
        rough = bool(body.friction > 0.0)
        top = maximum(model.soil.constants.position[:, 2]) + model.soil.grid.smallest_cell
        place = place[place[:, 2] + (0.0 if by_force else travel[2]) < top]     # what stays above the soil presses none
        if not len(place):
            continue
        found = list(_beside(scene, model.soil, place))
        width = min((width for width, *_ in found), default=np.inf)
        material = material_at(scene, model.soil, min(place[:, 2].min(), top_of(model.soil)))
        angle = material.friction_angle if material.law in SAND else 0.0
        more = FRICTIONAL[rough] * np.tan(np.radians(angle)) / np.tan(np.radians(30.0))
        beside, deep = BESIDE[rough] + more, BELOW[rough] + DEEPER * more
        for _, gap, where in found:
            if gap is not None and gap < beside * width:
                yield _text(body, width, gap, f"beside it at {where}", beside,
                            f"{where[0]}.window" if "window" in where else where[0])
        bottom, end = place[:, 2].min() + (0.0 if by_force else travel[2]), extent(model.soil.constants, 2)[0]
        below = bottom - end
        on_rock = any(end < height < bottom for height, *_ in hard_bases(scene, model))   # which the soil ends at, in truth
        ends_there = scene.grid.faces.z_min != "free" and not on_rock
        if np.isfinite(width) and -0.1 * width < below < deep * width and ends_there:
            yield _text(body, width, below, "below it" if by_force else "below it at the end of its path", deep, "z")


def narrow_above(scene, model):
    """Bodies lifted out of soil that ends at a face of the grid beside them, nearer than the soil that they lift reaches."""
    for body, travel, place, *_ in loadings(scene, model):
        above = top_of(model.soil) - place[:, 2].max()
        if travel[2] < DOWN * np.linalg.norm(travel) or above <= 0.0:
            continue
        for width, gap, where in _beside(scene, model.soil, place):
            limit = min(LIFTED * above, width)
            if gap is not None and gap < limit:
                yield (f"{body.name} is lifted out of soil that ends {gap:.3g} m beside it at {where}, limit {limit:.3g} m "
                       f"by the {above:.3g} m of soil above it: that soil goes up along the end as a piston, and the load "
                       "is too low, by 15 % with a third of that height beside the body, by up to half with a fifth. "
                       f"Move the end of grid.{where[0]} outwards, unless the soil is to end there")


def narrow_ahead(scene, model):
    """Bodies driven sideways through soil that ends ahead of them, or behind those that it covers, nearer than it is pushed
    aside."""
    soil, top = model.soil, top_of(model.soil)
    in_plan, base = soil.grid.collapsed[2], extent(soil.constants, 2)[0] + soil.grid.smallest_cell
    followed = next((initial_vertices(*each) for each in zip(scene.bodies, model.bodies)
                     if scene.grid.follow in (None, each[1].name)), None)
    for body, travel, place, *_ in driven(scene, model):
        axis = int(np.argmax(np.abs(travel)))
        if axis == 2 or abs(travel[axis]) < DOWN * np.linalg.norm(travel) or not in_plan and place[:, 2].min() < base:
            continue        # down; obliquely; a piston, which nothing gets around
        found, height = [], np.ptp(place[:, 1 - axis])
        covers_it = in_plan or top - place[:, 2].max() > np.ptp(place[:, 2])
        for side in (0, 1):
            ahead = (travel[axis] > 0.0) == bool(side)
            if ahead or covers_it:
                reach, gap, end = _room(scene, soil, followed, place, travel, axis, side)
                if gap >= 0.0 and (reach if not in_plan else height) > soil.grid.smallest_cell:
                    found.append((gap, reach if not in_plan else height, "ahead of" if ahead else "behind", end))
        gap, height, where, (at, remedy) = min(found, default=(np.inf, 0.0, "", ("", "")))
        material = material_at(scene, soil, 0.5 * (place[:, 2].min() + min(place[:, 2].max(), top)))
        limit = np.tan(np.radians(45.0 + 0.5 * material.friction_angle)) if material.law in SAND else AHEAD
        if gap < limit * height:
            wrong = ("With one height its load is 4 % too low, with half of one 16 %" if covers_it else
                     "With one height its load is 10 % too high in clay and 25 % in sand, with half of one up to 60 %")
            high = f"{height:.3g} m of it {'wide' if in_plan else 'high'}"
            yield (f"{body.name} is driven along {'xy'[axis]} through soil, {high}, which ends {gap:.3g} m {where} it at "
                   f"{at}, {gap / height:.2g} of that, limit {limit:.2g}: soil that it should push aside is held there. "
                   f"{wrong}. {remedy}, unless the soil is to end there")


def _room(scene, soil, followed, place, travel, axis, side):
    """(Height [m] of a body in the soil on one side of it, distance [m] there to the end of the soil when it has moved, text
    of that and remedy); a distance of inf where nothing holds the soil, or none is there. followed: (V, 3) [m] vertices at
    the start of the body that windows move with."""
    sign, described, name = 2 * side - 1, scene.grid.axes[axis], "xy"[axis]
    front = sign * (place[:, axis].max() if side else place[:, axis].min())
    points, low = soil.constants, place[:, 2].min()
    beyond = (sign * points.position[:, axis] > front) & (points.position[:, 2] > low)
    height = min(place[:, 2].max(), maximum((points.position + points.half_width)[beyond, 2], low)) - low
    end = described.end if side else described.start
    gap = sign * end - front - max(sign * travel[axis], 0.0)
    found = []
    if _closed(scene, soil, axis, side):
        found.append((gap, f"{name} = {end:.3g} m", f"Move the end of grid.{name} outwards"))
    if described.window:
        reached = max(sign * followed[:, axis])
        gap = reached + described.window[side] - front
        found.append((gap, f"the end of grid.{name}.window", f"Widen grid.{name}.window"))
    gap, *texts = min(found, default=(np.inf, "", ""))
    return height, gap if height > 0.0 else np.inf, texts


def _closed(scene, soil, axis, side):
    """Whether the soil reaches an end of the grid, and is held there."""
    reaches = abs(extent(soil.constants, axis)[side] - soil.grid.extent[axis, side]) < soil.grid.smallest_cell
    return reaches and scene.grid.faces.of(axis, side) != "free"


def covered(scene, model):
    """Bodies pressed down that cover all of a soil that yields, up to faces of the grid that hold it."""
    for body, travel, place, *_ in loadings(scene, model):
        soil = model.soil
        axes = np.flatnonzero(~soil.grid.collapsed[:2])
        ends = [(extent(soil.constants, axis), soil.grid.extent[axis], "xy"[axis]) for axis in axes]
        closed = all(np.abs(np.subtract(reached, limits)).max() < soil.grid.smallest_cell
                     and (scene.grid.axes[axis].window or "free" not in (scene.grid.faces.of(axis, side) for side in (0, 1)))
                     for axis, (reached, limits, _) in zip(axes, ends))
        if len(axes) and travel[2] <= -DOWN * np.linalg.norm(travel) and closed and covers(place, soil):
            where = " and ".join(f"{name} = {limits[0]:.3g} to {limits[1]:.3g} m" for _, limits, name in ends)
            windows = ", ".join(f"grid.{name}.window" for *_, name in ends if getattr(scene.grid, name).window)
            names = ", ".join(name for *_, name in ends)
            wider = f"widen {windows}" if windows else f"move the ends of grid.{names} outwards"
            yield (f"{body.name} covers all of the soil, {where}, up to faces of the grid that hold it: nothing can "
                   "flow from under it, so that it compresses the soil and finds no load at which that gives way. A footing "
                   f"needs a grid wider than itself: {wider}, unless compression is meant")


def no_room_above(scene, model):
    """Bodies driven through soil that fills the grid up to an upper end that nothing holds, farther than soil may heave
    there before its points leave the grid."""
    soil, cell = model.soil, model.soil.grid.smallest_cell
    end, top = soil.grid.extent[2, 1], extent(soil.constants, 2)[1]
    open_ = scene.grid.faces.z_max == "free" and not scene.grid.z.moves and not soil.grid.collapsed[2]
    if not open_ or soil.stray != "stop" or top < end - ROOM * cell:
        return
    for body, travel, place, *_ in driven(scene, model):
        deep = place[:, 2].max() < top - np.ptp(place, axis=0).max()      # clay closes behind it
        if np.linalg.norm(travel) > HEAVE * cell and not deep:
            yield (f"{body.name} is driven by {np.linalg.norm(travel):.3g} m through soil that reaches the upper end of the "
                   f"grid, z = {end:.3g} m, where nothing holds it: points that heave leave the grid there, which stops the "
                   "run. Raise grid.z.end some cells above the soil")


def _text(body, width, gap, where, limit, axis):
    return (f"{body.name} is {width:.3g} m wide, and the soil ends {gap:.3g} m {where}, {gap / width:.3g} widths, limit "
            f"{limit:.2g}: soil that should flow from under it is held there, so that the body carries more than on ground "
            "without this end, by a tenth at the limit and by much more nearer to it. "
            f"{f'Widen grid.{axis}' if 'window' in axis else f'Move the end of grid.{axis} outwards'}, unless the soil is "
            "to end there")


def _beside(scene, soil, place):
    """(width [m] of a body, its distance [m] to the end of the soil or None where that is no end, text of the place) for
    the ends of the axes along which soil can flow away; a body on, or beyond, a face of the grid is half of one there."""
    grid, cell = soil.grid, soil.grid.smallest_cell
    for axis, name in enumerate("xy"):
        ends, limits = (place[:, axis].min(), place[:, axis].max()), grid.extent[axis]
        window = getattr(scene.grid, name).window
        inside = [(ends[0] - limits[0]) > 1e-6 * cell, (limits[1] - ends[1]) > 1e-6 * cell]
        if grid.collapsed[axis] or not any(inside):
            continue
        width = ends[1] - ends[0] if all(inside) else 2 * (ends[1] - limits[0] if inside[1] else limits[1] - ends[0])
        for side, sign in ((0, 1), (1, -1)):
            closed = window or _closed(scene, soil, axis, side)
            gap = sign * (ends[side] - limits[side]) if inside[side] and closed else None
            yield width, gap, f"{name} = {limits[side]:.3g} m{', the end of its window' if window else ''}"


LIMITS = (narrow_margins, narrow_above, narrow_ahead, covered, no_room_above)
