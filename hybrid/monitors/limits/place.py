"""Bodies in places, of sizes and with contact that look wrong; like `hybrid.scene.check_sense`, but by the mesh."""

from itertools import combinations

import numpy as np

from hybrid.body.paths import path_along
from hybrid.body.symmetry import copies
from hybrid.monitors.limits.materials import material_at
from hybrid.monitors.limits.start import initial_vertices, stands_on, top_of
from hybrid.scene.body import out_of_plane
from hybrid.soil.points import extent

HIGH = 10.0         # sizes of a body above the soil,
DEEPER = 2.0        # and depths of the grid
LARGER = 5.0        # times the grid
ROUND_OFF = 0.01    # of the size of a body
TINY = 0.5          # of the smallest cell, of a body whose geometry is scaled
FLUSH = 0.01        # of the smallest cell: a body that reaches less far past the end of the grid ends there
AWAY = 1.0          # sizes of a body that the points of its pull, loads and motions may lie outside its bounding box,
AWAY_JOINED = 10.0  # and those of its joints: a hinge may stand for the arm of a pendulum
COORDINATES = "those of the geometry, in metres, before body.position moves it"
HEAVY = 0.1         # of Young's modulus, pressure of a body by its weight
STIFF = 1e4         # p_f times the smallest cell [-], of soil that is not held


def odd_places(scene, model):
    """Bodies that never meet the soil, or are not where the grid is."""
    for described, body in zip(scene.bodies, model.bodies):
        if not _meets(scene, described):        # a body in empty space is meant
            continue
        place = initial_vertices(described, body, body.outline)     # rounded edges may reach beyond a cut face
        carried = body.name in scene.joined or any(
            other is not body and stands_on(place, initial_vertices(below, other, other.outline))
            for below, other in zip(scene.bodies, model.bodies))
        text = (_scaled(described, np.ptp(place, axis=0).max(), model.soil.grid.smallest_cell)
                or _place(model.soil, place.min(axis=0), place.max(axis=0), scene.grid, carried)
                or _crossing(model.soil, body, place, scene.grid))
        if text:
            yield f"{body.name} {text}"


def _scaled(described, size, cell):
    """What looks wrong about a body of this `size` [m] whose geometry is scaled; "" if nothing."""
    if described.scale >= 1.0 or size > TINY * cell:
        return ""
    return (f"is {size:.3g} m long, less than {TINY:g} of a cell, with body.scale = {described.scale:g}: STEP files are "
            "read in metres whatever their unit, unlike STL. Leave body.scale out, or check it")


def beside_roller(scene, model):
    """Free bodies that end on one roller of the soil, as parts of bodies do in other programs, but are whole ones here."""
    soil, joined = model.soil, scene.joined
    stages = [model.for_stage(stage.held, number=number) for number, stage in enumerate(scene.stages)]
    for i, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        if soil.held or body.name in joined:
            continue
        place = initial_vertices(described, body)       # one that is cut there is held, it cannot leave the plane
        free = np.any([stage.bodies[i].free & ~stage.bodies[i].driven for stage in stages], axis=0)
        for a in np.flatnonzero(~soil.grid.collapsed[:2] & free[:2]):
            ends, found = soil.grid.extent[a], np.array([place[:, a].min(), place[:, a].max()])
            at = np.flatnonzero(np.abs(found - ends) < FLUSH * soil.grid.smallest_cell)
            if len(at) == 1 and scene.grid.faces.of(a, at[0]) == "roller":
                name = "xy"[a]
                turns = " and ".join(out_of_plane(name)[1:])
                yield (f"{body.name} ends on the face {name}_{('min', 'max')[at[0]]} of the grid and may leave "
                       "it: it is a whole body beside a plane of symmetry. For a part of a body lay the whole one across "
                       f"{name} = {ends[at[0]]:.4g} m, with its middle there, or hold {name}, {turns}")
                break


def outside_window(scene, model):
    """Bodies that stand, at the start or at the end, where a grid that moves with another body has no soil or coarse
    cells."""
    grid, bodies = scene.grid, list(zip(scene.bodies, model.bodies))
    followed = next((b for b, (described, _) in enumerate(bodies) if described.name == grid.follow), 0)
    for number, (described, body) in enumerate(bodies):
        if not grid.moves or number == followed or {body.name, scene.bodies[followed].name} <= scene.joined:
            continue
        for a, axis in enumerate(grid.axes[:2]):
            found = _left_out(scene, axis, "xy"[a], a, bodies[followed], (described, body)) if axis.moves else ""
            if found:
                yield f"{body.name} {found}"
                break


