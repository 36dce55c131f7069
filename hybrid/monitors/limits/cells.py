"""Loads and run-outs that few cells make wrong, by how much, from problems set up afresh (demos/random/README.md, "By cells").

    attached to clay on all sides, deep                   1 + 1.75/n               n cells across it
    pushed into clay, with edges on lines of the grid     Π (1 + 0.3 e/n)          over the sides, e = 0, 1, 2 of whose edges are
    wall that ends in sand, plane strain                  1 + 2.3/n to 1 + 4.2/n   n cells in its depth
    column of sand let go in space                        run-out (1 - 1.6/n)      n cells in its height

The cause of all but the last is one: nodes at the edge of a face move with it, and the soil is sheared in the cell beyond
(DESIGN, "The foot of a blade drags on the next nodes"). The front of a column is thinner than a cell, and its base is fixed.
"""

from dataclasses import replace

import numpy as np

from hybrid.monitors.limits.contact import initial_vertices, way_along
from hybrid.runtime.comm import maximum, minimum
from hybrid.scene.ground import heights

EXCESS = 0.1                    # of a load, above which it is reported
ATTACHED, FOOT, EDGE, FRONT = 1.75, 2.3, 0.3, 1.6
ON_LINE = 0.15                  # cells between an edge and a line of the grid: contact sees the edge there as on it
PLANE, LEADING = 0.99, 0.5      # cosine between a face and the way; share of what the body covers that such faces are
DEEP = 1.0                      # widths: flow of clay around a body that goes deeper closes behind it
DEEP_PLATE = 2.0                # widths under the ground: a shallower plate lifts the clay above it
STEEP = 1.5                     # cells: a lower step of the ground is a slope
CLAY, SAND = "von-mises", {"drucker-prager", "willam-warnke"}


def few_cells(scene, model):
    """Bodies driven through soil that yields with a plane face, so few cells wide that their load is more than EXCESS too high."""
    for body, way, place, plane in _driven(scene, model):
        if not plane:
            continue
        for how, found in (("about", _attached(model, body, way, place)), ("up to", _on_lines(scene, model, body, way, place)),
                           ("at least", _foot(scene, model, way, place))):
            excess, what, cure = found
            if excess > EXCESS:
                yield f"{body.name} {what}: its load is {how} {excess:.0%} too high, limit {EXCESS:.0%}. {cure}"


def flow_around(scene, model):
    """Deep flow of clay in space around a body without a plane face, with a match of the cone that is too weak there."""
    soil = model.soil
    if soil.held or scene.soil.material.law != CLAY or soil.grid.collapsed.any() or scene.soil.material.cone != "plane strain":
        return
    top = maximum(soil.constants.position[:, 2] + soil.constants.half_width[:, 2])
    for body, way, place, plane in _driven(scene, model):
        depth, width = top - place[:, 2].min() - min(way[2], 0.0), np.ptp(place[:, :2], axis=0).min()
        if not plane and depth > (1.0 + DEEP) * width:
            yield (f"{body.name} is driven {depth / width:.2g} of its widths deep, limit {1 + DEEP:g}, through clay as strong as s_u where it is "
                   'sheared in a plane (soil.material.cone = "plane strain"): flow around a body in space is partly that of triaxial '
                   "compression and extension, where this clay has 0.87 s_u, and a ball carries 12 % less than in Tresca's at least. Set "
                   'soil.material.cone = "compression" if s_u is that of triaxial compression; footings are right without')


def thin_front(scene, model):
    """Columns of sand let go in space, so few cells high that the front, thinner than one, stays behind."""
    soil = model.soil
    if soil.held or not model.scheme.inertia or soil.grid.collapsed.any() or scene.soil.material.law not in SAND or scene.bodies:
        return
    drop, cell = _drop(scene, soil), soil.grid.smallest_cell
    cells = drop / cell
    if cells > STEEP and FRONT / cells > EXCESS:
        yield (f"the soil has a free side {drop:.3g} m high, {cells:.2g} cells, limit {FRONT / EXCESS:.2g}: let go in space it runs out about "
               f"{min(FRONT / cells, 1):.0%} too little, because the front becomes thinner than a cell. Use cells of at most "
               f"{EXCESS * drop / FRONT:.2g} m, or the plane strain of a wide column")


def _driven(scene, model):
    """(RigidBody, way (3,) [m], places (V, 3) [m] of its vertices, whether a plane face leads) of each driven body."""
    if model.soil.held or not model.soil.law.plastic:
        return
    for described, body in zip(scene.bodies, model.bodies):
        way = np.array([way_along(scene, described, name) for name in "xyz"]) * ~model.soil.grid.collapsed
        if way.any() and not body.free[:3][way != 0.0].any():
            whole = replace(body, surface=body.outline)
            place = initial_vertices(described, whole)
            yield whole, way, place, _leads(whole, place, way)


