"""How bodies load the soil: which are driven where, their travel, or pushed by which force, with a plane face ahead or not,
and what soil is there."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hybrid.body.paths import path_along
from hybrid.body.smooth import area_vectors
from hybrid.body.symmetry import copies
from hybrid.laws.sand import material_values
from hybrid.laws.user import is_of_user
from hybrid.monitors.limits.contact import initial_pose, initial_vertices, levelled, top_of
from hybrid.runtime.comm import maximum
from hybrid.scene.ground import heights
from hybrid.scene.soil import FRICTIONAL, NUMBERS, as_clay, of_layer, within

EXCESS = 0.1                    # of a load, above which it is reported
PLANE, LEADING = 0.99, 0.5      # cosine between a face and the travel; share of what the body covers that such faces are
ALIKE = 0.05    # of unit normals: their components along a travel and upwards differ by less
ASKEW = 0.75                    # the same of a travel askew to the face: a plate moved at 11° to its normal bears 3 % less
# Share of a load across its main direction, or of the size that it acts beside the centre: inclined or eccentric
ASIDE = 0.05 * (1.0 + 1e-6)     # not decided by round-off
ACROSS = 0.1                    # cosine between a travel and an axis of the grid that is across it
ON_LINE = 0.15                  # cells between an edge and a line of the grid: contact sees the edge there as on it
PUSHED = 5.0                    # s_u: pipes and balls deep in clay carry 9 to 13
STEEP = 1.5                     # cells: a lower step of the ground is a slope
ROUND = 1.25    # largest over smallest distance of a round body's surface from its middle
SIDES = 12      # different normals of a round body
UNBROKEN = 20.0                 # of s_u: a tension that clay, which bears 12 s_u around a body, never reaches
AT_POINT = "hinge", "ball", "weld"
CLAY, SAND = "von-mises", FRICTIONAL


def smaller_cells(size, where=""):
    """Remedy for a load that is wrong by more than EXCESS in cells larger than `size` [m]; where: they are, as " at it"."""
    return f"Use cells of at most {size:.2g} m{where}, or extrapolate two sizes of cells to none"


def driven(scene, model):
    """(RigidBody, travel (3,) [m], places (V, 3) [m] of its vertices where it begins, whether a plane face leads) of each
    travel of each body that is driven, or welded to one that is, and gets to the soil."""
    if model.soil.held or not model.soil.law.plastic:
        return
    for number, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        movers = [number, *sorted(joined(scene, number, ("weld",)) - {None})]
        ways = [(travels_of(scene, scene.bodies[i], model.soil.grid.collapsed), model.bodies[i].guided) for i in movers]
        travels, guided = next((way for way in ways if way[0]), ((), None))
        if not travels:
            continue
        whole, place = outline(described, body, model.soil)
        for start, travel in travels:
            if guided[:3][travel != 0.0].all() and _gets_to(model.soil, place + start, travel):
                straight = _straight(whole, place, travel)
                lower = np.array([0.0, 0.0, min(travel[2] - straight[2], 0.0)])     # it goes forwards as deep as in the end
                yield whole, straight, place + start + lower, leads(whole, place, straight)


def _gets_to(soil, place, travel):
    """Whether a body with its vertices at `place` (V, 3) [m] gets as low as the soil on its travel."""
    return soil.grid.collapsed[2] or place[:, 2].min() + min(travel[2], 0.0) < top_of(soil) + soil.grid.smallest_cell


def _straight(body, place, travel):
    """A travel that is a little askew to an axis of the grid, along which a plane face leads, without what goes along that
    face and hardly loads it; any other one as it is."""
    normal = facing(body, place, travel)
    if normal is None or np.abs(normal).max() < PLANE:
        return travel
    axis = np.where(np.abs(normal) > PLANE, np.sign(normal), 0.0)
    return (axis @ travel) * axis if axis @ travel > ASKEW * np.linalg.norm(travel) else travel


def travels_of(scene, described, collapsed):
    """[(start, travel)] (3,) [m] of a driven body: in each stage from its place at the start to the farthest one. Stages in
    a row, or later, that go the same way are one, the longest."""
    paths = [path_along(scene, described, name) for name in "xyz"]
    found, start = [], np.zeros(3)
    for stage in zip(*paths):
        farthest = np.array([max(path, key=lambda place, now=now: abs(place - now)) for path, now in zip(stage, start)])
        end = np.array([path[-1] for path in stage])
        travel = np.where(collapsed, 0.0, farthest - start)
        if travel.any():
            found = _with(found, start, travel)
        start = end
    return found


def _with(found, start, travel):
    """`found` with another way: of those in one direction the longest, whole where they follow each other in a line."""
    length = np.linalg.norm(travel)
    for i, (first, other) in enumerate(found):
        if travel @ other > PLANE * length * np.linalg.norm(other):
            whole = start + travel - first
            in_line = whole @ other > PLANE * np.linalg.norm(whole) * np.linalg.norm(other)
            travels = [(first, other), (start, travel), *([(first, whole)] if in_line else [])]
            return [*found[:i], max(travels, key=lambda one: np.linalg.norm(one[1])), *found[i + 1:]]
    return [*found, (start, travel)]


def heading(travel):
    """Words such as "down" or "along x" about the main direction of a travel (3,)."""
    axis = int(np.argmax(np.abs(travel)))
    return ("down", "up")[int(travel[2] > 0.0)] if axis == 2 else f"along {'xy'[axis]}"


def loaded(scene, model):
    """(RigidBody, travel (3,), places (V, 3) [m], whether a plane face leads, whether the load is inclined, arm [m] on which
    it acts beside the centre, of the base where it presses that) of each body that is free to follow forces of a stage, or
    that a point of it drives, and that neither another body nor the ground carries above the soil; the travel is the largest
    component [N] of the largest force."""
    if model.soil.held or not model.soil.law.plastic:
        return
    outlines = [outline(described, body, model.soil) for described, body in zip(scene.bodies, model.bodies)]
    above = [place[:, 2].min() > top_of(model.soil) + model.soil.grid.smallest_cell for _, place in outlines]
    for i, (described, body, (whole, place)) in enumerate(zip(scene.bodies, model.bodies, outlines)):
        if above[i] and body.name in scene.joined:
            continue        # others carry it, or the ground
        rotation = initial_pose(described, body)[1]
        force, moment = _largest_load(body, rotation)
        axis = int(np.argmax(np.abs(force)))
        if not force[axis] or not body.free[axis] or model.soil.grid.collapsed[axis]:
            continue
        travel = np.where(np.arange(3) == axis, force, 0.0)
        inclined = np.abs(np.where(body.free[:3], force - travel, 0.0)).max() > ASIDE * abs(force[axis])
        if axis == 2 and force[2] < 0.0:    # about the middle of the base
            moment = moment + np.cross([0.0, 0.0, body.surface.extent(-rotation[2])], force)
        arm = 0.0       # where the ground or others that touch soil share a moment: how, the soil decides
        if all(j is not None and above[j] for j in joined(scene, i)):
            arm = np.abs(np.where(body.free[3:], moment, 0.0)).max() / abs(force[axis])
        yield (whole, travel, place, leads(whole, place, travel), inclined,
               arm if arm > ASIDE * np.ptp(place, axis=0).max() else 0.0)


def through_clay(scene, model):
    """(RigidBody, travel (3,) [m], places (V, 3) [m], whether a plane face leads) of each driven body, and of each that
    forces of a stage push by PUSHED of its area across them and more, where clay flows around it; the travel is a cell."""
    yield from driven(scene, model)
    grid = model.soil.grid
    for body, force, place, plane, *_ in loaded(scene, model):
        size = np.minimum(np.ptp(place, axis=0), np.ptp(grid.extent, axis=1))
        strength = material_at(scene, model.soil, place[:, 2].mean()).strength or np.inf
        whole = copies(body.mirrors) * np.linalg.norm(force)
        if whole > PUSHED * strength * np.prod(size[force == 0.0]):
            yield body, grid.smallest_cell * force / np.linalg.norm(force), place, plane


def joined(scene, number, kinds=AT_POINT):
    """Numbers of the bodies that joints of some `kinds`, those at points, connect with a body, over any number of others;
    None of the ground."""
    names, found = [body.name for body in scene.bodies], {number}
    pairs = [{*map(names.index, joint.bodies), *([None] if len(joint.bodies) == 1 else [])}
             for joint in scene.joints if joint.kind in kinds]
    for _ in pairs:
        for pair in pairs:
            found |= pair if (found & pair) - {None} else set()
    return found - {number}


def stays_attached(body, soil):
    """Whether clay never breaks away from a body."""
    tension = body.interface.tension if body.interface is not None else 0.0
    if is_of_user(soil.law) or np.isinf(tension):
        return np.isinf(tension)
    return tension > UNBROKEN * maximum(np.where(soil.law.undrained, soil.law.shear_strength(0.0), 0.0), 0.0)


def _largest_row(table):
    """Row (3,) of the values of a Table that has the largest norm."""
    return table.values[np.argmax(np.linalg.norm(table.values, axis=1))]


def _change(guide):
    """What is largest in the table of a Guide's rate, or by how much that of its displacement changes, with its sign."""
    return _largest_row(guide.table)[0] if guide.is_rate else guide.table.values[-1, 0] - guide.table.values[0, 0]