def _left_out(scene, axis, name, a, followed, other):
    """What is reported of the `other` (Body, RigidBody) beside the `followed` one along an axis that moves with that."""
    key, what = ("window", "soil is left out") if axis.window else ("around", "cells are coarser")
    ends = axis.window or axis.around
    travels = [[stage[-1] for stage in path_along(scene, each[0], name)] for each in (followed, other)]
    for moved, travel in ((0.0, 0.0), (travels[0][-1], travels[1][-1])):
        boxes = [np.clip(initial_vertices(*each)[:, a] + shift, axis.start, axis.end)      # beyond: `odd_places`
                 for each, shift in zip((followed, other), (moved, travel))]
        low, high = max(boxes[0].min() - ends[0], axis.start), min(boxes[0].max() + ends[1], axis.end)
        inside = np.ptp(boxes[1]) > 0.0     # of the grid, wherever it moves
        if inside and (boxes[1].min() < low - FLUSH * axis.size or boxes[1].max() > high + FLUSH * axis.size):
            needed = max(boxes[0].min() - boxes[1].min(), 0.0), max(boxes[1].max() - boxes[0].max(), 0.0)
            when = "at the start" if not moved and not travel else "at the end"
            return (f"reaches from {name} = {boxes[1].min():.4g} to {boxes[1].max():.4g} m {when}, and grid.{name}.{key} "
                    f"about {followed[0].name} from {low:.4g} to {high:.4g} m: {what} beyond that. Set grid.{name}.{key} to "
                    f"at least [{max(needed[0], ends[0]):.3g}, {max(needed[1], ends[1]):.3g}], or use a grid that does not "
                    "move")
    return ""


def _meets(scene, described):
    """Whether anything brings a body to the soil: its weight, its line, its motion or those of stages, a load."""
    of_stages = [each for stage in scene.stages for each in (*stage.loads, *stage.motions)]
    return (any(scene.gravity) or described.pull or any(described.velocity)
            or any(each.body in (None, described.name) for each in of_stages))


def _place(soil, low, high, grid, carried):
    """What looks wrong about a body between `low` and `high` (3,) [m], of which one that is `carried` by another or a joint
    may be high above the soil; None if nothing does."""
    extent = np.array([(axis.start, axis.end) for axis in grid.axes])       # where the grid may move to; `outside_window`
    size, middle = high - low, 0.5 * (low + high)
    axes = [(i, name) for i, name in enumerate("xyz") if not soil.grid.collapsed[i]]
    for i, name in axes:
        length = extent[i, 1] - extent[i, 0]
        if size[i] > LARGER * length and name != "z":
            return (f"is {size[i]:.4g} m long along {name}, {size[i] / length:.3g} times the grid: are its geometry or "
                    "its parameters in millimetres?")
    for i, name in axes:
        if name != "z" and (low[i] >= extent[i, 1] or high[i] <= extent[i, 0]):
            return (f"lies beside the grid, from {name} = {low[i]:.4g} to {high[i]:.4g} m, where the grid goes from "
                    f"{extent[i, 0]:.4g} to {extent[i, 1]:.4g} m: no soil is there. Check body.position")
    top = top_of(soil)
    gap = low[2] - top
    if high[2] <= extent[2, 0]:
        return (f"lies below the grid, up to z = {high[2]:.4g} m, where the grid starts at {extent[2, 0]:.4g} m: z "
                "points up. Check body.position")
    if not carried and gap > HIGH * size.max() and gap > DEEPER * (extent[2, 1] - extent[2, 0]):
        return (f"starts {gap:.4g} m above the soil, {gap / size.max():.3g} times its size: is body.position in "
                "millimetres? body.rest_on puts it at a height")
    for i, name in axes:
        out = max(middle[i] - extent[i, 1], extent[i, 0] - middle[i])
        free = grid.faces.of(i, int(middle[i] > 0.5 * sum(extent[i]))) == "free"
        covers = low[i] <= extent[i, 0] and high[i] >= extent[i, 1]     # a platen over all of the soil
        if name != "z" and out > (-ROUND_OFF if free else ROUND_OFF) * size[i] and not covers and gap < size.max():
            # one that starts high above the soil may come down elsewhere
            return (f"is half outside the grid: its middle is at {name} = {middle[i]:.4g} m, and the grid goes from "
                    f"{extent[i, 0]:.4g} to {extent[i, 1]:.4g} m. Only at a face of symmetry is half of a body enough")
    return None