def _leads(body, place, way):
    """Whether faces across the way are most of what a body covers in its direction."""
    corners = place[body.surface.triangles]
    normal = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) @ (way / np.linalg.norm(way))
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    ahead = normal > 0.0
    return normal[normal > PLANE * area].sum() > LEADING * normal[ahead].sum() > 0.0


def _sides(grid, place, way):
    """(axis, width [m], places [m] of both ends) across the way; an end on a face of the grid, or beyond it, mirrors the other."""
    for axis in np.flatnonzero(~grid.collapsed & (np.abs(way) < 0.1 * np.linalg.norm(way))):
        ends, limits = np.array([place[:, axis].min(), place[:, axis].max()]), grid.extent[axis]
        inside = np.abs(ends - limits.mean()) < (0.5 - 1e-6) * np.ptp(limits)
        if inside.sum() == 1:
            end, middle = ends[inside][0], limits[~inside][0]
            ends = np.array([end, end])
            yield axis, 2 * abs(end - middle), ends
        elif inside.any():
            yield axis, np.ptp(ends), ends


def _attached(model, body, way, place):
    """(Excess, text, remedy) of a body deep in clay that stays on it."""
    soil, cell = model.soil, model.soil.grid.smallest_cell
    top = maximum(soil.constants.position[:, 2] + soil.constants.half_width[:, 2])
    width = min((width for _, width, _ in _sides(soil.grid, place, way)), default=np.inf)
    if body.interface is None or not np.isinf(body.interface.tension) or place[:, 2].max() > top - DEEP_PLATE * width:
        return 0.0, "", ""
    return (ATTACHED * cell / width, f"stays attached to clay and is {width / cell:.2g} cells of {cell:.3g} m wide",
            f"Use cells of at most {EXCESS / ATTACHED * width:.2g} m at the body")


def _on_lines(scene, model, body, way, place):
    """(Excess, text, remedy) of a body pushed into clay whose edges are on lines of the grid."""
    if scene.soil.material.law != CLAY or way[2] >= 0.0 or body.interface is not None and body.interface.tension:
        return 0.0, "", ""
    grid, excess, on, narrow = model.soil.grid, 1.0, [], np.inf
    for axis, width, ends in _sides(grid, place, way):
        if not _leads(body, place, np.eye(3)[axis]):    # a round outline crosses lines of the grid everywhere
            continue
        nodes, cell = grid.lines[axis], np.diff(grid.lines[axis]).min()
        lying = sum(np.abs(nodes - end).min() < ON_LINE * cell for end in ends)
        excess *= 1.0 + EDGE * lying * cell / width
        if lying:
            on.append("xyz"[axis])
            narrow = min(narrow, width / cell)
    if not on:
        return 0.0, "", ""
    return (excess - 1.0, f"is {narrow:.2g} cells wide and has edges on lines of the grid along {', '.join(on)}, where it drives the "
            "clay of the next cell too", "Move the lines of the grid by a quarter of a cell against it, or use smaller cells")


def _foot(scene, model, way, place):
    """(Excess, text, remedy) of an upright wall that is pushed through sand and ends in it, in plane strain."""
    soil, bottom = model.soil, place[:, 2].min()
    cell, low, high = soil.grid.smallest_cell, soil.constants.position - soil.constants.half_width, soil.constants.position + soil.constants.half_width
    top, base = maximum(high[:, 2]), minimum(low[:, 2])
    if soil.grid.collapsed.sum() != 1 or scene.soil.material.law not in SAND or way[2] or place[:, 2].max() < top or bottom < base + cell:
        return 0.0, "", ""
    depth = top - bottom
    if depth < cell:
        return 0.0, "", ""
    return (FOOT * cell / depth, f"ends {depth:.3g} m deep in sand, {depth / cell:.2g} cells of {cell:.3g} m, and drags the next cell along",
            f"Use cells of at most {EXCESS / FOOT * depth:.2g} m, or extrapolate two sizes of cells to none")


def _drop(scene, soil):
    """Height [m] of the highest free side of the soil as described: of its box inside of the grid, or of a step of soil.ground."""
    position, half, cell = soil.constants.position, soil.constants.half_width, soil.grid.smallest_cell
    low, high = ([extreme(side[:, axis]) for axis in range(3)] for extreme, side in ((minimum, position - half), (maximum, position + half)))
    inside = any(high[axis] < soil.grid.extent[axis, 1] - cell or low[axis] > soil.grid.extent[axis, 0] + cell for axis in (0, 1))
    if inside:
        return high[2] - low[2]
    if scene.soil.ground is None:
        return 0.0
    x, y, z = heights(scene.soil.ground)
    steps = [(np.diff(z, axis=0), np.diff(x))] + ([] if y is None else [(np.diff(z, axis=1), np.diff(y))])
    return max(float(np.abs(rise[width < cell] if axis == 0 else rise[:, width < cell]).max(initial=0.0))
               for axis, (rise, width) in enumerate(steps))


LIMITS = (few_cells, flow_around, thin_front)
