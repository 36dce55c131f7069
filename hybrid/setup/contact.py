"""Contact of a body with the soil of a scene: where it is evaluated, how stiff it is, and its part in plane strain.

Spacing of the places on the faces of domains    s = 2 l / k <= r/16, on held soil r/32      k from 4 to 32
penalty on elastic soil                           p_f = 500 / h, 2000 / h of a body of planes driven into it, 100 / h of
                                                  one with friction that shears it in plane strain
penalty on soil that yields                       p_f = 20 / h, 500 / h of a plane base that stages press with less than half
                                                  of what the cohesion of the soil bears
penalty on held soil                              p_f E = W / (π r δ²),  δ = 2 s²/r
of a curved body that rests on elastic soil       the softer one of 500 / h and that on held soil,  s <= r/32

with l the smallest half-width of a domain (bodies are where cells are fine), h the smallest cell, W the weight of the
body and r the radius of curvature that nine tenths of its surface exceed (a body of planes: its size). On elastic soil
the overlap is that of 1/500 of a cell under the same pressure. Soil that yields bears a hundredth of E at most, so there
20/h leaves an overlap of 1/2000 of a cell; a pipe in clay takes 6 iterations a step with it, and 28 with 400/h. In sand E is
small at the surface, but contact points move with the grid: the stiffer their springs, the fewer of them carry a body. On
held soil nothing but the penalty gives way: there δ is the overlap of a sphere under its weight, whose contact patch,
sqrt(2 r δ), has a radius of two spacings; a stiffer one would feel the places one by one. A curved body that
nothing but elastic soil carries would also roll on single places if the soil is stiff. There s shrinks with the cells, so
cells that resolve the patch of Hertz, a/4, make 500/h the softer one again.
"""

from dataclasses import replace

import numpy as np

from hybrid.body import rigid
from hybrid.body.rigid import FREEDOMS
from hybrid.body.rounded import round_off
from hybrid.body.sharp_edges import find_edges, narrowest_face
from hybrid.body.surface import build_surface
from hybrid.body.symmetry import copies
from hybrid.contact import places
from hybrid.contact.cover import Cover
from hybrid.contact.interface import Interface
from hybrid.laws.drucker_prager import cone_constants
from hybrid.laws.user import is_of_user
from hybrid.laws.von_mises import BEARING, TIPPED, USED
from hybrid.runtime.comm import anywhere, largest, minimum
from hybrid.runtime.errors import SceneError

FEWEST, MOST = 4, 32                # places along a face
ROUND_OFF = 1e-9                    # of their number: halves and wholes of a body have as many
CURVATURE, REST_CURVATURE = 16, 32  # spacings in a radius of curvature; of bodies that rest on soil of given shape
# Places across the narrower side of a body with plane faces over held soil: the lever by which its weight resists a load
# ends at the outermost one. A box of 0.4 x 0.4 x 1 m tipped at 0.86 to 1.0 of W b/h with 13 across, by where it stood.
ACROSS = 32
STIFFNESS = {False: 500.0, True: 20.0}  # p_f h, by whether the soil yields
PRESSED = 2000.0                    # the same of planes driven into elastic soil: their force is wanted, and cells follow
SHEARED = 100.0                     # of planes with friction that shear it in plane strain: all points in contact stick
PATCH = 2.0                         # spacings in the radius of a contact patch on held soil
PUBLISHED = 50.0                    # [1/m] p_f
SHARP = 0.1                         # of the area: fillets and tips, which cells do not resolve either
STRAIGHT = 0.02                    # sine of the angle between a prism's surface and its axis


