"""Residual and tangent of one increment, for soil and bodies together: FORMULATION (1) and (2).

    R(u, w) = (R_u, R_w)        `hybrid.step.soil_terms`, `hybrid.step.body_terms`

    | K_uu  K_uw | | du |       | R_u |
    | K_wu  K_ww | | dw |  =  - | R_w |

`begin` freezes what the committed state provides in a Step: basis, nodal mass, contact points near the bodies. Unknowns are
trial values; an Evaluation is their residual with all its terms. None of them writes into the State they came from;
`Step.accept` makes the new one.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.contact.assembly import Tangent
from hybrid.contact.search import Domains
from hybrid.linalg.petsc import BlockSystem
from hybrid.linalg.stencil_pattern import Pattern
from hybrid.linalg.system_cache import CarriedTangent
from hybrid.runtime import comm
from hybrid.runtime.timing import phase
from hybrid.soil.model import SoilStep
from hybrid.state import State
from hybrid.step import assemblies, body_terms, flight, joint_rates, joint_terms, pair_terms, soil_terms
from hybrid.step.body_terms import BodyStep
from hybrid.step.evaluation import Evaluation, Unknowns
from hybrid.step.joint_terms import JointStep
from hybrid.step.model import Model
from hybrid.step.pair_terms import PairsStep
from hybrid.step.work import work_after


@dataclass(frozen=True)
class Step:
    """One increment of `dt` [s] from the committed `state`, frozen but for the points of contact (`ContactPair`) and
    `carried`.

    soil: None where it is held; reference: norm [N] of internal forces that the errors of the soil are relative to if
    all forces of a trial are smaller (`hybrid.step.newton` sets it)
    """

    model: Model
    state: State
    dt: float
    soil: SoilStep | None
    pattern: Pattern
    system: BlockSystem
    carried: CarriedTangent
    bodies: tuple[BodyStep, ...]
    reference: float = 0.0
    joints: JointStep | None = None
    pairs: PairsStep | None = None

    def solved_to(self, tolerance):
        """This Step with another tolerance of Newton's method."""
        return replace(self, model=replace(self.model, solver=replace(self.model.solver, tolerance=tolerance)))

    # -------------------------------------------------------------- trial values

    def predictor(self):
        """Unknowns where everything keeps its velocity."""
        return Unknowns(_predicted(self.model, self.soil, self.dt), tuple(b.predicted_pose() for b in self.bodies),
                        self.joints and self.state.joints.multipliers)

    def extrapolated(self):
        """Unknowns where soil and free bodies keep the mean rates of the last increment, without inertia."""
        return Unknowns(np.where(self.pattern.free, self.dt * self.soil.velocity, 0.0),
                        tuple(b.extrapolated_pose() for b in self.bodies), self.joints and self.state.joints.multipliers)

    def at_rest(self):
        """Unknowns where nothing moves."""
        return Unknowns(None if self.soil is None else np.zeros_like(self.soil.velocity),
                        tuple(b.state.pose for b in self.bodies), self.joints and self.state.joints.multipliers)

    def driven(self):
        """Unknowns where nothing moves but the driven components of bodies."""
        return replace(self.at_rest(), poses=tuple(b.driven_pose() for b in self.bodies))

    def moved(self, unknowns, soil, body, scale=1.0):
        """Unknowns after `scale` times the increments soil (n,), body (m,)."""
        displacement = unknowns.displacement
        if displacement is not None:
            displacement = displacement.copy()
            displacement[self.pattern.free] += scale * soil
        multipliers = unknowns.multipliers
        if self.joints:
            multipliers = multipliers + scale * self.joints.scale * body[self.joints.size:]
        return Unknowns(displacement, tuple(b.moved_pose(unknowns, scale * body) for b in self.bodies), multipliers)

    # -------------------------------------------------------------- residual and tangent

    def evaluate(self, unknowns, keep=None):
        """Evaluation at trial unknowns, or a Refusal where the soil has none; keep: an Evaluation that stays valid."""
        soil = nodal_contact = None
        if self.soil is not None:
            soil = soil_terms.evaluate(self, unknowns.displacement, keep and keep.soil_trial)
            nodal_contact = soil.forces["contact"]
        joints = self.joints and self.joints.evaluate(unknowns.poses, unknowns.multipliers)
        with phase("contact"):
            pairs = self.pairs and self.pairs.evaluate(unknowns.poses)
            bodies = tuple(b.evaluate(unknowns, nodal_contact, joints, pairs) for b in self.bodies)
            if soil is not None:
                if refusal := soil_terms.refusal(soil):
                    return refusal
                soil_terms.add_up(self.model.soil.grid, soil, bool(bodies))
        residual, norms, error, internal = np.zeros(0), {}, 0.0, 0.0
        if soil is not None:
            residual, internal, norms["soil [N]"], error = soil_terms.residual(
                self, soil, unknowns.displacement, [terms.springs for terms in bodies])
        for own, own_error in self._body_errors(bodies):
            norms, error = norms | own, max(error, own_error)
        on_bodies = [np.zeros(0), *(terms.residual for terms in bodies)]
        if joints:
            on_bodies.append(joints.residual())
            norms, error = norms | {"joints [m]": joints.opened()}, max(error, joints.error())
        return Evaluation(unknowns, residual, np.concatenate(on_bodies), error, norms, internal, soil and soil.trial,
                          soil and soil.rates, bodies, joints, pairs)

    def _body_errors(self, bodies):
        """[(norms, error)] of BodyTerms."""
        forces = [0.0 if self.model.scheme.inertia else terms.largest_force for terms in bodies]
        least = assemblies.least_forces(self.model.joints, forces)
        return [terms.error(force) for terms, force in zip(bodies, least)]

    def assemble(self, evaluation, kind=Tangent.CONSISTENT, elastic=0.0):
        """Fill the block system with the tangent at an evaluation, of a `kind` for contact and with a share of the `elastic`
        one for soil, and factor it."""
        self.carried.drop()
        self.system.clear()
        stiffness = comm.largest(self.model.soil.law.young) * self.model.soil.grid.smallest_cell
        if self.soil is not None:   # no process waits for another between soil and contact: they share the sum of both
            soil_terms.add_tangent(self, evaluation.soil_trial, evaluation.error, elastic)
        with phase("contact"):
            supported = [not terms.unsupported for terms in evaluation.bodies]
            holding = evaluation.joints.holding() if evaluation.joints else []
            for terms, carried in zip(evaluation.bodies, assemblies.supported_by_joints(holding, supported)):
                terms.add_tangent(self.pattern, self.system, stiffness, kind, carried)
            if evaluation.pairs:
                evaluation.pairs.add_tangent(self.system.ww)
            if evaluation.joints:
                evaluation.joints.add_tangent(self.system.ww)
        with phase("factor"):
            self.system.factor()

    def cells_crossed(self):
        """Number of cells [-] that a wave of speed √(E/ρ) crosses in the step, at the least."""
        soil = self.model.soil
        speed = np.sqrt(soil.law.young * soil.constants.volume / soil.constants.mass)
        return comm.minimum(speed) * self.dt / soil.grid.smallest_cell

    def apex_fraction(self, evaluation):
        """Share [-] of the soil that has no stiffness at an evaluation."""
        return 0.0 if self.soil is None else self.model.soil.apex_fraction(evaluation.soil_trial)

    def within_rounding(self, evaluation):
        """Whether the residual of the soil is no larger than the round-off of its stiffness, and those of every body and
        of the joints are within the tolerance."""
        soil, free, tolerance = self.model.soil, self.pattern.free, self.model.solver.tolerance
        limit = soil.roundoff_force(soil.grid.count_unknowns(free)) if self.soil is not None else 0.0
        others = [error for _, error in self._body_errors(evaluation.bodies)]
        others += [evaluation.joints.error()] if evaluation.joints else []
        return evaluation.norms.get("soil [N]", 0.0) <= limit and max(others, default=0.0) <= tolerance

    # -------------------------------------------------------------- acceptance

    def accept(self, evaluation, end=None):
        """New State at a converged evaluation. end: [s] where the increment completes its outer step: the time, free of
        the round-off of the increments, at which the state then has the next step number."""
        model, state, displacement = self.model, self.state, evaluation.unknowns.displacement
        with phase("update"):
            points = state.points
            if self.soil is not None:
                points = model.soil.accept(self.soil, evaluation.soil_trial, displacement, *evaluation.rates)
            bodies = [terms.accept() for terms in evaluation.bodies]
            contacts = [terms.step.pair.commit(terms.contact, displacement) for terms in evaluation.bodies]
            joints, lost = evaluation.joints and evaluation.joints.state(), 0.0
            if joints:
                bodies, joints, lost = joint_rates.engaged(self, evaluation.joints, bodies, joints)
            work = work_after(self, evaluation, points, bodies, lost)
        time, number = (state.time + self.dt, state.step) if end is None else (end, state.step + 1)
        pairs = evaluation.pairs.histories() if evaluation.pairs else []
        return State(time, number, points, bodies, contacts, work, state.ground, joints, pairs, self.dt)


