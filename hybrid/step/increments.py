"""The outer step: increments that are accepted, or rejected and shortened, until its end is reached.

    begin    freeze what the committed state provides; support bodies that cannot begin out of balance
    solve    Newton's method on trial values
    accept   a new committed state          if converged, and accurate where the scene sets time.accuracy
    reject   a shorter increment            otherwise

Newton's method sets the increment: it is halved after a failure and doubled after an easy solution. With time.accuracy
the estimated error sets it (`hybrid.step.error_estimate`).
"""

from dataclasses import dataclass

import numpy as np

from hybrid.runtime.comm import largest
from hybrid.runtime.errors import StepError
from hybrid.soil.model import Soil
from hybrid.step import failure_message, newton, processes
from hybrid.step.equations import begin
from hybrid.step.evaluation import Evaluation
from hybrid.step.error_estimate import even, following, local_error, shorter
from hybrid.step.support import ROUND_OFF, Support

EASY = 6            # Newton iterations up to which the next increment may be twice as long
SHORT = 1 / 8       # share of an outer step up to which an increment is short (`hybrid.step.newton.BETWEEN`)
# Share of the speed of a body, its rotation included: velocity to come from an impulse above which increments do not grow
PENDING = 0.02


def outer_step(model, workspace, state, length, pulling, control):
    """Advance `state` by `length` [s]; returns (new State, Report).

    Raises StepError when the increment would fall below control.smallest; the committed state is untouched.
    """
    control.begin(length)
    start, report, support = state, Report(length, 0.0 if control.accuracy else None), None
    while state.step == start.step:
        remaining = start.time + length - state.time
        dt = control.increment(remaining)
        step = outcome = None   # frees the last increment before the next one is begun
        model, state = processes.settle(model, state, workspace)
        step = begin(model, state, dt, pulling, workspace)
        step = support.under(step) if support else step
        outcome = newton.solve(step, dt <= SHORT * length, control.backtrack and model.soil.law.plastic)
        accepted, error = control.judge(step, outcome)
        report.count(outcome, accepted)
        if not accepted and not support and state.time == start.time:
            support = Support.at_start(step, length)
        if accepted:
            last = remaining - dt <= ROUND_OFF * length
            before, state = state, step.accept(outcome.evaluation, start.time + length if last else None)
            report.accept(dt, error)
            if not model.scheme.inertia:
                report.flow(before.points, state.points)
    report.evaluation, report.soil = outcome.evaluation, model.soil
    return state, report


def impulse_pending(step, evaluation):
    """Whether an impulse has yet to give a body a part of its velocity at the end of the increment of an Evaluation.

    Generalised alpha gives it over the next increments, by the acceleration that the body had in the increment of the
    impact times their own length: a longer one would give more than the impulse.
    """
    if not (step.bodies and step.model.scheme.auxiliary):
        return False
    fall = np.linalg.norm(step.model.gravity) * step.dt
    for terms in evaluation.bodies:
        new, radius = terms.accept(), terms.step.body.radius
        if new.algorithmic is None:
            continue
        left = (np.linalg.norm(new.algorithmic[:3] - new.acceleration)
                + radius * np.linalg.norm(new.algorithmic[3:] - new.spin_rate))
        speed = np.linalg.norm(new.velocity) + radius * np.linalg.norm(new.spin)
        if 0.5 * step.dt * left > PENDING * (speed + fall):
            return True
    return False


@dataclass
class Control:
    """Control of the increments.

    dt        [s] that the next increment tries
    smallest  [s] increment below which a step fails
    accuracy  [m] error of positions that an outer step may add, None where convergence alone decides
    backtrack whether the last increment needed backtracking in Newton's method, so that the next one begins with it
    """

    dt: float
    smallest: float
    accuracy: float | None = None
    backtrack: bool = False
    _length: float = 0.0        # [s] of the outer step
    _rejected: bool = False     # the last trial

    def begin(self, length):
        """Start an outer step of `length` [s]."""
        self.dt, self._length = min(self.dt, length), length

    def increment(self, remaining):
        """Increment [s] to try with `remaining` [s] of the outer step left."""
        dt = min(self.dt, remaining)
        return even(dt, remaining) if self.accuracy else dt

    def judge(self, step, outcome):
        """(whether to accept the trial, its LocalError or None), and set the next increment.

        Raises StepError where a trial is rejected and the next one would be too short.
        """
        self.backtrack = outcome.converged and outcome.backtracked
        if not outcome.converged:
            self._reject(step.dt / 2)
            if self.dt < self.smallest:
                raise StepError(failure_message.not_converged(step, outcome, self.smallest))
            return False, None
        easy = outcome.iterations <= EASY and not impulse_pending(step, outcome.evaluation)
        if not self.accuracy:
            self._accept(min(2 * self.dt, self._length) if easy else self.dt)
            return True, None
        error = local_error(step, outcome.evaluation)
        allowed = self.accuracy * step.dt / self._length
        ratio = error.length / allowed
        if ratio > 1:
            if step.dt <= self.smallest * (1 + ROUND_OFF):
                raise StepError(failure_message.not_accurate(step, error, allowed, self.accuracy, self.smallest))
            self._reject(max(shorter(step.dt, ratio), self.smallest))
            return False, error
        dt = following(step.dt, ratio, easy and not self._rejected)
        self._accept(min(max(dt, self.smallest), self._length))
        return True, error

    def _accept(self, dt):
        self.dt, self._rejected = dt, False

    def _reject(self, dt):
        self.dt, self._rejected = dt, True


@dataclass
class Report:
    """What an outer step took.

    dt          [s] its smallest increment
    error       [m] sum of the local errors of its increments, None without time.accuracy
    increments, rejections  accepted and rejected trials; judged: accepted with a residual a hair above the tolerance or
                within round-off, or with a contact point between two facets (`hybrid.step.newton`)
    iterations, krylov      of Newton's method and of the linear solver, in all trials
    plastic_increment       largest growth of the plastic strain of a point in an increment, 0 with inertia
    moved       [m] sum over increments of the largest displacement of a point, 0 with inertia
    evaluation  the last accepted one; soil: Soil whose points the new state has
    """

    dt: float
    error: float | None = None
    increments: int = 0
    rejections: int = 0
    judged: int = 0
    iterations: int = 0
    krylov: int = 0
    plastic_increment: float = 0.0
    moved: float = 0.0
    evaluation: Evaluation | None = None
    soil: Soil | None = None

    def count(self, outcome, accepted):
        """Add a trial."""
        self.iterations, self.krylov = self.iterations + outcome.iterations, self.krylov + outcome.krylov
        self.increments, self.rejections = self.increments + accepted, self.rejections + (not accepted)
        self.judged += accepted and outcome.judged

    def accept(self, dt, error):
        """Add an accepted increment."""
        self.dt = min(self.dt, dt)
        if error is not None:
            self.error += error.length

    def flow(self, before, after):
        """Add what an accepted increment did to the Points that it led from `before` to `after`."""
        self.plastic_increment = max(self.plastic_increment, largest(after.plastic_strain - before.plastic_strain))
        self.moved += largest(np.linalg.norm(after.position - before.position, axis=1))
