"""Residual and tangent of one step for soil and bodies together.

    R_u = f_int + m a - m g + Σ contact            on the free soil unknowns           [N]
    R_w = inertia - weight + line + Σ contact      on each body's free unknowns        [N, N m]

A Step freezes what the committed state provides (basis, nodal mass, corners near the bodies). Unknowns are trial
values; an Evaluation is what they give. None of them writes into the State they came from.
"""

from dataclasses import dataclass

import numpy as np

from hybrid.body import rigid
from hybrid.contact.contact_pair import Contact, ContactPair
from hybrid.runtime import comm
from hybrid.runtime.timing import phase
from hybrid.soil.model import SoilStep, SoilTrial
from hybrid.soil.transfer import interpolate
from hybrid.state import State
from hybrid.step.model import Model

ROUNDING = 1e-14  # of positions and increments: a force of inertia or contact that this alone can make is no residual
LARGEST_TURN = 2.0  # [rad] of a body in a step; from half a turn on it cannot be told from one the other way


@dataclass(frozen=True)
class Unknowns:
    """Trial values: nodal displacement increments (N, 3) [m] (None when the soil is held), poses of the bodies."""

    displacement: np.ndarray | None
    poses: tuple


@dataclass(frozen=True)
class Evaluation:
    """Residual and parts at trial unknowns.

    soil (n,) [N] and body (m,) [N, N m]: residual on the unknowns; error: largest field residual relative to the
    forces acting in that field; norms: the same in physical units by field name; rates: `Scheme.advance` of the nodes;
    reactions: (6,) of each body's guides.
    """

    unknowns: Unknowns
    soil: np.ndarray
    body: np.ndarray
    error: float
    norms: dict
    soil_trial: SoilTrial | None
    rates: tuple | None
    body_trials: tuple
    contacts: tuple[Contact, ...]
    reactions: tuple


