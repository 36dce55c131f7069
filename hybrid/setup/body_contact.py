"""Contact of the bodies of a scene with one another: which pairs may touch, how stiff, and at which places.

    k = F / (A δ)       F the weight of the lighter body (`contact.load`), A the area in contact at the overlap δ

| pair                 | spacing s of places | overlap δ | area A                                    |
|----------------------|---------------------|-----------|-------------------------------------------|
| a curved body        | r/32                | 2 s²/r    | π r δ; in plane strain 4/3 b sqrt(2 r δ)  |
| bodies of planes     | d/16, w/4 of poles  | d_n/1000  | (d/4)²; in plane strain b d/4             |

with 1/r the sum of both curvatures, d the size of the smaller body, d_n that of a cube as narrow as the narrower body, at
most d, w the second of the three extents of either body, at least d/25, and b the thickness of the slice. So a sphere sinks
by a thousandth of its diameter into what it rests on, and its patch of contact has a radius of two spacings. Edges count
with a width and corners with an area with which they alone carry F at an overlap of d_n/1000. In space they begin to press
later than faces (`hybrid.contact.samples.flat_overlap`), which so carry alone when they lie flat. An impact overlaps
bodies by at most IMPACT d.

Equations: FORMULATION (60), (63).
"""

from dataclasses import replace
from itertools import combinations

import numpy as np

from hybrid.body.curvature import curvature_radius
from hybrid.contact import body_to_body
from hybrid.contact.body_to_body import Side
from hybrid.contact.law import Coulomb
from hybrid.contact.overlap import ALLOWED_OVERLAP, depth_of_overlap, volume_of_overlap
from hybrid.contact.samples import flat_overlap, sample
from hybrid.runtime.errors import SceneError
from hybrid.scene.defaults import ROLLING, STANDARD_GRAVITY
from hybrid.setup.plane_strain import section
from hybrid.state import PairHistory
from hybrid.step.pair_terms import IMPACT, BodyPair

CURVED, PLANE = 32, 16      # spacings in a radius of curvature; in the size of bodies of planes
ACROSS, FINEST = 4, 100     # spacings in the width of a pole, which another one may cross; in its size at most
SINKS = 1e-3                # of the size of a cube as narrow: overlap under F
DEEPEST = 1.25              # of that overlap: largest one from which on edges and corners press
BEHIND = 10.0               # times the largest overlap of an impact: of places behind a side that is not the nearest one


def refuse_overlap_of_bodies(placed, joined, collapsed):
    """SceneError where two of the bodies `placed`, each a RigidBody and BodyState, overlap at the start. joined: pairs of
    their numbers that may; collapsed: (3,) bool, axes along which only their sections count."""
    joined = {frozenset(pair) for pair in joined}
    for first, second in combinations(range(len(placed)), 2):
        if {first, second} in joined:
            continue
        one, other = placed[first], placed[second]
        depth = depth_of_overlap(one, other, collapsed)
        if depth > ALLOWED_OVERLAP * min(one[0].radius, other[0].radius):
            volume = volume_of_overlap(one, other)
            raise SceneError(f"bodies {one[0].name!r} and {other[0].name!r} overlap at the start, by {depth:.3g} m or "
                             f"more and about {volume:.2g} m³; move one of them by body.position or body.rest_on. Join "
                             "bodies that belong together by a [[joint]], or make one geometry of them")


def build_pairs(scene, bodies, motions, joints, grid, gravity):
    """(tuple of BodyPair, [PairHistory] at the start) of all bodies that no joint connects.

    bodies: RigidBody and motions: BodyState of each; gravity: (3,) [m/s²]. Bodies that overlap a little at the start
    begin without force.
    """
    joined = {frozenset(joint.bodies) for joint in joints}
    given = {frozenset(contact.bodies): contact for contact in scene.contacts}
    surfaces = [section(body, motion.rotation, grid) for body, motion in zip(bodies, motions)] if len(bodies) > 1 else []
    pairs, histories, made = [], [], {}
    for numbers in combinations(range(len(bodies)), 2):
        if frozenset(numbers) in joined:
            continue
        described = [scene.bodies[n] for n in numbers]
        own = given.get(frozenset(body.name for body in described))
        pair = _pair(numbers, described, own, [bodies[n] for n in numbers], [surfaces[n] for n in numbers],
                     [motions[n] for n in numbers], grid, float(np.linalg.norm(gravity)) or STANDARD_GRAVITY, made)
        pairs.append(pair)
        histories.append(_history(pair, motions))
    return tuple(pairs), histories