def _crossing(soil, body, place, described):
    """What looks wrong about a body with vertices at `place` (V, 3) [m] that is inside and outside the grid; None if
    nothing: the soil ends before, or below the part outside; that part is the mirror image of the other; all of the soil
    is covered."""
    grid, slack = soil.grid, FLUSH * soil.grid.smallest_cell
    low, high = place.min(axis=0), place.max(axis=0)
    lower, upper = zip(*(extent(soil.constants, axis) for axis in range(3)))
    for i in np.flatnonzero(~grid.collapsed[:2]):
        name, axis = "xyz"[i], described.axes[i]
        start, end = axis.start, axis.end
        if low[i] < start + slack and high[i] > end - slack:
            continue
        for face, reached, sign, side, filled in ((start, low[i], -1, "start", lower[i]),
                                                  (end, high[i], 1, "end", upper[i])):
            beyond = sign * (reached - face)
            mirrored = any(mirror.axis == name and mirror.at == face for mirror in body.mirrors)
            if beyond < slack or mirrored or sign * (filled - face) < -grid.smallest_cell:
                continue
            if _lowest_beyond(place[body.outline.triangles], i, sign, face) < upper[2] + grid.smallest_cell:
                return (f"reaches {beyond:.3g} m past the {side} of the grid at {name} = {face:.4g} m, "
                        f"{beyond / (high[i] - low[i]):.0%} of its length along {name}: there is no soil beyond, so that "
                        f"this part has no contact. Move grid.{name}.{side} outwards, or the body; a body that is "
                        "symmetric about the face, a roller, and stays so, is half a model, one that covers all of the "
                        "soil a platen")
    return None


def _lowest_beyond(corners, axis, sign, at):
    """Height [m] of the lowest place of triangles (t, 3, 3) [m] beyond the plane at `at` [m] across an axis."""
    a, b = corners.reshape(-1, 3), np.roll(corners, -1, axis=1).reshape(-1, 3)
    of_a, of_b = sign * (a[:, axis] - at), sign * (b[:, axis] - at)
    cut = of_a * of_b < 0.0
    share = (of_a[cut] / (of_a[cut] - of_b[cut]))
    return np.concatenate([a[of_a > 0.0, 2], a[cut, 2] + share * (b[cut, 2] - a[cut, 2])]).min()


def odd_points(scene, model):
    """Points of lines, joints, loads and motions that are far from their body."""
    lines = [(f"body.{b}.pull.point", b, body.line.attachment, AWAY) for b, body in enumerate(model.bodies) if body.line]
    for key, b, point, sizes in (*lines, *_points_of_stages(scene, model), *_points_of_joints(model)):
        body = model.bodies[b]
        away, size = _outside(body, point), np.ptp(body.outline.vertices, axis=0).max()
        if away > sizes * size:
            yield (f"{key} of {body.name} lies {away:.3g} m outside its bounding box, {away / size:.2g} times its size, "
                   f"limit {sizes:g}, which looks wrong: its coordinates are {COORDINATES}")


def _outside(body, point):
    """Distance [m] of a point (3,) in the frame of a body from the bounding box of its surface in that frame."""
    lower, upper = body.outline.vertices.min(axis=0), body.outline.vertices.max(axis=0)
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(lower - point, point - upper))))


def _points_of_stages(scene, model):
    """(key, number of the body, point (3,) [m] in its frame, sizes that it may be away) of loads and motions of stages."""
    for s, stage in enumerate(scene.stages):
        for b, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
            control = body.stages[s] if body.stages else None
            numbers = [i for i, load in enumerate(stage.loads) if load.body in (None, described.name)]
            for i, load in zip(numbers, control.loads if control else ()):
                yield f"stage.{s}.load.{i}.point", b, load.point, AWAY
            numbers = {motion.point: i for i, motion in reversed(list(enumerate(stage.motions)))
                       if motion.point is not None and motion.body in (None, described.name)}
            # each once, as in the scene
            guided = {guide.label: guide.point for guide in control.points} if control else {}
            for i, point in zip(sorted(numbers.values()), guided.values()):
                yield f"stage.{s}.motion.{i}.point", b, point, AWAY