def connect_to_soil(described, body, rotation, soil, gravity, cone):
    """The body, at an initial `rotation` (3, 3), with all of its contact that follows from `soil`; gravity (3,) [m/s²];
    cone: soil.material.cone. Raises SceneError."""
    body = in_slice(body, soil.grid, rotation)
    chosen, spacing, radius = _places(described, body, rotation, soil, gravity)
    if described.adhesion is not None and not anywhere(soil.law.undrained):     # there is no clay in the grid
        described = replace(described, adhesion=None)
    mixed = described.adhesion is not None and anywhere(~soil.law.undrained)
    interface, sharp = interface_of(described, cone, mixed), body.surface
    if not (soil.held or chosen.at_corners or _carried(body, soil, gravity)):
        edges = find_edges(body.surface, soil.grid.smallest_cell, rotation[soil.grid.collapsed])
        body = replace(body, surface=round_off(body.surface, edges),
                       narrowest=narrowest_face(edges, soil.grid.smallest_cell))
    moves = described.pull or any(described.velocity or ())
    body = replace(body, borne=not (soil.held or moves) and _bears(body, rotation, soil, gravity))
    body = replace(body, places=chosen, penalty=_penalty(described, body, soil, spacing, radius, gravity))
    if interface and not chosen.at_corners:
        interface = replace(interface, sharp=None if body.surface is sharp else sharp, cover=_cover(sharp, soil, rotation))
    body = replace(body, friction=friction_of(described, mixed), interface=interface)
    return rigid.with_stiffness(body, soil.law.young, soil.held)


def friction_of(described, mixed=False):
    """Coefficient of friction, inf where adhesion alone limits the shear; 0 where either of them is none. mixed: whether
    some of the soil is no clay, which has friction whatever the adhesion."""
    if described.adhesion == 0.0 and not mixed:
        return 0.0
    return described.friction if described.friction is not None else 0.0 if described.adhesion is None else np.inf


def interface_of(described, cone, mixed=False):
    """Interface of a body, None where its contact is that of friction alone. mixed: as in `friction_of`."""
    tension = {None: 0.0, "full": np.inf}.get(described.tension, described.tension)
    adheres = described.adhesion is not None and (described.adhesion > 0.0 or mixed)
    if not adheres and not tension:
        return None
    adhesion = described.adhesion / cone_constants(0.0, 0.0, cone)[1] if adheres else None
    return Interface(adhesion, tension, rubs=bool(adhesion and described.friction),
                     elsewhere=0.0 if described.friction is None else np.inf)


def _cover(surface, soil, rotation):
    """Cover of a body's `surface`, for the smallest domains of the soil."""
    collapsed = soil.grid.collapsed
    share = np.prod([np.ptp(soil.grid.extent[axis]) / np.ptp(surface.vertices @ rotation[axis])
                     for axis in np.flatnonzero(collapsed)])
    return Cover.of(surface, smallest_domain(soil), rotation[collapsed], share)


def smallest_domain(soil):
    """Width [m] of the smallest domain, not along collapsed axes, nor along z where the ground cuts domains to slivers."""
    across = ~soil.grid.collapsed & ((soil.ground is None) | (np.arange(3) < 2))
    return 2 * minimum(soil.constants.half_width[:, across])


def _places(described, body, rotation, soil, gravity):
    """(Places, their spacing [m] as far as curvature decides it, radius of curvature [m] of the body)."""
    width, radius = smallest_domain(soil), curvature_radius(body.surface)
    if described.contact == "corners":
        return places.corners(), width, radius
    wanted = (REST_CURVATURE if soil.held or _rests(body, soil, radius, gravity) else CURVATURE) * width / radius
    k = curved = _blocks(wanted)
    if soil.held and np.isinf(radius) and body.free[3:].any():     # it may tip
        extent = np.ptp(body.surface.vertices @ rotation.T, axis=0)
        k = max(k, _blocks(ACROSS * width / extent[:2][~soil.grid.collapsed[:2]].min()))
    reach = places.HELD_REACH if soil.held else places.FACE_REACH
    if interface_of(described, "plane strain"):   # the steps that domains make of a surface are as high as a domain
        reach = max(reach, width / soil.grid.smallest_cell)
    return places.faces(k, soil.grid.collapsed, reach), width / curved, radius


def _blocks(wanted):
    """Number of places along a face, whole blocks of them, that is not less than `wanted` if it may be as many."""
    return int(places.BLOCK * np.ceil(np.clip(wanted * (1.0 + ROUND_OFF), FEWEST, MOST) / places.BLOCK))