def _largest_load(body, rotation):
    """(force [N], moment [N m] about the centre) (3,) of the stage that loads a body at a `rotation` (3, 3) most, moments
    over its radius, at the rows of its tables that are largest. A stage that drives points of it has the forces of 1 N along
    their travels."""
    found = [(np.zeros(3), np.zeros(3))]
    for stage in body.stages or ():
        force, moment = np.zeros(3), np.zeros(3)
        for driven_point in stage.points:
            one = np.where(np.arange(3) == driven_point.guide.component, np.sign(_change(driven_point.guide)), 0.0)
            force, moment = force + one, moment + np.cross(rotation @ driven_point.point, one)
        for load in stage.loads:
            one = np.zeros(3) if load.force is None else _largest_row(load.force)
            force, moment = force + one, moment + np.cross(rotation @ load.point, one)
            if load.moment is not None:
                moment = moment + _largest_row(load.moment)
        found.append((force, moment))
    return max(found, key=lambda pair: np.linalg.norm(pair[0]) + np.linalg.norm(pair[1]) / body.radius)


def is_round(outline, distance):
    """Whether a body is, by distances (V,) [m] of its vertices from its middle and the SIDES of its `outline`, a
    ContactSurface: the corners of a box are all as far from its middle."""
    return distance.max() <= ROUND * distance.min() and len(np.unique(outline.normals.round(3), axis=0)) >= SIDES


