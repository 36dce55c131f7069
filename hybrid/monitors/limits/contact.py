"""Limits of bodies and of their contact with soil."""

import numpy as np

from hybrid.body.guides import forces_of
from hybrid.body.paths import travel_along
from hybrid.body.smooth import area_vectors
from hybrid.body.symmetry import copies
from hybrid.contact.interface import RAMP
from hybrid.contact.search import distances
from hybrid.monitors.limits.start import covers, initial_vertices, levelled, stands_on, top_of
from hybrid.runtime.comm import anywhere, minimum, total
from hybrid.scene.soil import clay_layers, laws
from hybrid.soil.points import extent

# Each number is the one from which a failure case of the study goes wrong.
STIFFNESS_RATIO = 10.0      # p_f times the depth of soil [-]: below it contact springs take a tenth of the displacement
TANGENTIAL_RATIO = 0.3      # ε_T/ε_N [-]: below it a rolling sphere creeps by 5 % of its path and more
SPACINGS = 2.0              # width of a body over the spacing of contact points [-]: below it too few sample the body
# Thickness of a wall with clay on both sides, in cells: thinner ones may have no grid line free of soil between
THICKNESS = 2.0
ROUNDED = 0.99              # of a limit, as a text gives the size of cells to two digits
THIN_SHARE = 0.25           # of the surface in clay, that is thinner
PARTED = 0.3                # cosine: faces that a driven body moves along are not parted from the soil
SAMPLES = 20                # of a thickness
FLUSH = 1e-3                # cells: a face as far below the top of the soil lies on it
FACETS = 52.0               # degrees: 46 to 49 with elements of 1 to 1.4 radii, right to 4 %; 57 to 59 with 2
CELL_ROWS = 1.5             # mass of a body over that of a row of cells [-]: lighter ones rebound from nodes


def low_penalty(scene, model):
    """Penalties so low that the contact deforms instead of the soil: springs in series, 1/p_f against the depth."""
    if model.soil.held:
        return
    across, (bottom, top) = ~model.soil.grid.collapsed[:2], extent(model.soil.constants, 2)
    for described, body in zip(scene.bodies, model.bodies):
        if described.penalty is None and not body.places.at_corners:
            continue    # derived
        depth = min([top - bottom, *np.ptp(initial_vertices(described, body), axis=0)[:2][across]])
        ratio = body.penalty * depth
        if ratio < STIFFNESS_RATIO:
            yield (f"{body.name}: body.penalty = {body.penalty:g} /m times {depth:.3g} m, the depth of soil that "
                   f"the body compresses, is {ratio:.3g}, limit {STIFFNESS_RATIO:g}: contact takes "
                   f"{1 / (1 + ratio):.0%} of the displacement that belongs to the soil. Set body.penalty to "
                   f"{STIFFNESS_RATIO / depth:.3g} or more")


def low_tangential_stiffness(scene, model):
    """Tangential contact springs so soft that sticking contact creeps."""
    for body in model.bodies:
        if body.friction > 0 and body.tangential < TANGENTIAL_RATIO:
            yield (f"{body.name}: body.tangential = {body.tangential:g} of the normal stiffness, limit "
                   f"{TANGENTIAL_RATIO:g}: sticking contact creeps, a rolling sphere by 5 % of its path and more. Set "
                   "body.tangential = 1")


def narrow_body(scene, model):
    """Bodies so narrow that too few contact points sample them."""
    half, across = model.soil.constants.half_width, ~model.soil.grid.collapsed[:2]
    if model.soil.basis != "gimp" or not across.any():
        return
    domain, cell = 2 * minimum(half[:, :2][:, across]), model.soil.grid.smallest_cell
    for described, body in zip(scene.bodies, model.bodies):
        place = initial_vertices(described, body)
        width, spacing = _width(place[:, :2] * across), domain / body.places.per_edge
        above = body.guided.all() and not body.driven.any() and place[:, 2].min() > top_of(model.soil) + 0.5 * cell
        if width < SPACINGS * spacing and not above and body.ground is None:
            denser = 'Set body.contact = "faces", or use' if body.places.at_corners else "Use"
            yield (f"{body.name} is {width:.3g} m wide, {width / spacing:.2g} spacings of contact points, limit "
                   f"{SPACINGS:g}: too few of them sample the body, so that its contact force depends on where it "
                   f"stands, or is zero. {denser} cells of at most {cell * width / (SPACINGS * spacing):.2g} m")


def coarse_facets(scene, model):
    """Curved faces of so few elements that the surface between them is not that of the geometry."""
    for body in model.bodies:
        outline = body.outline
        cosine = np.einsum("tki,ti->tk", outline.corner_normals, outline.normals)[outline.curved]
        angle = np.degrees(np.arccos(np.clip(cosine.min(initial=1.0), -1.0, 1.0)))
        if angle > FACETS:
            yield (f"{body.name} has elements inclined to its curved surface by {angle:.0f} degrees, limit {FACETS:g}: "
                   "contact does not find its shape between them (a pipe with elements as long as its diameter went a third "
                   "deeper). Mesh it with elements of a third of its radius (parameters.size)")