def _penalty(described, body, soil, spacing, radius, gravity):
    """p_f [1/m], or on held soil p_f E [N/m³]."""
    young, factor = largest(soil.law.young), largest(soil.law.young) if soil.held else 1.0
    if described.penalty is not None:
        return described.penalty * factor
    if described.contact == "corners":
        return PUBLISHED * factor
    stiff = _stiffness(described, body, soil, radius, gravity) / soil.grid.smallest_cell
    weight = copies(body.mirrors) * body.mass.mass * np.linalg.norm(gravity)
    rests = _rests(body, soil, radius, gravity)
    if weight == 0.0 or not (soil.held or rests):
        return stiff * factor
    radius = min(radius, body.radius)
    overlap = 0.5 * (PATCH * min(spacing, radius / REST_CURVATURE)) ** 2 / radius
    if soil.grid.collapsed.any():   # of a slice of two diameters, for any thickness
        weight *= 4.0 * radius / np.prod(np.ptp(soil.grid.extent[soil.grid.collapsed], axis=1))
    felt = weight / (np.pi * radius * overlap**2)
    return felt if soil.held else min(stiff, felt / young)


def _stiffness(described, body, soil, radius, gravity):
    """p_f h of a body on soil that deforms, which it shears where it is driven in two ways, or in one under a load."""
    if body.borne:
        return STIFFNESS[False]
    if soil.law.plastic or np.isfinite(radius) or not body.driven.any():
        return STIFFNESS[soil.law.plastic]
    axes = np.count_nonzero(body.driven[:3]) + body.driven[3:].any() + any(control.loads for control in body.stages)
    if axes > 1 and friction_of(described) > 0.0 and soil.grid.collapsed.any():
        return SHEARED
    return STIFFNESS[False] if _carried(body, soil, gravity) else PRESSED


def _bears(body, rotation, soil, gravity):
    """Whether the cohesion of soil that can yield bears the forces of all stages and the weight of a body with a plane base,
    at an initial `rotation`, without flowing: friction bears more."""
    height = body.outline.extent(-rotation[2])
    stages = [[_largest(load, rotation, height) for load in control.loads] for control in body.stages if control.loads]
    filled = _base(body.outline, rotation) if stages else 0.0
    guided = body.driven.any() or any(control.points for control in body.stages)
    if not filled or guided or not soil.law.plastic or is_of_user(soil.law):
        return False
    level = np.ptp(body.surface.vertices @ rotation.T, axis=0)
    part = 0.5 ** sum(not mirror.cut for mirror in body.mirrors)     # of the base, as of the load and the weight
    width = np.where(soil.grid.collapsed, np.ptp(soil.grid.extent, axis=1), level)[:2]
    most = USED * minimum(soil.law.cohesion(0.0), np.inf) * part * filled * width.prod()
    down, along, moment = np.max([np.sum(loads, axis=0) for loads in stages], axis=0)
    down += body.mass.mass * np.linalg.norm(gravity)
    narrow = width[~soil.grid.collapsed[:2]].min(initial=np.inf)
    return down < BEARING * most and along < most and moment < TIPPED * most * narrow


def _base(surface, rotation):
    """Share [-] of the rectangle around a surface, seen from below, that it covers; 0 where less than all but SHARP of what
    is seen is the plane of its lowest triangle."""
    corners, normals = surface.vertices @ rotation.T, surface.normals @ rotation.T
    triangles = corners[surface.triangles]
    edges, centres = np.diff(triangles, axis=1)[..., :2], triangles.mean(axis=1)
    below = np.where(normals[:, 2] < -STRAIGHT, 0.5 * np.abs(np.cross(edges[:, 0], edges[:, 1])), 0.0)
    covered, size = below.sum(), np.ptp(corners[:, :2], axis=0)
    if not covered:
        return 0.0
    lowest = np.argmin(np.where(below > 0.0, centres[:, 2], np.inf))
    normal, level = normals[lowest], np.abs((centres - centres[lowest]) @ normals[lowest])
    plane = below[(normals @ normal > 1.0 - STRAIGHT) & (level < STRAIGHT * size.min())].sum()
    return covered / size.prod() if plane > (1.0 - SHARP) * covered else 0.0


