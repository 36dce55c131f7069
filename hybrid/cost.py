"""Prediction of the cost of a scene: parts of a step, timed on its first state, times their number in a step.

    step = Σ seconds of a part x its number

| part       | what it is                                                                              | number    |
|------------|-----------------------------------------------------------------------------------------|-----------|
| begin      | basis, projection, numbering, contact search                                            | 1         |
| evaluation | strains, law, internal forces, contact: the residual                                    | 1.5 n + 1 |
| tangent    | assembly and factor                                                                     | m         |
| solution   | of the linear system, for a random right-hand side, as that of the first state may be 0 | n         |
| end        | new points and bodies, energies                                                         | 1         |

n Newton iterations, m of them with a new tangent, are `ITERATIONS`, as measured by kind of soil. A body in plastic soil
takes more of all: updates are shortened, a few nodes are solved for by themselves, and each increment numbers the unknowns
anew. Measured a step, median, by the number of cells along the body:

| scene                           | cells | n   | evaluations / n | tangents / n | time, predicted / taken |
|---------------------------------|-------|-----|-----------------|--------------|-------------------------|
| anchor, 0.4 m, 16 steps         | 9     | 3.2 | 1.4             | 1.0          | 0.9                     |
| anchor, 0.2 m, 40 steps         | 18    | 3.6 | 1.4             | 1.0          | 1.1                     |
| cone, 12 steps                  | 15    | 2.0 | 2.0             | 1.0          | 1.5                     |
| first, plane strain, 20 steps   | 16    | 5.5 | 1.2             | 1.0          | 0.7                     |
| pipe, plane strain, 8 steps     | 16    | 26  | 2.9             | 1.0          | 0.1                     |

Hence `_in_plastic_soil`: n = 2 cells^(1/4), 0.8 of the Krylov iterations on the first state, 1.05 increments. A moving
grid takes in more points when the body sinks: all is multiplied by the growth of their number. Scenes differ from this
by up to a factor of two; a body that clay begins to carry in its first steps, like this pipe, takes longer in these.

The first state is disturbed a little. Distances of the points from their centre are scaled by 0.999: at its initial
position a domain lies in one cell and its point couples 8 nodes; after a small motion it couples up to 27. Bodies are
lowered by a twentieth of a cell, so that those that rest on the soil are in contact. Every part is done once before it
is timed, so that compiling and first allocations do not count. Writing files is not timed; its memory is small, as
files are written piece by piece. Memory is the peak of the process so far, which includes the factor of this step, plus
the memory of points that enter a moving grid and of drawing pictures.
"""

from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from hybrid.body import rigid
from hybrid.contact.assembly import Tangent
from hybrid.runtime import comm, timing
from hybrid.runtime.memory import peak_memory
from hybrid.soil.model import Refusal
from hybrid.soil.size import PART, PICTURES, growing_memory
from hybrid.step.energy import energies
from hybrid.step.equations import begin
from hybrid.step.rejection import rejection
from hybrid.step.workspace import Workspace

ITERATIONS = {"held": (2, 2), "elastic": (3, 0.5), "plastic": (6, 4)}      # (n, m) by soil
PARTS = ("begin", "evaluation", "tangent", "solution", "end")
DRAWN = 1e-3    # of the soil's size
LOWERED = 0.05  # of the smallest cell
ENOUGH = 1.0    # [s] of timing; below it, another round is timed
FACTOR = 2.0    # by which scenes differ from the prediction


@dataclass(frozen=True)
class Effort:
    """Number of each of PARTS in a step, what that assumes, and whether each increment numbers the unknowns anew."""

    number: dict[str, float]
    assumed: str
    renumbers: bool = False


@dataclass(frozen=True)
class CostEstimate:
    """seconds: of each of PARTS; krylov: iterations of the solution; effort: of a step; steps: of all stages; peak:
    [bytes] of memory; growth: factor on the number of points, as a moving grid takes them in; direct: whether the first
    state needed a direct factor."""

    seconds: dict[str, float]
    krylov: int
    effort: Effort
    steps: int
    peak: int
    growth: float = 1.0
    direct: bool = False

    @property
    def iteration(self):
        """One Newton iteration with a new tangent [s]."""
        return sum(self.seconds[part] for part in ("evaluation", "tangent", "solution"))

    @property
    def step(self):
        """One outer step [s]."""
        return self.growth * sum(self.effort.number[part] * self.seconds[part] for part in PARTS)

    def sheet(self):
        """Section {title: {label: value}} for `hybrid check`."""
        rows = {f"{part} [ms]": f"{1e3 * self.seconds[part]:.3g}" for part in PARTS}
        all_steps = self.steps * self.step
        grown = [f"{self.growth:.3g} times the points, once the body has sunk"] if self.growth > 1 else []
        factor = ["a direct factor for each tangent, as on the first state"] if self.direct else []
        return {"predicted cost": {
            **rows,
            "Newton iteration [ms]": f"{1e3 * self.iteration:.3g}",
            "step [s]": f"{self.step:.3g}",
            "all steps": f"{_duration(all_steps)} for {self.steps}",
            "uncertainty": f"{_duration(all_steps / FACTOR)} to {_duration(all_steps * FACTOR)}, as scenes differ",
            "peak memory [MiB]": round(self.peak / 2**20),
            "assumed": [self.effort.assumed, *grown, *factor, "contact as at the start; writing of files not included"],
        }}