def narrow_face(scene, model):
    """Faces between sharp edges, narrower than a cell: contact sees an edge with a radius of a few centimetres there."""
    cell, joined = model.soil.grid.smallest_cell, scene.joined
    for described, body in zip(scene.bodies, model.bodies):
        hangs = body.name in joined and initial_vertices(described, body)[:, 2].min() > top_of(model.soil) + cell
        if body.narrowest < cell and not hangs and not _lid(scene, model.soil, described, body):
            yield (f"{body.name} has a face {body.narrowest:.2g} m wide between sharp edges, limit {cell:.3g} m, one "
                   "cell: the grid does not resolve it, its load depends on where it stands in a cell, and Newton's "
                   "method may need many iterations for it. Round it off in the geometry, or use cells of at most "
                   f"{body.narrowest:.2g} m at the body")


def _lid(scene, soil, described, body):
    """Whether the narrow faces of a body are the sides of a lid over all of the soil, which touch none."""
    place = initial_vertices(described, body)
    still = not any(travel_along(scene, described, name) for name in "xy")
    return still and body.narrowest > 0.99 * np.ptp(place[:, 2]) and covers(place, soil)


def thin_wall(scene, model):
    """Walls in clay so thin that the soil on both sides shares nodes, which keep it together: it does not part from them."""
    if model.soil.held or not ("hencky" in laws(scene.soil) or any(clay_layers(scene.soil))):
        return
    cell = model.soil.grid.smallest_cell
    top = top_of(model.soil) - FLUSH * cell
    for described, body in zip(scene.bodies, model.bodies):
        if described.tension == "full" or not (body.free.any() or body.driven.any()):
            continue
        place = levelled(model.soil, initial_vertices(described, body))
        if covers(place, model.soil):
            continue
        thickness, share = _thickness(scene, described, body, place, ROUNDED * THICKNESS * cell, top)
        if share > THIN_SHARE:
            yield (f"{body.name} is {thickness:.2g} m thick where the soil is on both sides of it, "
                   f"{thickness / cell:.3g} cells of {cell:.3g} m, limit {THICKNESS:g}: soil on both sides "
                   f"{_shares(thickness / cell)} of the grid, so it does not part from the body, and the load is that of "
                   "soil that sticks to it (a strip plate pulled out of clay, 1.5 widths deep: up to 3.3 times as much). "
                   "Use cells of at most "
                   f'{thickness / THICKNESS:.2g} m, or set body.tension = "full" if the soil is to stay on it')


def _shares(cells):
    """Words about walls so many `cells` thick: pulled plates of one cell and less stuck, those of 1.25 to 1.75 at two places
    in a cell of three, and none of two."""
    return "shares nodes" if cells < 1.05 else "may, by where its faces lie between lines, share nodes"


def _thickness(scene, described, body, vertices, limit, top):
    """(Mean thickness [m] of the walls of a body that are thinner than `limit` [m], and their share of its surface), of its
    surface across the travel it is driven and below `top` [m] at the end. vertices: (V, 3) [m] over level ground."""
    surface = body.surface
    corners = vertices[surface.triangles]
    normal = area_vectors(corners)
    area = np.linalg.norm(normal, axis=1)
    travel = np.array([travel_along(scene, described, name) for name in "xyz"])
    across = np.ones(len(area), bool)
    if travel.any() and body.guided[:3].all():
        across = np.abs(normal @ travel) > PARTED * area * np.linalg.norm(travel)
    down = corners.mean(axis=1)[:, 2] + min(travel[2], 0.0)
    near = np.flatnonzero(across & (down < top))
    inward = (surface.vertices[surface.triangles[near]].mean(axis=1)[:, None]
              - limit * np.linspace(0.0, 1.0, SAMPLES + 1)[1:, None] * surface.normals[near, None])
    gap = distances(inward.reshape(-1, 3), surface)[0].reshape(-1, SAMPLES)
    outside, each = gap > 0.0, np.arange(len(gap))
    first = np.argmax(outside, axis=1)
    depth = limit * (first + 1) / SAMPLES - np.maximum(gap[each, first], 0.0)
    thin = outside.any(axis=1) & (down[near] - depth * normal[near, 2] / area[near] < top)
    depth, thin = depth[thin], near[thin]
    return float(np.average(depth, weights=area[thin])) if len(thin) else limit, area[thin].sum() / area.sum()


