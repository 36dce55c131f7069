"""What stays the same during a stage: soil, bodies, integration rule, loads, settings of the solver."""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body import rigid, stage_start
from hybrid.body.joints import Joint
from hybrid.body.point_guides import PointGuide
from hybrid.body.rigid import FREEDOMS, RigidBody
from hybrid.scene import Solver
from hybrid.scheme import Scheme
from hybrid.soil.model import Soil
from hybrid.step import joint_rates
from hybrid.step.loads import Loads
from hybrid.step.pair_terms import BodyPair
from hybrid.step.work import by_component

RATES = "velocity", "spin", "acceleration", "spin_rate"     # of a motion


@dataclass(frozen=True)
class Model:
    """What is modelled in a stage; it never changes. solver: the scene's own settings of Newton's method and of the
    linear systems inside it; joints: of bodies, with their pairs of numbers; pairs: of bodies that may touch
    one another; guides: of points of bodies in the stage."""

    soil: Soil
    bodies: tuple[RigidBody, ...]
    scheme: Scheme
    loads: Loads
    solver: Solver = Solver()
    joints: tuple[Joint, ...] = ()
    pairs: tuple[BodyPair, ...] = ()
    guides: tuple[PointGuide, ...] = ()

    @property
    def gravity(self):
        """The whole of gravity, whatever share of it acts, (3,) [m/s²]."""
        return self.loads.gravity

    @property
    def constraints(self):
        """Joints and guides of points, in the order of their rows."""
        return self.joints + self.guides

    @property
    def mirrors(self):
        """Planes of symmetry that bodies lie in, each once."""
        return tuple({(mirror.axis, mirror.at): mirror for body in self.bodies for mirror in body.mirrors}.values())

    @property
    def body_slices(self):
        """Slice of each body's free components among the unknowns of the bodies."""
        ends = np.cumsum([0, *(np.count_nonzero(body.free) for body in self.bodies)]).tolist()
        return tuple(map(slice, ends, ends[1:]))

    @property
    def component_places(self):
        """(b, 6) place of each body's components among the unknowns of the bodies, -1 of those that are none."""
        places = np.full((len(self.bodies), 6), -1)
        for row, body, unknowns in zip(places, self.bodies, self.body_slices):
            row[body.free] = np.arange(unknowns.start, unknowns.stop)
        return places

    def of_bodies(self, values):
        """[(6,)] of each body from `values` (m,) on the unknowns of the bodies, 0 in components that are none."""
        found = np.zeros((len(self.bodies), 6))
        for row, body, unknowns in zip(found, self.bodies, self.body_slices):
            row[body.free] = values[unknowns]
        return found

    @property
    def body_unknowns(self):
        """Number of free components of all bodies, and of rows of their joints."""
        return sum(int(np.count_nonzero(body.free)) for body in self.bodies) + sum(len(j.bounds) for j in self.constraints)

    def with_soil(self, soil):
        """The same model with other soil."""
        bodies = tuple(rigid.with_stiffness(body, soil.law.young, soil.held) for body in self.bodies)
        return replace(self, soil=soil, bodies=bodies)

    def for_stage(self, held=(), beta=None, gamma=None, loads=None, number=None, start=0.0):
        """The same model with more components ("x" ... "rz") of every body held and, if given, Newmark's rule or other
        loads; number: of the stage, from 0, with what it changes of bodies, from its `start` [s] on."""
        held = np.isin(FREEDOMS, held)
        bodies = tuple(replace(b, free=b.free & ~held, drive=b.drive * ~held) for b in self.bodies)
        guides = tuple(guide.of_body(i, start) for i, b in enumerate(bodies) if number is not None and b.stages
                       for guide in b.stages[number].points)
        bodies = tuple(b if number is None or not b.stages else b.stages[number].apply(b, start) for b in bodies)
        return replace(self, scheme=self.scheme.with_pair(beta, gamma), bodies=bodies, loads=loads or self.loads,
                       guides=guides)

    def begin_stage(self, state, before=None, lines=0):
        """`state` at the start of a stage of this model: guides release bodies or engage them, and loads begin to act. The
        work of the impulse that brings a body to the rates of its guides is work of the drive. before: Model of the stage
        before, None at the start of a run; lines: 1 where pull lines begin to act, -1 where they cease to."""
        gravity, bodies, work = self.loads.on_bodies(state.time), [], dict(state.work)
        more = gravity - before.loads.on_bodies(state.time) if before else np.zeros(3)
        if before and before.guides:
            state = joint_rates.released(self, state, before.guides)
        joined = {number for joint in self.joints for number in joint.bodies}
        for i, (body, motion) in enumerate(zip(self.bodies, state.bodies, strict=True)):
            if self.scheme.inertia:
                motion = stage_start.release_guides(body, motion)
            free = motion
            motion, impulse_work = stage_start.engage_guides(body, motion, gravity, self.scheme, i in joined)
            if impulse_work:
                work["drive"] = work.get("drive", 0.0) + impulse_work
                for name, done in by_component(body, rigid.impulse_work(body, free, motion)):
                    work[name] = work.get(name, 0.0) + done
            motion, line_work = stage_start.begin_line(body, motion, lines, self.scheme)
            if line_work:
                work["pull"] = work.get("pull", 0.0) + line_work
            bodies.append(stage_start.begin_loads(body, motion, state.time, self.scheme, more))
        same = before is not None and self._goes_on(before, state.bodies, bodies)
        bodies, joints, lost = joint_rates.begin_stage(self, bodies, state.joints, same)
        if lost:
            work["drive"] = work.get("drive", 0.0) - lost
        return replace(state, points=self._with_gravity(state.points, more), bodies=bodies, work=work, joints=joints)

    def _goes_on(self, before, earlier, bodies):
        """Whether a stage leaves all bodies as that `before` had them: what is free and, in their motions `earlier` and now,
        their rates."""
        if before.guides or self.guides:
            return False
        return all(np.array_equal(old.free, new.free) for old, new in zip(before.bodies, self.bodies)) and all(
            np.array_equal(getattr(old, name), getattr(new, name)) for old, new in zip(earlier, bodies) for name in RATES)

    def _with_gravity(self, points, more):
        """Points to which so much `more` (3,) [m/s²] gravity acts from now on: it accelerates them before stress answers."""
        if self.soil.held or not (self.scheme.inertia and more.any()):
            return points
        algorithmic = None if points.algorithmic is None else points.algorithmic + more
        return replace(points, acceleration=points.acceleration + more, algorithmic=algorithmic)

    def beginning(self):
        """The same model for an increment in which forces begin: by generalised alpha with ρ∞ = 0, in which pressure that
        begins does not ring."""
        return replace(self, scheme=Scheme.generalised_alpha(0.0)) if self.scheme.spectral_radius > 0.0 else self

    def pushed(self, before, state):
        """Numbers of the bodies that forces begin to push, or guides to move, where a stage turns the state `before` into
        `state`. At the start of a run, where it is None, all of them with ρ∞ = 0 and none with another one, which its first
        increment keeps: a body on a line would lose its order. None with schemes other than generalised alpha either, in
        which pressure that begins rings."""
        if not self.scheme.auxiliary:
            return set()
        if before is None:
            return set() if self.scheme.spectral_radius > 0.0 else set(range(len(self.bodies)))
        return {i for i, (body, old, new) in enumerate(zip(self.bodies, before.bodies, state.bodies))
                if stage_start.force_between(body, old, new).any() or (old.velocity != new.velocity).any()
                or (old.spin != new.spin).any()}

    def lay_out_lines(self, state):
        """`state` with the pull lines of all bodies laid out, just taut, where they are not yet."""
        return replace(state, bodies=[
            rigid.lay_out_line(body, motion) for body, motion in zip(self.bodies, state.bodies, strict=True)])
