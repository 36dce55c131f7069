"""A body in one increment, and its terms in the equations: FORMULATION (33), (37) and its contact.

    R_w = inertia - weight + line + Σ contact - loads - joints - other bodies - support    [N, N m]    on free components
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body import guides, rigid
from hybrid.body.rigid import BodyTrial, RigidBody
from hybrid.contact.assembly import Tangent
from hybrid.contact.contact_pair import ContactPair
from hybrid.contact.contact_points import SoilSurface
from hybrid.contact.on_ground import GroundPair, of_soil
from hybrid.contact.search import Reach
from hybrid.contact.soil_to_body import PointContact
from hybrid.runtime.comm import anywhere
from hybrid.scheme import Scheme
from hybrid.state import BodyState
from hybrid.step import joint_terms, soil_terms
from hybrid.step.rolling import rolling_rate
from hybrid.step.search_reach import search_reach

# Nothing damps errors of the moments in free flight, and rotation about the middle axis amplifies them: relative to
# all of the moments of inertia, a tolerance of 1e-6 makes the period of a plate wrong by 4e-5, where the scheme is wrong by
# 1e-6. With the default tolerance, 1e-4, rates are solved to 1e-10.
FLIGHT = 1e-6
ON_ARM = "line", "contact", "joints", "bodies"     # terms that act on an arm of the body, known or not
# Without inertia a body may have no stiffness, or that of a corner of another one: what is out of balance moves it by at
# most PACE of its size in an iteration, less where others are beside it, and REST of the stiffness of its contact is added
# against motions that nothing resists, as the rolling of a ball. Of 18 smooth balls and pipes on clay and elastic ground, at
# random places, 13 find a solution with 0.01, 17 with 0.03, and all with 0.1, in more iterations; a stack needs 0.01.
PACE, REST = {True: 0.01, False: 0.03}, 1e-6
# Share of what is out of balance that contact of a body bears at most where the body counts as one that touches nothing: a
# cylinder may stand on two points beside one another, about which nothing keeps it from turning.
UNSUPPORTED = 0.01


@dataclass(frozen=True)
class BodyStep:
    """A body as it is frozen during a step.

    number    of the body in the model and in the state
    body      its constants, with the mask of its free components
    state     committed motion
    target    (3,) [m] far end of its pull line at the end of the step, None where no line acts
    pair      its contact with the soil; reach: of the search for it
    unknowns  slice of the bodies' unknowns that are its own
    line_force  (3,) [N] residual of the line at the start of the step
    gravity   (3,) [m/s²] that acts at the end of the step
    scheme    rule of integration in time
    dt, begin [s] length of the step, and its start
    support   (2, 6) [N, N m] at its start and its end, None: none (`hybrid.step.support`)
    """

    number: int
    body: RigidBody
    state: BodyState
    target: np.ndarray | None
    pair: ContactPair | GroundPair
    reach: Reach
    unknowns: slice
    line_force: np.ndarray
    gravity: np.ndarray
    scheme: Scheme
    dt: float
    begin: float = 0.0
    support: np.ndarray | None = None

    @property
    def free(self):
        """(6,) bool mask of its unknowns."""
        return self.body.free

    def pose(self, unknowns):
        """(position, rotation) at trial Unknowns."""
        return unknowns.poses[self.number]

    def predicted_pose(self):
        """Pose at the end of the step if it keeps its rates."""
        return rigid.predicted_pose(self.body, self.state, self.scheme, self.dt)

    def extrapolated_pose(self):
        """Pose at the end of a quasi-static step if its centre also keeps the mean rate of the last one."""
        position, rotation = self.predicted_pose()
        return position + self.dt * self.state.velocity * self.free[:3], rotation

    def driven_pose(self):
        """Pose at the end of the step if it moves only as it is driven."""
        position, rotation = self.predicted_pose()
        return (np.where(self.free[:3], self.state.position, position),
                self.state.rotation if self.free[3:].all() else rotation)

    def moved_pose(self, unknowns, increment):
        """Pose at trial Unknowns after an `increment` of all bodies' unknowns (m,)."""
        full = np.zeros(6)
        full[self.free] = increment[self.unknowns]
        return rigid.moved_pose(self.pose(unknowns), full)

    def at_start(self, displacement, gravity):
        """{name: (6,) [N, N m]} weight, line, contact and loads at the start of the step. displacement: (N, 3) of 0 [m],
        None for held soil; gravity: (3,) [m/s²] then."""
        pose, target = self.state.pose, None if self.target is None else self.state.target
        trial = rigid.evaluate(self.body, self.state, pose, target, gravity, self.scheme, self.dt, self.begin)
        contact = -self.pair.evaluate(displacement, pose).resultant
        return {"weight": trial.weight, "line": trial.line, "contact": contact, "loads": trial.load}

    def rotation_angle(self, unknowns=None):
        """Angle [rad] of its rotation in the step, by its committed spin and by trial Unknowns."""
        angle = self.dt * np.linalg.norm(self.state.spin)
        if unknowns is None:
            return angle
        return max(angle, rigid.rotation_angle(self.body, self.state, self.pose(unknowns), self.scheme, self.dt))

    def evaluate(self, unknowns, nodal_contact, joints=None, pairs=None):
        """BodyTerms at trial Unknowns. Its contact is added to `nodal_contact` (N, 3) [N], None for held soil; joints:
        JointTerms, None without joints; pairs: PairTerms, None where bodies do not touch one another."""
        pose = self.pose(unknowns)
        contact = self.pair.evaluate(unknowns.displacement, pose)
        on_body = self.pair.add_residual(contact, nodal_contact)
        trial = rigid.evaluate(self.body, self.state, pose, self.target, self.gravity, self.scheme, self.dt,
                               self.begin + self.dt)
        terms = {"inertia": trial.inertia, "weight": trial.weight, "line": trial.line, "contact": on_body,
                 "loads": trial.load}
        springs = self.pair.springs(contact)
        if joints:
            terms["joints"] = joints.on_body(self.number)
        if self.support is not None:
            terms["support"] = -self.support[1]
        if pairs:
            terms["bodies"] = pairs.on_body(self.number)
            springs = float(np.hypot(springs, pairs.springs(self.number)))
        return BodyTerms(self, pose, trial, contact, terms, springs, pairs is not None)