def _points_of_joints(model):
    """The same of joints; not the place of a hinge, ball or weld in the second body, which follows from that in the
    first."""
    for i, joint in enumerate(model.joints):
        for b, point, name in zip(joint.bodies, joint.points, ("point", "end")):
            if b is not None and (name == "point" or not joint.at_point):
                yield f"joint.{i}.{name}", b, point, AWAY_JOINED


def odd_penalty(scene, model):
    """Contact so much stiffer than the soil that Newton's method hardly converges."""
    if model.soil.held:
        return
    cell = model.soil.grid.smallest_cell
    for i, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        if described.penalty is not None and body.penalty * cell > STIFF:
            yield (f"body.{i}.penalty = {described.penalty:g} /m of {body.name} looks wrong: over cells of {cell:g} m "
                   f"it is {body.penalty * cell:.3g}, limit {STIFF:g}, and hardly converges; leave it out")


def odd_halves(scene, model):
    """Bodies that are cut where the soil is not."""
    for i, body in enumerate(model.bodies):
        if body.unmirrored_cut:
            yield (f"body.{i}: {body.name} is cut, but its cut face lies in no plane of symmetry of the grid, a roller "
                   "at the end of x or y: soil may pass through this face, and forces are those of the part. Put the "
                   "face on the end of the grid, or model the whole body")


def heavy_body(scene, model):
    """Bodies that begin on elastic soil, and whose weight alone compresses it by a large share."""
    soil, joined = model.soil, scene.joined
    material = material_at(scene, soil, top_of(soil))
    if soil.held or material.law != "hencky" or not material.young or soil.grid.collapsed[2]:
        return
    for described, body in zip(scene.bodies, model.bodies):
        place = initial_vertices(described, body)
        near = abs(place[:, 2].min() - top_of(soil)) < soil.grid.smallest_cell and body.free[2] and body.name not in joined
        across = np.where(soil.grid.collapsed, np.ptp(soil.grid.extent, axis=1), np.ptp(place, axis=0))[:2]
        pressure = body.mass.mass * -scene.gravity[2] * copies(body.mirrors) / across.prod()
        if near and pressure > HEAVY * material.young:
            yield (f"{body.name} presses the soil with at least {pressure:.3g} Pa by its weight, and soil.material.young = "
                   f"{material.young:g} Pa, limit {pressure / HEAVY:.3g} Pa, looks wrong: the soil is compressed by a tenth "
                   "and more; is it a number of kPa?")


def friction_of_one(scene, model):
    """Bodies that begin less than a cell apart, one of which has friction, and the other is left without."""
    given = {frozenset(contact.bodies) for contact in scene.contacts if contact.friction is not None}
    places, cell = [initial_vertices(*each) for each in zip(scene.bodies, model.bodies)], model.soil.grid.smallest_cell
    for i, j in combinations(range(len(places)), 2):
        pair = sorted((scene.bodies[i], scene.bodies[j]), key=lambda body: body.friction is None)
        joined = any({body.name for body in pair} == set(joint.bodies) for joint in scene.joints)
        names = frozenset(body.name for body in pair)
        near = [(place.min(axis=0) - 0.5 * cell, place.max(axis=0) + 0.5 * cell) for place in (places[i], places[j])]
        if joined or names in given or not pair[0].friction or pair[1].friction is not None:
            continue
        if (near[0][0] < near[1][1]).all() and (near[1][0] < near[0][1]).all():
            yield (f"{pair[1].name} has no friction (body.friction is left out), so that its contact with {pair[0].name}, "
                   f"which has {pair[0].friction:g}, has none: the smaller of the two counts. Give it friction too, or that "
                   "of the two alone in [[contact]]")


LIMITS = (odd_places, beside_roller, outside_window, odd_points, odd_penalty, odd_halves, heavy_body,
          friction_of_one)
