"""The outer step: increments that are accepted, or rejected and shortened, until its end is reached.

    begin    freeze what the committed state provides; support bodies that cannot begin out of balance
    solve    Newton's method on trial values
    accept   a new committed state          if converged, and accurate where the scene sets time.accuracy
    reject   a shorter increment            otherwise

Newton's method sets the increment: it is halved after a failure and doubled after an easy solution. With time.accuracy
the estimated error sets it (`hybrid.step.error_estimate`). While bodies hit one another it is as short as that needs
(`hybrid.step.pair_terms`), and one that finds an impact which was not predicted is done again.
"""

from dataclasses import dataclass, field

import numpy as np

from hybrid.runtime.comm import largest
from hybrid.runtime.errors import StepError
from hybrid.soil.model import Soil
from hybrid.step import failure_message, flight, newton, processes, stage_contact
from hybrid.step.equations import begin
from hybrid.step.evaluation import Evaluation
from hybrid.step.error_estimate import even, following, local_error, shorter
from hybrid.step.support import ROUND_OFF, Support

EASY = 6            # Newton iterations up to which the next increment may be twice as long
# Of an increment that resolves an impact: how much longer one may be, and below which share of it the step fails
ABOVE, FAILED = 1.25, 1 / 64
IMPULSE = 0.02      # share of a body's speed: half of an impulse after which increments do not grow at once
SHORT = 1 / 8       # share of an outer step up to which an increment is short (`hybrid.step.newton.BETWEEN`)


def outer_step(model, workspace, state, length, pulling, control):
    """Advance `state` by `length` [s]; returns (new State, Report).

    Raises StepError when the increment would fall below control.smallest, or FAILED of what an impact needs; the committed
    state is untouched.
    """
    control.begin(length)
    start, report, support = state, Report(length, 0.0 if control.accuracy else None), None
    while state.step == start.step:
        remaining = start.time + length - state.time
        dt = control.increment(remaining)
        step = outcome = None   # frees the last increment before the next one is begun
        model, state = processes.settle(model, state, workspace)
        step = begin(model.beginning() if control.pushed else model, state, dt, pulling, workspace)
        if control.too_long(dt, step.pairs.longest if step.pairs else np.inf):
            continue
        step = support.under(step) if support else step
        short = dt <= SHORT * length or control.shortest(dt)
        outcome = newton.solve(step, short, control.backtrack and model.soil.law.plastic)
        if outcome.converged and step.pairs and control.too_long(dt, step.pairs.unforeseen(outcome.evaluation.pairs)):
            report.count(outcome, False)
            continue
        if outcome.converged and (struck := flight.hit(step, outcome.evaluation)):
            report.count(outcome, False)
            state = flight.landed(model, state, struck)
            continue
        accepted, error = control.judge(step, outcome)
        report.count(outcome, accepted)
        if not accepted and not support and state.time == start.time:
            support = Support.at_start(step, length)
        if accepted:
            last = remaining - dt <= ROUND_OFF * length
            before, state = state, step.accept(outcome.evaluation, start.time + length if last else None)
            state, control.pushed = stage_contact.count_from_start(step, outcome.evaluation, state, control.pushed), set()
            report.accept(dt, error)
            if not model.scheme.inertia:
                report.flow(before.points, state.points)
    report.evaluation, report.soil = outcome.evaluation, model.soil
    return state, report


def in_impact(step, evaluation):
    """Whether forces other than weight change the speed of a body at the end of the increment of an Evaluation, and have
    begun to so late that generalised alpha does not show it yet.

    By the trapezoidal rule (FORMULATION (27b)) they count with half the length of the next increment: if they end in it, a
    longer one would give more than the impulse.
    """
    if not (step.bodies and step.model.scheme.auxiliary):
        return False
    gravity = np.concatenate([step.model.loads.on_bodies(step.state.time + step.dt), np.zeros(3)])
    for terms in evaluation.bodies:
        new, weights = terms.accept(), np.repeat([1.0, terms.step.body.radius], 3)
        if new.algorithmic is None:
            continue
        now = np.concatenate([new.acceleration, new.spin_rate])
        change = min(_size(weights * (new.algorithmic - now)), _size(weights * (now - gravity)))
        speed = _size(weights * np.concatenate([new.velocity, new.spin])) + step.dt * np.linalg.norm(gravity)
        if 0.5 * step.dt * change > IMPULSE * speed:
            return True
    return False


def _size(motion):
    """Sum of the sizes of both parts of a (6,) motion."""
    return np.linalg.norm(motion[:3]) + np.linalg.norm(motion[3:])


@dataclass
class Control:
    """Control of the increments.

    dt        [s] that the next increment tries
    smallest  [s] increment below which a step fails
    accuracy  [m] error of positions that an outer step may add, None where convergence alone decides
    backtrack whether the last increment needed backtracking in Newton's method, so that the next one begins with it
    pushed    numbers of the bodies that forces begin to push at the start of the next increment
    """

    dt: float
    smallest: float
    accuracy: float | None = None
    backtrack: bool = False
    pushed: set = field(default_factory=set)
    _length: float = 0.0        # [s] of the outer step
    _finest: float = 0.0        # [s] increment below which it fails, `smallest` or what an impact needs
    _impact: float = np.inf     # [s] increment that resolves the impacts of this one
    _rejected: bool = False     # the last trial

    def __post_init__(self):
        self._finest = self.smallest

    def begin(self, length):
        """Start an outer step of `length` [s]."""
        self.dt, self._length, self._finest = min(self.dt, length), length, self.smallest

    def too_long(self, dt, impact):
        """Whether an increment of `dt` [s] does not resolve an impact that one of up to `impact` [s] would, which is tried
        next then: it may be shorter than `smallest`."""
        self._impact = impact
        if dt <= ABOVE * impact:
            return False
        self.dt, self._finest = impact, min(self._finest, FAILED * impact)
        return True

    def increment(self, remaining):
        """Increment [s] to try with `remaining` [s] of the outer step left."""
        dt = min(self.dt, remaining)
        return even(dt, remaining) if self.accuracy else dt

    def shortest(self, dt):
        """Whether half of an increment of `dt` [s] would be too short."""
        return dt / 2 < self._finest

    def judge(self, step, outcome):
        """(whether to accept the trial, its LocalError or None), and set the next increment.

        Raises StepError where a trial is rejected and the next one would be too short.
        """
        self.backtrack = outcome.converged and outcome.backtracked
        if not outcome.converged:
            self._reject(step.dt / 2)
            if self.shortest(step.dt):
                raise StepError(failure_message.not_converged(step, outcome, self._finest, self.smallest))
            return False, None
        easy = outcome.iterations <= EASY and not in_impact(step, outcome.evaluation)
        if not self.accuracy:
            self._accept(min(2 * self.dt, self._length, self._impact) if easy else self.dt)
            return True, None
        error = local_error(step, outcome.evaluation)
        allowed = self.accuracy * step.dt / self._length
        ratio = error.length / allowed
        if ratio > 1:
            if step.dt <= self._finest * (1 + ROUND_OFF):
                raise StepError(failure_message.not_accurate(
                    step, error, allowed, self.accuracy, self._finest, self.smallest))
            self._reject(max(shorter(step.dt, ratio), self._finest))
            return False, error
        dt = following(step.dt, ratio, easy and not self._rejected)
        self._accept(min(max(dt, self._finest), self._length, self._impact))
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