def outline(described, body, soil):
    """(RigidBody with the surface of the whole body, places (V, 3) [m] of its vertices at the start, over level ground)."""
    whole = replace(body, surface=body.outline)
    return whole, levelled(soil, initial_vertices(described, whole))


def leads(body, place, travel):
    """Whether faces across the travel are most of what a body covers in its direction."""
    normal, area = faces(body, place)
    covered = normal @ (travel / np.linalg.norm(travel))
    ahead = covered > 0.0
    return covered[covered > PLANE * area].sum() > LEADING * covered[ahead].sum() > 0.0


def facing(body, place, travel):
    """Unit normal (3,) of the plane face that is most of what a body covers in the direction of its travel, across it or
    inclined; None of a round one."""
    return _most(place, body, travel, lambda units, unit: units @ unit > PLANE)


def bow(body, place, travel):
    """The mean of the normals of plane faces that are alike inclined to a travel and to the ground, as both sides of a V."""
    along = travel / np.linalg.norm(travel)

    def alike(units, unit):
        return np.maximum(np.abs(units @ along - unit @ along), np.abs(units[:, 2] - unit[2])) < ALIKE

    return _most(place, body, travel, alike)


def _most(place, body, travel, alike):
    """Mean (3,) of the normals of the faces that are most of what a body covers in the direction of its travel, of those
    that are `alike`, or None; alike: function of unit normals (n, 3) and one of them (3,)."""
    normal, area = faces(body, place)
    covered = normal @ (travel / np.linalg.norm(travel))
    ahead = covered > 0.0
    normal, area, covered = normal[ahead], area[ahead], covered[ahead]
    units = normal / area[:, None]
    for unit in np.unique(units.round(2), axis=0):
        same = alike(units, unit / np.linalg.norm(unit))
        if covered[same].sum() > LEADING * covered.sum():
            mean = normal[same].sum(axis=0)
            return mean / np.linalg.norm(mean)
    return None


