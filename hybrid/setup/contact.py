"""Contact of a body with the soil of a scene: where it is evaluated. How stiff it is, is in `hybrid.setup.penalty`.

Spacing of the places on the faces of domains    s = 2 l / k <= r/16, on held soil r/32      k from 4 to 32

with l the smallest half-width of a domain (bodies are where cells are fine) and r the radius of curvature that nine tenths
of the body's surface exceed; on soil that yields a cell at least. There a bar of 0.27 cells in a Danforth anchor asked for
6 144 places on a domain. With 384, the vertical force as it lands is within 4 % of that with 1 536, 7 % at first contact,
the horizontal one within 9 %, and its height within 0.5 mm. A disc that stands on its rim over held soil keeps upright on
springs that are stiff beside its thickness (`hybrid.setup.foot`), and their places lie closer in proportion.
"""

from dataclasses import replace

import numpy as np

from hybrid.body import rigid
from hybrid.body.curvature import curvature_radius
from hybrid.body.rounded import round_off
from hybrid.body.sharp_edges import find_edges, narrowest_face
from hybrid.contact import places
from hybrid.contact.cover import Cover
from hybrid.contact.soft_edges import ends_of, soft_edges
from hybrid.runtime.comm import anywhere, minimum
from hybrid.setup.bearing import base_share, bears, stands_on
from hybrid.setup.foot import standing_overlap, stands_on_edge
from hybrid.setup.interface import friction_of, interface_of
from hybrid.setup.penalty import REST_CURVATURE, penalty, rests, rests_on_elastic_soil
from hybrid.setup.plane_strain import in_slice
from hybrid.soil.points import extent

FEWEST, MOST, MOST_THIN = 4, 32, 128    # places along a face; of one that a thin body stands on
ROUND_OFF = 1e-9        # of their number: halves and wholes of a body have as many
CURVATURE = 16          # spacings in a radius of curvature; REST_CURVATURE where soil of given shape carries the body
# Places across the narrower side of a body with plane faces over held soil: the lever arm by which its weight resists a load
# ends at the outermost one. A box of 0.4 x 0.4 x 1 m tipped at 0.86 to 1.0 of W b/h with 13 across, by where it stood.
ACROSS = 32
FLUSH = 1e-3            # of a cell, between an edge and the end of the soil at which it lies


def connect_to_soil(described, body, motion, soil, gravity, alone, carried=()):
    """The body, at its BodyState at the start, with all of its contact that follows from `soil`; gravity (3,) [m/s²];
    alone: whether no other body moves or loads the soil; carried: (RigidBody, BodyState, share) of those whose loads it
    bears. Raises SceneError."""
    rotation = motion.rotation
    body = in_slice(body, soil.grid, rotation)
    chosen, spacing, radius = _places(described, body, rotation, soil, gravity)
    if described.adhesion is not None and not anywhere(soil.law.undrained):     # there is no clay in the grid
        described = replace(described, adhesion=None)
    mixed = described.adhesion is not None and anywhere(~soil.law.undrained)
    interface, sharp = interface_of(described, mixed), body.surface
    moves = described.pull or any((*(described.velocity or ()), *(described.spin or ())))
    stands = alone and stands_on(body, motion, soil, gravity)
    below = not (soil.held or moves) and bears(body, motion, soil, gravity, stands, carried)
    body = replace(body, below_capacity=below)
    body = replace(body, places=chosen, penalty=penalty(described, body, motion, soil, spacing, radius, gravity))
    if not (soil.held or chosen.at_corners):
        body = _beside_edges(described, body, motion, soil, gravity, np.isinf(radius))
    if interface and not chosen.at_corners:
        interface = replace(interface, sharp=None if body.surface is sharp else sharp, cover=_cover(sharp, soil, rotation))
    body = replace(body, friction=friction_of(described, mixed), interface=interface)
    return rigid.with_stiffness(body, soil.law.young, soil.held)


