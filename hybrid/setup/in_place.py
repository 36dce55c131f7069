"""Bodies that are in the soil from the start: the soil that they take is removed, and what is left touches them.

Domains are cut in `hybrid.setup.cut_boxes`; the contact points of faces that the cut exposes start in equilibrium with
the soil (`hybrid.setup.exposed_faces`). Every body in place is reported before the run, and one that overlaps the ground
by less than a cell asks whether that is meant: it may have been put there by a wrong number.

Equations: FORMULATION (54).
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body.rigid import bounding_box, with_stiffness
from hybrid.contact.search import Domains, overlap
from hybrid.laws.user import is_of_user
from hybrid.runtime.comm import anywhere, gathered, maximum, number, total
from hybrid.runtime.errors import SceneError
from hybrid.setup.contact import smallest_domain
from hybrid.setup.plane_strain import section
from hybrid.setup.cut_boxes import SLIVER, UNCUT, Boxes, cut_out, near_boxes, soil_shares
from hybrid.setup.exposed_faces import first_contact_points
from hybrid.setup.ground import depth_in_ground
from hybrid.soil.points import at_rest, extent
from hybrid.soil.split_merge import select
from hybrid.state import ContactHistory, Population

OVERLAP = 0.1       # half-widths of a point that a body may overlap the soil at the start; contact bears that
SHALLOW = 1.0       # cells: a body less deep in the ground may be there by mistake


@dataclass(frozen=True)
class RemovedSoil:
    """Soil removed for a body: volume [m³] of the body in it, volume and mass [m³, kg] removed, numbers of points
    removed and of points cut; shallow: depth [m] of its lowest point under the ground, of a body that stands out of it by
    the rest and is less than SHALLOW cells deep, else 0; cells: the same in cells."""

    name: str
    inside: float
    volume: float
    mass: float
    removed: int
    cut: int
    shallow: float = 0.0
    cells: float = 0.0

    def __str__(self):
        meant = (f". It is only {self.shallow:.3g} m deep in the ground, {self.cells:.2g} cells, limit {SHALLOW:g}: if "
                 'it is to lie on it, set body.rest_on = "ground"') if self.shallow else ""
        return (f"{self.name} is in place: it takes {self.volume:.4g} m³ of soil ({self.mass:.4g} kg), where "
                f"{self.inside:.4g} m³ of it lie in the ground; {self.removed} points removed, {self.cut} cut{meant}")


def starts_inside(body, motion, points, soil):
    """Whether a body starts deeper in the soil than contact bears. Raises SceneError where soil cannot be cut."""
    domains = Domains.of(points, soil.constants, soil.basis, soil.ground)
    depth, count = overlap(domains, soil.grid, motion, body.surface)
    limit = OVERLAP * soil.grid.smallest_cell if soil.basis != "gimp" else 0.5 * OVERLAP * smallest_domain(soil)
    if depth <= limit and not _between_corners(body, motion, points, soil, limit):
        return False
    reason = ("the soil is held and is not cut" if soil.held else
              'points of soil.basis = "mpm" have no domains to cut' if soil.basis != "gimp" else
              'contact at the corners of domains does not follow a cut (body.contact = "faces")'
              if body.places.at_corners else
              "points of a user's law cannot be cut" if is_of_user(soil.law) else "")
    if reason:
        where = (f"{count} corners of the points' domains lie up to {depth:.3g} m inside the body, limit {limit:.3g} m"
                 if depth > limit else "it lies between the corners of the points' domains")
        raise SceneError(f"body {body.name!r} overlaps the soil at the start: {where}, and {reason}; set body.rest_on to "
                         "the height of the soil's surface, or raise body.position")
    return True


def _between_corners(body, motion, points, soil, limit):
    """Whether a body that no corner of a domain is inside of lies in the soil, as a plate thinner than domains does."""
    if soil.basis != "gimp":
        return False
    if soil.heights is not None and depth_in_ground(*soil.heights, body, motion, soil.grid.collapsed) <= limit:
        return False        # on the ground as it is given: columns may end above that
    surface, boxes = section(body, motion.rotation, soil.grid), _boxes(points)
    lowest = motion.position[2] - surface.extent(-motion.rotation[2])
    if lowest > extent(points, 2)[1] - limit:
        return False
    near = near_boxes(boxes, surface, motion, soil.grid.collapsed)
    return anywhere(soil_shares(boxes[near], surface, motion, soil.grid.collapsed)[0] < 1.0 - SLIVER)


def put_in_place(soil, points, bodies, motions):
    """(Soil, Points, [ContactHistory] of each body, [RemovedSoil]) once the soil that `bodies`, with those that start inside
    alone, take is removed; bodies, motions: RigidBody and BodyState of all, None for a body that starts outside."""
    before, boxes, removed_soil = _boxes(points), _boxes(points), []
    for body, motion in zip(bodies, motions):
        if body is not None:
            left, inside, cut = cut_out(boxes, section(body, motion.rotation, soil.grid), motion, soil.grid.collapsed)
            removed_soil.append(_removed_by(body, motion, soil, boxes, left, inside, cut))
            boxes = left
    if not number(boxes.parent):
        raise SceneError("the bodies take all of the soil; check body.position and the ends of the soil")
    soil, points = _cut_points(soil, points, boxes)
    stress = np.einsum("nii->ni", points.stress)
    histories = [ContactHistory.empty() if body is None else first_contact_points(
        with_stiffness(body, soil.law.young, soil.held), motion, soil, stress, before, boxes)
        for body, motion in zip(bodies, motions)]
    return soil, points, histories, removed_soil


def flush_contacts(soil, points, bodies, motions, contacts):
    """`contacts`, a ContactHistory of each body, with the contact points of soil that ends at the surface of bodies without
    any, and presses on them as it is at rest (FORMULATION (54))."""
    stress = np.einsum("nii->ni", points.stress)
    if soil.held or soil.basis != "gimp" or not anywhere(stress):
        return contacts
    boxes = _boxes(points)
    return [history if body.places.at_corners or anywhere([len(history.point)]) else first_contact_points(
        body, motion, soil, stress, boxes, boxes, flush=True) for body, motion, history in zip(bodies, motions, contacts)]


def _removed_by(body, motion, soil, boxes, left, inside, cut):
    """RemovedSoil of a body that leaves of the soil the Boxes `left` of `boxes`; inside, cut: as of `cut_out`."""
    density = soil.constants.mass / soil.constants.volume
    gone = boxes.volume @ density[boxes.parent] - left.volume @ density[left.parent]
    before, now = (np.bincount(each.parent, each.volume, len(density)) for each in (boxes, left))
    changed = before - now > UNCUT * before
    low, high = bounding_box(body, motion)[:, 2]
    ground = maximum((boxes.position + boxes.half)[changed[boxes.parent], 2], low)
    depth, limit = ground - low, SHALLOW * soil.grid.smallest_cell
    shallow = depth if depth < limit and high > ground else 0.0
    inside, gone, removed, cut = (total([each])
                                  for each in (inside, gone, len(np.setdiff1d(boxes.parent, left.parent)), cut))
    return RemovedSoil(body.name, float(inside), float(total(boxes.volume) - total(left.volume)), gone, int(removed),
                       int(cut), shallow, shallow / soil.grid.smallest_cell)


def _boxes(points):
    return Boxes(np.arange(len(points)), points.position, points.half_width)


def _renumbered(constants, boxes):
    """Numbers (n,) in the run of `boxes`, in the order of the points that they come from; None where one process has them
    all."""
    if constants.number is None:
        return None
    pieces = np.bincount(boxes.parent, minlength=len(constants))
    changed = gathered(np.column_stack([constants.number, pieces - 1])[pieces != 1])      # of all processes, near the bodies
    changed = changed[np.argsort(changed[:, 0])]
    moved = np.concatenate([[0], np.cumsum(changed[:, 1])])     # by the points removed and added before
    parent = constants.number[boxes.parent]
    piece = np.arange(len(boxes.parent)) - np.searchsorted(boxes.parent, boxes.parent)
    return parent + moved[np.searchsorted(changed[:, 0], parent)] + piece


def _cut_points(soil, points, boxes):
    """(Soil, Points at rest) of `boxes`, each with the density, the law and the stress of its point at its own height."""
    kept = select(Population(points, soil.constants, soil.law.rows), boxes.parent)
    share = boxes.volume / np.prod(2 * kept.constants.half_width, axis=1)
    constants = replace(kept.constants, position=boxes.position, half_width=boxes.half,
                        number=_renumbered(soil.constants, boxes),
                        volume=kept.constants.volume * share, mass=kept.constants.mass * share)
    law, stress = soil.law.with_rows(kept.rows), np.einsum("nii->ni", kept.points.stress)
    if constants.geostatic_gradient is not None:
        rise = boxes.position[:, 2] - kept.points.position[:, 2]
        stress = stress + constants.geostatic_gradient * rise[:, None]
    new = at_rest(constants, stress, law.strain(stress))
    new.acceleration[:] = kept.points.acceleration
    return replace(soil, constants=constants, law=law), new