def unpressed_adhesion(scene, model):
    """Bodies in clay without weight that could part from them, and do not press on them: adhesion needs some pressure."""
    soil = model.soil
    if soil.held or any(scene.gravity):
        return
    cell, at = soil.grid.smallest_cell, levelled(soil, soil.constants.position)
    for described, body in zip(scene.bodies, model.bodies):
        interface, place = body.interface, levelled(soil, initial_vertices(described, body))
        alone = interface and interface.adhesion and not interface.tension and not interface.frictional
        near = ((at > place.min(axis=0) - cell) & (at < place.max(axis=0) + cell) | soil.grid.collapsed).all(axis=1)
        if alone and place[:, 2].min() < top_of(soil) - cell and anywhere(near & soil.law.undrained):
            yield (f"{body.name} is in clay without weight, which does not press on it: adhesion is at most {RAMP:g} times "
                   "the pressure, so that it acts on the faces that press the clay, and clay parts from the others (a pile "
                   "0.8 m wide and 3.2 m deep, α = 0.5, carried 40 instead of 65 kN). Newton's method may need many "
                   'iterations for it, or fail. Give the soil its weight (gravity), or set body.tension = "full"')


def unpressed_bond(scene, model):
    """Bodies that soil without weight and without adhesion sticks to, whose friction needs a pressure."""
    if model.soil.held or any(scene.gravity):
        return
    for described, body in zip(scene.bodies, model.bodies):
        pressed = any(force[:, 2].min() < 0.0 for force in forces_of(body))
        if pressed or travel_along(scene, described, "z") < 0.0:
            continue        # it is pressed on
        if body.interface and body.interface.tension and not body.interface.adhesion and 0.0 < body.friction < np.inf:
            yield (f"{body.name} has a bond (body.tension) and friction in soil without weight: friction is "
                   f"{body.friction:g} times the pressure, and a bond bears no shear, so that nothing resists what slides "
                   "along the soil until something presses it (a disc turned on elastic soil: no torque). Press the body "
                   "on first, or give the soil its weight (gravity)")


def light_body(scene, model):
    """Free bodies with less mass than the nodes that an impact accelerates first."""
    soil, grid = model.soil, model.soil.grid
    if soil.held or not model.scheme.inertia:
        return
    density = float(total(soil.constants.mass) / total(soil.constants.volume))
    joined, places = scene.joined, [initial_vertices(*each) for each in zip(scene.bodies, model.bodies)]
    for i, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        if any(stands_on(places[i], other) and other[:, 2].max() > top_of(soil) for other in places):
            continue        # it hits that one
        across = np.minimum(np.ptp(initial_vertices(described, body), axis=0), np.ptp(grid.extent, axis=1))[:2]
        height = levelled(soil, initial_vertices(described, body))[:, 2]
        above = height.min() >= top_of(soil) + (body.name in joined) * grid.smallest_cell
        if height.max() < top_of(soil) or above and (body.name in joined or not body.free[2]):
            continue        # it does not hit the soil that it is in, or is held or hangs above
        if body.interface and np.isinf(body.interface.tension) and not np.any(described.velocity):
            continue        # nor the soil to which it is bonded
        halves = copies([mirror for mirror in body.mirrors if not mirror.cut])      # beside those that `across` measures
        rows = halves * body.mass.mass / (density * across.prod() * grid.smallest_cell)
        if rows < CELL_ROWS and body.free[:3].any():
            plural = "" if f"{rows:.3g}" == "1" else "s"
            yield (f"{body.name} has the mass of {rows:.3g} row{plural} of cells under it, limit {CELL_ROWS:g}: when "
                   "it hits the soil it rebounds from the nodes instead of being stopped by a wave. Use a cell size of "
                   f"at most {grid.smallest_cell * rows / CELL_ROWS:.3g} m, drive the body, or set time.inertia = "
                   "false")


def driven_past_grid_end(scene, model):
    """Bodies that are driven or pulled past the end of the grid."""
    for described, body in zip(scene.bodies, model.bodies):
        place = initial_vertices(described, body)
        for axis, name in enumerate("xyz"):
            travel, grid = travel_along(scene, described, name), getattr(scene.grid, name)
            side, end = ("end", grid.end) if travel > 0 else ("start", grid.start)
            front = (place.max(axis=0) if travel > 0 else place.min(axis=0))[axis]
            passes = (front - end) * travel < 0 < (front + travel - end) * travel
            if not passes or grid.collapsed or (name == "z" and travel > 0):
                continue
            cheap = "" if grid.window else f" (with grid.{name}.window a long grid costs no more than a short one)"
            yield (f"{body.name} gets to {name} = {front + travel:.3g} m in the stages, limit {name} = "
                   f"{end:g} m, where the grid ends: there is no soil beyond. Move grid.{name}.{side} outwards{cheap}, "
                   "or use fewer stage.steps")


def _width(place):
    """Smallest distance [m] of two parallel lines around places (V, 2); an axis along which all are 0 is ignored."""
    angle = np.linspace(0.0, np.pi, 37)[:-1]
    widths = np.ptp(place @ np.array([np.cos(angle), np.sin(angle)]), axis=0)
    return float(widths.min() if np.ptp(place, axis=0).all() else widths.max())


LIMITS = (low_penalty, low_tangential_stiffness, coarse_facets, narrow_body, narrow_face, thin_wall, unpressed_adhesion,
          unpressed_bond, light_body, driven_past_grid_end)