def _duration(seconds):
    """Readable time: seconds, minutes or hours."""
    for unit, length in (("h", 3600.0), ("min", 60.0)):
        if seconds >= length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.3g} s"


def predict(simulation):
    """CostEstimate of a Simulation, whose state stays as it is.

    Raises StepError when the linear system of the first step cannot be solved.
    """
    model = simulation.stage_model(0, 0.0)
    workspace = Workspace(model)
    try:
        return _measured(simulation, model, workspace)
    finally:
        workspace.destroy()


def _measured(simulation, model, workspace):
    """CostEstimate by the parts of a few steps of the `model` of the first stage."""
    length = simulation.scene.step_of(simulation.scene.stages[0])
    state = _disturbed(model.begin_stage(simulation.state), model.soil.grid.smallest_cell)
    effort = _effort(model, state)

    def begun():
        return begin(model, state, length, False, workspace)

    parts, random = _Timed(), np.random.default_rng(1)
    kind = Tangent.CONSISTENT if model.scheme.inertia else Tangent.DEFINITE      # that of most updates
    while parts.again():
        if effort.renumbers:
            workspace.renew(model)
        step = parts.time("begin", begun)
        if effort.renumbers:    # the first tangent of a numbering costs more, the others are most
            step.assemble(step.evaluate(step.at_rest()))
            step = begun()
        refused = isinstance(step.evaluate(step.predictor()), Refusal)
        guess = step.at_rest() if refused else step.predictor()
        evaluation = parts.time("evaluation", lambda: step.evaluate(guess))
        parts.time("tangent", lambda: step.assemble(evaluation, kind))
        right = random.normal(size=len(evaluation.soil)), random.normal(size=len(evaluation.body))
        krylov = parts.time("solution", lambda: step.system.solve(*right))[2]
        parts.time("end", lambda: _end(step, evaluation))
    growth = simulation.most_points / max(1, comm.number(state.points))
    direct = workspace.systems.choice.direct
    part = PART / (1 + PART) * effort.renumbers     # has not been restricted to few nodes here
    sizes = len(model.soil.constants), len(step.pattern.indices), step.pattern.size
    more = (growth - 1 + part) * growing_memory(model.soil, *sizes, model.solver, direct)
    more += PICTURES * bool(simulation.scene.output.pictures)
    timing.collect()
    return CostEstimate(parts.median(), krylov, effort, simulation.total_steps, peak_memory() + round(more), growth,
                        direct)


def _effort(model, state):
    """Effort of a step of `model`, from a `state` like the first one."""
    soil = model.soil
    if not soil.held and soil.law.plastic and model.bodies:
        largest = max(np.ptp(rigid.bounding_box(body, motion), axis=0).max()
                      for body, motion in zip(model.bodies, state.bodies, strict=True))
        return _in_plastic_soil(largest / soil.grid.smallest_cell)
    kind = "held" if soil.held else "plastic" if soil.law.plastic else "elastic"
    n, m = ITERATIONS[kind]
    named = "a body on held soil" if soil.held else f"{kind} soil"
    number = {"begin": 1, "evaluation": 1.5 * n + 1, "tangent": m, "solution": n, "end": 1}
    return Effort(number, f"{n} Newton iterations a step, {m} with a new tangent, as {named} takes")


def _in_plastic_soil(cells):
    """Effort of a step of a body so many `cells` long, by the module's table."""
    n = 2.0 * max(cells, 1.0) ** 0.25
    number = {"begin": 1.05, "evaluation": 1.5 * n, "tangent": n, "solution": 0.8 * n, "end": 1}
    return Effort(number, f"{n:.1f} Newton iterations a step, as a body {cells:.0f} cells long in plastic soil takes, "
                         "with 0.8 times the Krylov iterations of the first state", True)


def _disturbed(state, cell):
    """`state` as it may be after some steps; no point leaves the grid, whose smallest cell is `cell` [m]."""
    position = state.points.position
    centre = np.array([0.5 * (comm.minimum(x) + comm.maximum(x)) for x in position.T])
    return replace(
        state, points=replace(state.points, position=centre + (1 - DRAWN) * (position - centre)),
        bodies=[replace(b, position=b.position - (0.0, 0.0, LOWERED * cell)) for b in state.bodies])


def _end(step, evaluation):
    """Everything that follows a converged evaluation."""
    rejection(step, evaluation)
    energies(step.model, step.accept(evaluation), evaluation)


class _Timed:
    """Times of each part over rounds, the first of which does not count."""

    def __init__(self):
        self._times, self._rounds, self._spent = {part: [] for part in PARTS}, 0, 0.0

    def again(self):
        """Whether another round is due: two at least, more where they are quick."""
        self._rounds += 1
        return self._rounds <= 2 or self._rounds <= 8 and self._spent < ENOUGH

    def time(self, part, work):
        """Result of `work`, whose time counts for `part`."""
        started = perf_counter()
        result = work()
        if self._rounds > 1:
            self._times[part].append(perf_counter() - started)
            self._spent += self._times[part][-1]
        return result

    def median(self):
        return {part: float(np.median(times)) for part, times in self._times.items()}