def feet(body, place, travel, top):
    """[(Area [m²], length [m] of its edges, places (V, 3) [m] of the vertices)] of the plane parts, apart from each other,
    that lead a body across its travel and are in soil below `top` [m] in the end: one of a block, one of each leg of a
    table."""
    normal, area = faces(body, place)
    triangles = body.surface.triangles[normal @ travel > PLANE * area * np.linalg.norm(travel)]
    _, part = np.unique(place.round(9), axis=0, return_inverse=True)     # vertices of a surface may be there twice
    corners = part.ravel()[triangles]
    edges = np.sort(np.concatenate([corners[:, :2], corners[:, 1:], corners[:, ::2]]), axis=1)
    _, first, count = np.unique(edges, axis=0, return_index=True, return_counts=True)
    outer, at = edges[first[count == 1]], np.zeros((len(place), 3))
    at[part.ravel()] = place
    for mirror in body.mirrors:     # a cut is no edge
        outer = outer[(np.abs(at[outer][:, :, "xyz".index(mirror.axis)] - mirror.at) > 1e-6 * body.radius).any(axis=1)]
    number, group = connected_components(coo_matrix((np.ones(len(edges)), edges.T), (len(place), len(place))), False)
    found = []
    for each in range(number):
        mine = triangles[group[corners[:, 0]] == each]
        vertices = place[np.unique(mine)]
        if len(mine) and (vertices[:, 2] + min(travel[2], 0.0)).min() < top:
            own = outer[group[outer[:, 0]] == each]
            length = float(np.linalg.norm(at[own[:, 1]] - at[own[:, 0]], axis=1).sum())
            found.append((float(np.linalg.norm(area_vectors(place[mine]), axis=1).sum()), length, vertices))
    return found


def faces(body, place):
    """Outward normals (T, 3) of the triangles of a body, as long as their areas (T,) [m²]."""
    normal = area_vectors(place[body.surface.triangles])
    return normal, np.linalg.norm(normal, axis=1)


class Side(NamedTuple):
    """Extent of a body across its path: width [m]; places [m] of both ends along a unit `direction` (3,); axis of the grid,
    None of a direction that is along none."""

    width: float
    ends: np.ndarray
    direction: np.ndarray
    axis: int | None


def sides(grid, place, travel):
    """Sides across the travel; an end on a face of the grid, or beyond it, mirrors the other."""
    unit = travel / np.linalg.norm(travel)
    along = np.flatnonzero(~grid.collapsed & (np.abs(unit) >= ACROSS))
    for axis in np.flatnonzero(~grid.collapsed & (np.abs(unit) < ACROSS)):
        ends, limits = np.array([place[:, axis].min(), place[:, axis].max()]), grid.extent[axis]
        inside = np.abs(ends - limits.mean()) < (0.5 - 1e-6) * np.ptp(limits)
        if inside.sum() == 1:
            end, middle = ends[inside][0], limits[~inside][0]
            yield Side(2 * abs(end - middle), np.array([end, end]), np.eye(3)[axis], axis)
        elif inside.any():
            yield Side(np.ptp(ends), ends, np.eye(3)[axis], axis)
    if len(along) == 2:     # in the plane of the travel
        direction = np.zeros(3)
        direction[along] = -unit[along[1]], unit[along[0]]
        ends = np.array([(place @ direction).min(), (place @ direction).max()])
        yield Side(np.ptp(ends), ends, direction, None)


def narrowest(grid, place, travel):
    """Smallest width [m] across the travel, 0 where there is none."""
    return min((side.width for side in sides(grid, place, travel)), default=0.0)


def step_of_ground(scene, soil):
    """Height [m] of the highest upright step of soil.ground, 0 where there is none."""
    if scene.soil.ground is None:
        return 0.0
    cell, (x, y, z) = soil.grid.smallest_cell, heights(scene.soil.ground)
    steps = [(np.diff(z, axis=0), np.diff(x))] + ([] if y is None else [(np.diff(z, axis=1), np.diff(y))])
    return max(float(np.abs(rise[width < cell] if axis == 0 else rise[:, width < cell]).max(initial=0.0))
               for axis, (rise, width) in enumerate(steps))


def law_at(scene, soil, height):
    """Name of the law of the soil at a height [m]: that of its layer, or of soil.material."""
    return material_at(scene, soil, height).law


def material_at(scene, soil, height):
    """Material of the soil at a height [m], above the top that of the top, with the values of its relative density: that of
    its layer, or soil.material; clay with the keys of von Mises' law."""
    top, material = top_of(soil), scene.soil.material
    height = min(height, top)
    for layer in scene.soil.layers:
        low, end = within(layer, -np.inf, top)
        if height >= low and (height < end or height == end == top):
            material = of_layer(material, layer)
            break
    values = {name: value for name, value in material_values(material).items() if name in NUMBERS}
    return as_clay(replace(material, **values))