@dataclass(frozen=True)
class BodyTerms:
    """Terms of a body at a trial pose, position (3,) [m] and rotation (3, 3).

    terms: {name: (6,) [N, N m]} inertia, weight, line, contact, loads and, where there are any, joints, support and
    contact with other bodies; trial: BodyTrial, contact: PointContact at that pose; springs: [N/m] stiffness of its
    contact; beside: whether other bodies may touch it."""

    step: BodyStep
    pose: tuple
    trial: BodyTrial
    contact: PointContact
    terms: dict
    springs: float
    beside: bool = False

    @property
    def total(self):
        """(6,) [N, N m] sum of all terms."""
        return sum(self.terms.values())

    @property
    def residual(self):
        """(k,) on its unknowns."""
        return self.total[self.step.free]

    @property
    def reaction(self):
        """(6,) [N, N m] of the guides of its held and driven components."""
        return np.where(self.step.free, 0.0, self.total)

    @property
    def unsupported(self):
        """Whether contact with the soil bears nothing yet, or hardly anything of what is out of balance."""
        left = np.linalg.norm(np.where(self.step.free, self.total, 0.0)[:3])
        return np.linalg.norm(self.terms["contact"][:3]) <= UNSUPPORTED * left

    @property
    def largest_force(self):
        """[N], of all terms."""
        return self._largest(self.terms, slice(3))

    def error(self, least=0.0):
        """Norms of the residual {name: value}, and the larger of force and moment relative to the largest terms, to a force
        `least` [N] at least.

        A moment is compared with the moments acting and with the forces of contact, joints and line on the arm of the
        body. If none of them acts, as in free flight, it is compared with that of the loads, or with FLIGHT times those of
        the body's own inertia.
        """
        body = self.step.body
        free = np.where(self.step.free, self.total, 0.0)
        force, moment = np.linalg.norm(free[:3]), np.linalg.norm(free[3:])
        scale, on_arm = max(self.largest_force, least), self._largest(ON_ARM, slice(3))
        if on_arm > 0:
            arm = max(self._largest(self.terms, slice(3, 6)), on_arm * body.radius)
        else:
            arm = max(self._largest(["loads"], slice(3, 6)), FLIGHT * self.trial.own_moment)
        arm = max(arm, least * body.radius)
        noise = soil_terms.ROUNDING * (self.step.scheme.mass_factor(self.step.dt) * body.mass.mass + self.springs) * (
            np.linalg.norm(self.pose[0]) + body.radius)
        error = max((force - noise) / scale if scale > 0 else 0.0,
                    (moment - noise * body.radius) / arm if arm > 0 else 0.0)
        return {f"{body.name} [N]": force, f"{body.name} [N m]": moment}, error

    def _largest(self, names, components):
        """Largest norm of some `components` of the terms of these names."""
        return max(np.linalg.norm(self.terms[name][components]) for name in names if name in self.terms)

    def add_tangent(self, pattern, system, stiffness, kind=Tangent.CONSISTENT, carried=False):
        """Add contact, with a `kind` of Tangent, inertia and line to the block system; stiffness: [N/m] of a cell of the
        soil; carried: whether joints hold the body to one that is supported."""
        own, free = self.step.unknowns, self.step.free
        ww = self.step.pair.add_tangent(self.contact, pattern, system.values, system.uw[:, own], system.wu[own], kind)
        unresisted = self._against_nothing(stiffness, carried) * np.diag([1.0, 1.0, 1.0, *[self.step.body.radius**2] * 3])
        system.ww[own, own] += (ww + unresisted + self.trial.tangent)[np.ix_(free, free)]

    def _against_nothing(self, cell, carried):
        """[N/m] added against motions that nothing resists, or less than nothing: a pipe on a single point rolls off it, and
        the tangent alone leads back onto it. Without inertia an unsupported body has no stiffness: that of a `cell` leads it
        back to the soil under its weight, unless it is `carried`: a mast welded to a footing would hold that back."""
        if self.step.scheme.inertia:
            return 0.0
        if self.unsupported and not self.beside and not carried:
            return cell
        return self._pace() or (REST if carried else 1.0) * cell

    def _pace(self):
        """[N/m] with which the residual moves the body by PACE of its size; it vanishes with the residual."""
        radius, free = self.step.body.radius, np.where(self.step.free, self.total, 0.0)
        force = np.linalg.norm(free[:3]) + np.linalg.norm(free[3:]) / radius
        return force / (PACE[self.beside] * 2 * radius) + REST * self.springs

    def accept(self):
        """New BodyState."""
        step = self.step
        target = step.state.target if step.target is None else step.target
        return rigid.accept(step.body, step.state, self.pose, target, self.reaction, step.scheme, step.dt,
                            -self.trial.load if step.body.loads else None)