class Step:
    """Equations of one increment `dt` [s] from `state`; `pulling` tells whether pull lines act."""

    def __init__(self, model: Model, state: State, dt, pulling, systems):
        self.model, self.state, self.dt = model, state, dt
        self.gravity = model.loads.on_bodies(state.time + dt)
        soil = model.soil
        with phase("transfer"):
            self.soil: SoilStep | None = None if soil.held else soil.begin(
                state.points, model.loads.on_points(state.time + dt, soil.constants.position))
            active = np.ones(soil.grid.node_count, bool) if soil.held else self.soil.active
            self.pattern, self.system = systems.get(
                active & ~soil.grid.fixed.all(axis=1), None if soil.held else soil.small_support(self.soil))
        self.targets = tuple(
            s.target + dt * b.line.velocity if pulling and b.line else None for b, s in zip(model.bodies, state.bodies))
        with phase("contact search"):
            self.reach = [self._reach(b, s) for b, s in zip(model.bodies, state.bodies)]
            guess, points = self.predictor(), self.soil.points if self.soil else state.points
            self.pairs = [
                ContactPair(b, s, history, points, self._corner_half(), soil.grid, active, reach,
                     (guess.displacement, pose))
                for b, s, history, reach, pose in zip(
                    model.bodies, state.bodies, state.contacts, self.reach, guess.poses)]
        self.line_before = [
            np.zeros(3) if t is None else
            rigid.evaluate(b, s, (s.position, s.rotation), s.target, self.gravity, model.scheme, dt).line[:3]
            for b, s, t in zip(model.bodies, state.bodies, self.targets)]
        self._free = model.body_free

    def _corner_half(self):
        points = self.state.points
        return points.half_width if self.model.soil.basis == "gimp" else np.zeros_like(points.half_width)

    def _reach(self, body, state):
        """Distance [m] from a body within which corners are followed: a cell, or the way both may go in the step."""
        fastest = 0.0 if self.soil is None else comm.largest(np.abs(self.soil.velocity))
        speed = np.linalg.norm(state.velocity) + np.linalg.norm(state.spin) * body.radius + fastest
        return max(self.model.soil.grid.smallest_cell, 2 * self.dt * speed)

    def contrast(self):
        """Stiffness of contact on a point over that of a cell, E h [-]; 0 without contact or soil."""
        if self.soil is None:
            return 0.0
        cell = self.model.soil.law.young * self.model.soil.grid.smallest_cell
        return max((float(np.max(b.contact_stiffness / cell)) for b in self.model.bodies), default=0.0)

    def predictor(self):
        """First guess: everything keeps its velocity."""
        displacement = None
        if self.soil is not None:
            displacement = self.dt * self.soil.velocity if self.model.scheme.inertia else 0 * self.soil.velocity
        return Unknowns(displacement, tuple(
            rigid.predicted_pose(b, s, self.model.scheme, self.dt)
            for b, s in zip(self.model.bodies, self.state.bodies)))

    def at_rest(self):
        """Unknowns of a step in which nothing moves."""
        return Unknowns(None if self.soil is None else np.zeros_like(self.soil.velocity),
                        tuple((s.position, s.rotation) for s in self.state.bodies))

    def apex_fraction(self, evaluation):
        """Share of the soil that has no stiffness left at an evaluation."""
        return 0.0 if self.soil is None else self.model.soil.apex_fraction(evaluation.soil_trial)

    def search_radius_ratio(self, unknowns):
        """Largest ratio of the way soil and body went towards each other to the reach of the corner search."""
        ratio = 0.0
        fastest = 0.0
        if self.soil is not None:  # of the points: a node that hardly carries mass may move far and mean nothing
            moved = interpolate(self.soil.basis, self.model.soil.grid.shape, unknowns.displacement)
            fastest = comm.largest(np.abs(moved))
        for body, state, pose, reach in zip(self.model.bodies, self.state.bodies, unknowns.poses, self.reach):
            turned = np.linalg.norm(pose[1] - state.rotation, 2) * body.radius
            ratio = max(ratio, (np.linalg.norm(pose[0] - state.position) + turned + fastest) / reach)
        return ratio

    def rotation_too_large(self, unknowns=None):
        """Why a step must not be made because of a body that turns too far in it, by its spin before the step or by
        trial unknowns; empty when none does."""
        for i, (body, state) in enumerate(zip(self.model.bodies, self.state.bodies)):
            angle = self.dt * np.linalg.norm(state.spin)
            if unknowns is not None:
                angle = max(angle, rigid.rotation_angle(body, state, unknowns.poses[i], self.model.scheme, self.dt))
            if angle > LARGEST_TURN:
                return f"{body.name} turns by {angle:.3g} rad in {self.dt:.3g} s, limit {LARGEST_TURN:g} rad"
        return ""

    def tunnelled(self, evaluation):
        """Number of corners that the step carried through a body, deeper than a twentieth of a cell."""
        depth = 0.05 * self.model.soil.grid.smallest_cell
        unknowns = evaluation.unknowns
        return sum(pair.tunnelled(contact, unknowns.displacement, pose, depth)
                   for pair, contact, pose in zip(self.pairs, evaluation.contacts, unknowns.poses))

    def augment(self, evaluation):
        """Update the multipliers of bodies with an augmented Lagrangian; False when none of them touches anything."""
        touching = [(pair, contact) for pair, contact in zip(self.pairs, evaluation.contacts)
                    if pair.body.augmented and len(contact)]
        for pair, contact in touching:
            pair.augment(contact)
        return bool(touching)

    def moved(self, unknowns, soil, body, scale=1.0):
        """Unknowns after `scale` times the increments soil (n,), body (m,)."""
        displacement = unknowns.displacement
        if displacement is not None:
            displacement = displacement.copy()
            displacement[self.pattern.free] += scale * soil
        full = np.zeros(self._free.shape)
        full[self._free] = scale * body
        return Unknowns(displacement, tuple(rigid.moved_pose(p, d) for p, d in zip(unknowns.poses, full)))

    def evaluate(self, unknowns):
        """Evaluation at trial unknowns, or None when soil would turn inside out."""
        model, displacement = self.model, unknowns.displacement
        trial = rates = None
        fields = {}
        if self.soil is not None:
            with phase("soil"):
                trial = model.soil.evaluate(self.soil, displacement)
            if trial is None:
                return None
            rates = model.scheme.advance(displacement, *self.soil.history, self.dt)
            fields["internal"], fields["weight"] = trial.force, -self.soil.weight
            fields["inertia"] = self.soil.mass[:, None] * rates[1]
            fields["contact"] = np.zeros_like(trial.force)
        with phase("contact"):
            contacts = tuple(p.evaluate(displacement, pose) for p, pose in zip(self.pairs, unknowns.poses))
            on_body = [p.add_residual(c, fields.get("contact")) for p, c in zip(self.pairs, contacts)]
        bodies = tuple(
            rigid.evaluate(b, s, p, target, self.gravity, model.scheme, self.dt)
            for b, s, p, target in zip(model.bodies, self.state.bodies, unknowns.poses, self.targets))
        springs = [p.springs(c) for p, c in zip(self.pairs, contacts)]
        soil, soil_norm, soil_error = self._soil_residual(fields, displacement, springs)
        body, reactions, body_norms, body_error = self._body_residual(bodies, on_body, unknowns.poses, springs)
        return Evaluation(unknowns, soil, body, max(soil_error, body_error), {**soil_norm, **body_norms}, trial,
                          rates, bodies, contacts, reactions)

    def _soil_residual(self, fields, displacement, springs):
        if not fields:
            return np.zeros(0), {}, 0.0
        free = self.pattern.free
        parts = [part[free] for part in fields.values()]
        residual = sum(parts)
        norm, scale = comm.norm(residual), max(comm.norm(part) for part in parts)
        noise = ROUNDING * (self.model.scheme.mass_factor(self.dt) * comm.norm(
            (self.soil.mass[:, None] * displacement)[free]) + np.abs(self.model.soil.grid.extent).max() * sum(springs))
        return residual, {"soil [N]": norm}, max(norm - noise, 0.0) / scale if scale > 0 else 0.0

    def _body_residual(self, trials, contact, poses, springs):
        residuals, reactions, norms, error = [], [], {}, 0.0
        for body, trial, touch, pose, spring in zip(self.model.bodies, trials, contact, poses, springs):
            parts = np.array([trial.inertia, trial.weight, trial.line, touch])
            total = parts.sum(axis=0)
            residuals.append(total[body.free])
            reactions.append(np.where(body.free, 0.0, total))
            free = np.where(body.free, total, 0.0)
            force, moment = np.linalg.norm(free[:3]), np.linalg.norm(free[3:])
            scale = np.linalg.norm(parts[:, :3], axis=1).max()
            arm = max(np.linalg.norm(parts[:, 3:], axis=1).max(), scale * body.radius)
            norms |= {f"{body.name} [N]": force, f"{body.name} [N m]": moment}
            noise = ROUNDING * (self.model.scheme.mass_factor(self.dt) * body.mass.mass + spring) * (
                np.linalg.norm(pose[0]) + body.radius)
            error = max(error, (force - noise) / scale if scale > 0 else 0.0,
                        (moment - noise * body.radius) / arm if arm > 0 else 0.0)
        return np.concatenate([np.zeros(0), *residuals]), tuple(reactions), norms, error

    def assemble(self, evaluation):
        """Fill the block system with the tangent at an evaluation."""
        model, system = self.model, self.system
        system.clear()
        if self.soil is not None:
            with phase("assemble"):
                model.soil.fill_stiffness(self.soil, evaluation.soil_trial, self.pattern, system.values,
                                          evaluation.error)
                mass = np.repeat(self.soil.mass[:, None], 3, axis=1)[self.pattern.free]
                system.values[self.pattern.diagonal] += model.scheme.mass_factor(self.dt) * mass
        first = 0
        for body, pair, trial, contact in zip(
                model.bodies, self.pairs, evaluation.body_trials, evaluation.contacts):
            with phase("contact"):
                own = slice(first, first + np.count_nonzero(body.free))
                ww = pair.add_tangent(contact, self.pattern, system.values, system.uw[:, own], system.wu[own])
                system.ww[own, own] += (ww + trial.tangent)[np.ix_(body.free, body.free)]
                first = own.stop
        with phase("factor"):
            system.factor()

    def accept(self, evaluation):
        """New State at a converged evaluation, with work done in the step added."""
        model, state, unknowns = self.model, self.state, evaluation.unknowns
        points, work = state.points, dict(state.work)
        with phase("update"):
            if self.soil is not None:
                points = model.soil.accept(self.soil, evaluation.soil_trial, unknowns.displacement, *evaluation.rates)
                work["plastic"] = work.get("plastic", 0.0) + model.soil.plastic_work(self.soil, evaluation.soil_trial)
            bodies = [rigid.accept(b, s, p, s.target if target is None else target, reaction, model.scheme, self.dt)
                      for b, s, p, target, reaction in zip(
                          model.bodies, state.bodies, unknowns.poses, self.targets, evaluation.reactions)]
            for body, before, now in zip(model.bodies, state.bodies, evaluation.reactions):
                if body.drive.any():
                    mean = now if before.reaction is None else 0.5 * (before.reaction + now)
                    work["drive"] = work.get("drive", 0.0) + float(mean @ (self.dt * body.drive))
            contacts = [p.commit(c, unknowns.displacement) for p, c in zip(self.pairs, evaluation.contacts)]
            for contact in evaluation.contacts:
                work["friction"] = work.get("friction", 0.0) + contact.dissipated
            for body, trial, before in zip(model.bodies, evaluation.body_trials, self.line_before):
                if body.line:
                    force = -0.5 * (before + trial.line[:3])
                    work["pull"] = work.get("pull", 0.0) + float(force @ (self.dt * body.line.velocity))
        if not model.loads.gravity_alone:
            work["load"] = work.get("load", 0.0) + self._load_work(points, bodies)
        return State(state.time + self.dt, state.step, points, bodies, contacts, work, state.ground)

    def _load_work(self, points, bodies):
        """Work [J] of all loads but the whole of gravity."""
        loads, begin, end = self.model.loads, self.state.time, self.state.time + self.dt
        work = 0.0
        if self.soil is not None:
            soil = self.model.soil.constants
            work = loads.work(begin, end, soil.mass, soil.position, points.position - self.state.points.position)
        mean = 0.5 * (loads.on_bodies(begin) + loads.on_bodies(end)) - loads.gravity
        return work + sum(body.mass.mass * float(mean @ (new.position - old.position))
                          for body, old, new in zip(self.model.bodies, self.state.bodies, bodies))