def _largest(load, rotation, height):
    """Largest force along z and across it [N], and moment across z about the base [N m], a `height` [m] under the centre,
    of a PointLoad."""
    force, moment = (np.zeros((1, 3)) if table is None else table.values for table in (load.force, load.moment))
    arm = np.cross(rotation @ load.point + (0.0, 0.0, height), force)
    across = np.linalg.norm(arm[:, :2], axis=1).max() + np.linalg.norm(moment[:, :2], axis=1).max()
    return np.abs(force[:, 2]).max(), np.linalg.norm(force[:, :2], axis=1).max(), across


def _rests(body, soil, radius, gravity):
    """Whether nothing but elastic soil carries the weight of a body with this `radius` of curvature [m]."""
    return np.isfinite(radius) and _carried(body, soil, gravity)


def _carried(body, soil, gravity):
    """Whether nothing but elastic soil carries the weight of a body, so that its force on the soil is known."""
    return not soil.law.plastic and gravity.any() and (body.free & ~body.driven)[:3][gravity != 0.0].all()


def curvature_radius(surface):
    """Radius of curvature [m] that all but SHARP of a surface's area exceed, inf where that is plane."""
    nodes, triangle = surface.tree.patches.nodes, surface.vertices[surface.triangles]
    area = 0.5 * np.linalg.norm(np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]), axis=1)
    if not len(nodes):
        return np.inf
    edge, turn = (np.stack([nodes[:, i], nodes[:, i + 1], nodes[:, i + 1] - nodes[:, i]], axis=1) for i in (1, 4))
    curvature = (np.linalg.norm(turn, axis=2) / np.linalg.norm(edge, axis=2)).max(axis=1)
    order = np.argsort(-curvature)
    strongest = curvature[order][np.searchsorted(np.cumsum(area[order]), SHARP * area.sum())]
    return 1.0 / strongest if strongest > 0.0 else np.inf


def in_slice(body, grid, rotation):
    """The body as it is modelled on a grid with collapsed axes: the part of a prism that lies in the slice.

    Its mass is that on the thickness of the slice, and it neither moves along a collapsed axis nor tilts it.
    Raises SceneError when it is no prism along such an axis.
    """
    for axis in np.flatnonzero(grid.collapsed):
        letter, thickness = "xyz"[axis], np.ptp(grid.extent[axis])
        nodes = body.surface.tree.patches.nodes
        normals = nodes[:, 3] if len(nodes) else body.surface.normals
        slope = np.abs(normals @ rotation[axis])
        if ((slope > STRAIGHT) & (slope < 1 - STRAIGHT)).any():
            raise SceneError(
                f"body {body.name!r} is no prism along the collapsed axis {letter}: in plane strain all sections of a "
                f"body across {letter} are equal. Use a prism, such as geometry/box.geo, rotated about {letter} at most, or "
                f"model the third dimension with grid.{letter}.collapsed = false")
        share = thickness / np.ptp(body.surface.vertices @ rotation[axis])
        mass = replace(body.mass, **{name: share * getattr(body.mass, name)
                                     for name in ("mass", "inertia", "matrix", "gravity_load")})
        fixed = np.array([freedom == letter or (freedom.startswith("r") and freedom != "r" + letter)
                          for freedom in FREEDOMS])
        body = replace(body, mass=mass, free=body.free & ~fixed, surface=_without_ends(body.surface, rotation[axis]))
    return body


def section(body, rotation, grid):
    """ContactSurface of a body's geometry, on a grid with a collapsed axis without the ends of the prism."""
    surface = body.outline
    for axis in np.flatnonzero(grid.collapsed):
        surface = _without_ends(surface, rotation[axis])
    return surface


def _without_ends(surface, axis):
    """The surface of a prism without its ends, which no point of its section is near."""
    sides = np.abs(surface.normals @ axis) < 0.5
    return build_surface(surface.vertices, surface.triangles[sides], surface.corner_normals[sides])