def _pair(numbers, described, own, bodies, surfaces, motions, grid, g, made):
    """BodyPair; made: {number of a body, and how its places are made: Samples} of other pairs, which it adds to."""
    collapsed = grid.collapsed
    slice_width = np.prod([np.ptp(grid.extent[axis]) for axis in np.flatnonzero(collapsed)]) if collapsed.any() else None
    radii = tuple(_radius(surface, motion, collapsed) for surface, motion in zip(surfaces, motions))
    size, masses = 2.0 * min(radii), [body.mass.mass for body in bodies]
    moving = [mass for mass, body in zip(masses, bodies) if not body.guided[:3].all()] or masses
    load = own.load if own and own.load is not None else min(moving) * g
    curvature = sum(1.0 / curvature_radius(surface) for surface in surfaces)
    radius = min(1.0 / curvature, size / 2) if curvature > 0.0 else np.inf
    spacing = radius / CURVED if curvature > 0.0 else size / PLANE
    extents = [_extents(surface, motion, collapsed) for surface, motion in zip(surfaces, motions)]
    cube = min(size, *(np.sqrt(3.0) * each[0] for each in extents))
    if not curvature and slice_width is None:
        spacing = min(spacing, max(min(each[1] for each in extents) / ACROSS, size / FINEST))
    overlap = 2.0 * spacing**2 / radius if curvature > 0.0 else SINKS * cube
    stiffness = load / (_area(overlap, radius, size, slice_width) * overlap)
    carried = 2.0 * load / (stiffness * SINKS * cube)     # [m²]; by places of one side, which have half of the stiffness
    width = carried / (size / 2 if slice_width is None else slice_width)
    depth = 0.0
    if slice_width is None:
        depth = min(max(flat_overlap(surface, load, stiffness) for surface in surfaces), DEEPEST * SINKS * cube)
    sides = []
    for a, b in ((0, 1), (1, 0)):
        flat, share = None, 1.0
        if collapsed.any():
            flat = motions[a].rotation[collapsed]
            share = slice_width / np.prod([np.ptp(surfaces[a].vertices @ axis) for axis in flat])
        how = spacing, width, carried, depth
        if (numbers[a], how) not in made:
            made[numbers[a], how] = sample(surfaces[a], *how, flat, share)
        samples = made[numbers[a], how]
        sides.append(Side(numbers[a], numbers[b], samples, surfaces[b], BEHIND * IMPACT * size))
    impact = 1.5 / sum(1.0 / mass for mass in moving) / (
        _area(IMPACT * size, radius, size, slice_width) * (IMPACT * size)**2)
    friction = own.friction if own and own.friction is not None else min(body.friction or 0.0 for body in described)
    return BodyPair(numbers, tuple(sides), stiffness, impact, size, Coulomb(friction, ROLLING), radii,
                    collapsed, load, overlap)


def _area(overlap, radius, size, slice_width):
    """Force over k times the overlap [m²]."""
    if slice_width is None:
        return np.pi * radius * overlap if np.isfinite(radius) else (size / 4)**2
    return 4 / 3 * slice_width * np.sqrt(2.0 * radius * overlap) if np.isfinite(radius) else slice_width * size / 4


def _radius(surface, motion, collapsed):
    """[m] of a ball around a body's section."""
    if not collapsed.any():
        return surface.radius
    across = surface.vertices @ motion.rotation[~collapsed].T
    return float(np.linalg.norm(across, axis=1).max()) + surface.tree.patches.bulge


def _extents(surface, motion, collapsed):
    """Extents [m] of a body's section along its principal axes, the least one first."""
    vertices = surface.vertices @ motion.rotation[~collapsed].T
    _, axes = np.linalg.eigh(np.atleast_2d(np.cov(vertices.T)))
    return np.sort(np.ptp(vertices @ axes, axis=0))


def _history(pair, motions):
    """PairHistory at the start, whose places inside the other body have no force."""
    poses, empty, parts = [motion.pose for motion in motions], PairHistory.empty(), []
    if pair.distance(poses) > ALLOWED_OVERLAP * pair.size:
        return empty
    for i, side in enumerate(pair.sides):
        begun = body_to_body.begin(side, poses, poses, ALLOWED_OVERLAP * pair.size, empty.side(i), pair.stiffness, pair.law,
                                   pair.collapsed)
        depth = begun.places.depth
        found = replace(begun, rest=-depth, overlap=np.full(len(depth), np.inf)).evaluate(poses)
        rest = found.gap - depth[found.active]
        parts += [begun.places.number[found.active], begun.start[found.active], rest]
    return PairHistory(*parts, np.ones(1))