def _beside_edges(described, body, motion, soil, gravity, plane):
    """The body, with `plane` faces or curved ones, with its contact beside sharp edges: they are rounded off where soil
    flows around them, where the body slides along, so that soil in front of it would come to lie inside, and where it
    stands on one, so that the normal of contact turns from one face to the other; else springs are softer there."""
    surface, cell = body.surface, soil.grid.smallest_cell
    edges = find_edges(surface, cell, motion.rotation[soil.grid.collapsed])
    carried = rests_on_elastic_soil(body, soil, gravity)
    flows = soil.law.plastic and not body.below_capacity
    pointed = body.driven[2] and not base_share(body.outline, motion.rotation)
    beside = _beside(body, motion, soil)
    along = ~beside & (soil.law.plastic or not _is_in(body, motion, soil))
    slides = (body.driven[:2] & along).any() or not carried and (
        pointed or described.pull or (np.array(described.velocity)[:2] * along).any())
    if not carried:
        body = replace(body, narrowest=narrowest_face(edges, cell))
    if flows or slides or plane and stands_on_edge(body, motion, soil):
        return replace(body, surface=round_off(surface, edges))
    ends = ends_of(surface, edges)
    ends = ends[~_at_ends_of(soil, motion.position + ends @ motion.rotation.T, ~beside)]
    width = max((np.diff(nodes).min() for nodes in soil.grid.lines[:2] if len(nodes) > 1), default=cell)    # of cells
    return replace(body, soft_edges=soft_edges(ends, body.penalty, width))


def _is_in(body, motion, soil):
    """Whether a body begins at least half a cell deep in the soil, whose elastic part ahead of it stays there."""
    bottom = motion.position[2] - body.outline.extent(-motion.rotation[2])
    return bottom < extent(soil.constants, 2)[1] - 0.5 * soil.grid.smallest_cell


def _beside(body, motion, soil):
    """(2,) bool, whether a body begins beyond an end of the soil along x and y, as one that is pressed against its side."""
    low, high = rigid.bounding_box(body, motion)[:, :2]
    ends = np.array([extent(soil.constants, axis) for axis in range(2)])
    near = FLUSH * soil.grid.smallest_cell
    return ~soil.grid.collapsed[:2] & ((low > ends[:, 1] - near) | (high < ends[:, 0] + near))


def _at_ends_of(soil, edges, along):
    """(e,) bool, whether edges with ends (e, 2, 3) [m] lie at an end of the soil or beyond it, as those of a platen; along:
    (2,) bool, x and y where that counts."""
    found = np.zeros(len(edges), bool)
    for axis in np.flatnonzero(~soil.grid.collapsed[:2] & along):
        low, high = extent(soil.constants, axis)
        near = FLUSH * soil.grid.smallest_cell
        found |= (edges[..., axis] < low + near).all(axis=1) | (edges[..., axis] > high - near).all(axis=1)
    return found


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
    wanted = (REST_CURVATURE if soil.held or rests(body, soil, radius, gravity) else CURVATURE) * width / radius
    yields = soil.law.plastic and not soil.held
    k = curved = _blocks(wanted, round(CURVATURE * width / soil.grid.smallest_cell) if yields else MOST)
    if soil.held and body.free[3:].any() and body.surface.turning.any():
        overlap = standing_overlap(body.surface, rotation, soil.grid.collapsed)
        thin = width / np.sqrt(0.5 * overlap * min(radius, body.radius))
        k = curved = max(k, _blocks(thin, MOST_THIN)) if thin > k else k
    if soil.held and np.isinf(radius) and body.free[3:].any():     # it may tip
        extent = np.ptp(body.surface.vertices @ rotation.T, axis=0)
        k = max(k, _blocks(ACROSS * width / extent[:2][~soil.grid.collapsed[:2]].min()))
    reach = places.HELD_REACH if soil.held else places.FACE_REACH
    if interface_of(described):   # the steps that domains make of a surface are as high as a domain
        reach = max(reach, width / soil.grid.smallest_cell)
    return places.faces(k, soil.grid.collapsed, reach), width / curved, radius


def _blocks(wanted, most=MOST):
    """Number of places along a face, whole blocks of them, that is not less than `wanted` if it may be as many."""
    return int(places.BLOCK * np.ceil(np.clip(wanted * (1.0 + ROUND_OFF), FEWEST, most) / places.BLOCK))