def begin(model, state, dt, pulling, workspace):
    """Step of `dt` [s] from a committed `state`. pulling: whether pull lines act; workspace: a Workspace of the model.

    Raises StepError when a point has left the grid, or is detached and the run is to stop for it.
    """
    state = joint_rates.along_joints(model, for_increment(model.scheme, state, dt), dt)
    state = joint_rates.engage_guides(model, state, dt)
    soil, grid, points = None, model.soil.grid, state.points
    active, small_support = np.ones(grid.node_count, bool), None
    with phase("transfer"):
        if not model.soil.held:
            soil = soil_terms.begin(model, state, dt, workspace.soil)
            points, active, small_support = soil.points, soil.active, model.soil.small_support(soil)
        pattern, system = workspace.systems.get(active & ~grid.fixed.all(axis=1), small_support)
    domains = Domains.of(points, model.soil.constants, model.soil.basis, model.soil.ground)
    nodal = None if soil is None else soil.velocity, _predicted(model, soil, dt)
    with phase("contact search"):
        bodies = body_terms.begin_bodies(model, state, dt, pulling, domains, active, nodal)
    joints, pairs = joint_terms.begin_joints(model, state, dt), pair_terms.begin_pairs(model, state, bodies, dt)
    bodies = flight.with_schemes(model, bodies, pairs)
    return Step(model, state, dt, soil, pattern, system, workspace.systems.carried, bodies, joints=joints, pairs=pairs)


def for_increment(scheme, state, dt):
    """`state` with the algorithmic accelerations that keep what impulses have yet to give in an increment of `dt` [s]."""
    ratio = dt / state.increment if state.increment else 1.0
    if ratio == 1.0 or not scheme.auxiliary:
        return state
    points = state.points
    if points.algorithmic is not None:
        affine = points.affine
        if affine is not None:
            affine = np.concatenate([affine[:, :2], scheme.following(affine[:, 1:2], affine[:, 2:], ratio)], axis=1)
        points = replace(points, affine=affine,
                         algorithmic=scheme.following(points.acceleration, points.algorithmic, ratio))
    bodies = [body if body.algorithmic is None else replace(body, algorithmic=scheme.following(
        np.concatenate([body.acceleration, body.spin_rate]), body.algorithmic, ratio)) for body in state.bodies]
    return replace(state, points=points, bodies=bodies)


def _predicted(model, soil, dt):
    """Nodal increments (N, 3) [m] at constant velocity, none without inertia; None for held soil."""
    return None if soil is None else (dt if model.scheme.inertia else 0.0) * soil.velocity