def _expected_pose(body, motion, history, gravity, scheme, dt, cell):
    """Pose of a body to which its contact points are predicted to move. One that touches nothing yet also falls,
    without inertia by a `cell` [m]: else a body that starts in contact and slides would find friction in its first step
    only if its places happen to rise against it."""
    position, rotation = rigid.predicted_pose(body, motion, scheme, dt)
    moving, weighs = motion.velocity.any() or motion.spin.any(), np.linalg.norm(gravity)
    if moving and weighs and not anywhere(history.touching):
        fall = 0.5 * dt**2 * gravity if scheme.inertia else cell * gravity / weighs
        position = position + fall * body.free[:3]
    return position, rotation


def begin_bodies(model, state, dt, pulling, domains, active, nodal):
    """Tuple of BodyStep. nodal: (velocity, predicted increments) of the nodes, (None, None) for held soil; domains:
    Domains of the soil's points; active: (N,) bool, nodes that carry mass."""
    gravity, grid, begun = model.loads.on_bodies(state.time + dt), model.soil.grid, []
    velocity, predicted = nodal
    soil = SoilSurface(domains, grid, active)
    along = joint_terms.rates_of_guides(model, state, dt)
    for number, (body, unknowns) in enumerate(zip(model.bodies, model.body_slices)):
        body = guides.during(body, state.time, dt, model.scheme.rotation == "cayley")
        body = replace(body, drive=body.drive + along[number]) if along is not None else body
        if not model.scheme.inertia:
            body = replace(body, drive=body.drive + rolling_rate(body, state.bodies[number], state.contacts[number]))
        motion = rigid.begin_increment(body, state.bodies[number], model.scheme, dt)
        target, line_force = None, np.zeros(3)
        if pulling and body.line:
            target = motion.target + dt * body.line.velocity
            line_force = rigid.evaluate(body, motion, motion.pose, motion.target, gravity,
                                        model.scheme, dt).line[:3]
        fall = np.linalg.norm(gravity) * dt**2
        if not model.scheme.inertia:    # nothing falls, and the time of a step means nothing
            fall = min(fall, grid.smallest_cell)
        reach = search_reach(body, motion, grid, velocity, dt, fall)
        pose = _expected_pose(body, motion, state.contacts[number], gravity, model.scheme, dt, grid.smallest_cell)
        limits = body.interface and body.interface.of_points(model.soil.law, state.points.plastic_strain)
        history = state.contacts[number]
        if stretch := body.ground and body.ground.under(body, motion.pose, pose):
            pair = GroundPair(body, stretch, motion, history, reach, pose)
        else:
            pair = ContactPair(soil, body, motion, of_soil(history), reach, (predicted, pose), limits,
                               begins=state.time == 0.0)
        begun.append(BodyStep(number, body, motion, target, pair, reach, unknowns, line_force, gravity, model.scheme,
                              dt, state.time))
    return tuple(begun)
