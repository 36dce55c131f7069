"""What a step of a scene will cost: the parts of one, timed on its first state, times how often a step needs them.

    step = begin + (n + 1) evaluations + m tangents + n solutions + end        n Newton iterations, m with a new tangent

| part       | what it is                                                                                |
|------------|-------------------------------------------------------------------------------------------|
| begin      | basis, projection, numbering, search of contact                                           |
| evaluation | strains, law, internal forces, contact: the residual                                      |
| tangent    | assembly and factor                                                                       |
| solution   | of the linear system, for a right-hand side without any order: the first state's may be 0 |
| end        | new points and bodies, energies                                                           |

The first state is disturbed a little. Points are drawn together by a thousandth: on the lattice that they start from, a
domain lies in one cell and its point couples 8 nodes, but once it moves up to 27. Bodies are put a twentieth of a cell
lower, where what rests on the soil touches it. Every part is done once before it is timed, so that compiling and first
allocations do not count. n and m are what scenes of the kind have been seen to take, `ITERATIONS`; rejected increments,
contact that comes later and the writing of files are left out. Memory is what the process held at most until then, this
step's factor included.
"""

import resource
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from hybrid import timing
from hybrid.stepping.energy import energies
from hybrid.system.cache import Systems
from hybrid.system.equations import Step

ITERATIONS = {"held": (2, 2), "elastic": (3, 1), "plastic": (6, 4)}    # (n, m) by soil
PARTS = ("begin", "evaluation", "tangent", "solution", "end")
DRAWN = 1e-3    # of the soil's size
LOWERED = 0.05  # of the smallest cell
ENOUGH = 1.0    # [s] of timing; a part that is quick is timed again


@dataclass(frozen=True)
class Probe:
    """seconds: of each of PARTS; krylov: iterations of the solution; kind: of ITERATIONS; peak: [bytes] of memory."""

    seconds: dict[str, float]
    krylov: int
    kind: str
    steps: int
    peak: int

    @property
    def iteration(self):
        """One Newton iteration with a new tangent [s]."""
        return sum(self.seconds[part] for part in ("evaluation", "tangent", "solution"))

    @property
    def step(self):
        """One outer step of one increment [s]."""
        n, m = ITERATIONS[self.kind]
        often = {"begin": 1, "evaluation": n + 1, "tangent": m, "solution": n, "end": 1}
        return sum(count * self.seconds[part] for part, count in often.items())

    def sheet(self):
        """Section {title: {label: value}} for `hybrid check`."""
        n, m = ITERATIONS[self.kind]
        rows = {f"{part} [ms]": 1e3 * self.seconds[part] for part in PARTS}
        return {"predicted": {
            **rows,
            "Newton iteration [ms]": 1e3 * self.iteration,
            "step [s]": self.step,
            "all steps": f"{_duration(self.steps * self.step)} for {self.steps}",
            "peak memory [MiB]": round(self.peak / 2**20),
            "assumed": [f"{n} Newton iterations a step, {m:g} with a new tangent, as {_soils(self.kind)} takes",
                        "one increment a step, contact with what is touched at the start, files apart"],
        }}


def _soils(kind):
    return f"{kind} soil" if kind != "held" else "a body on held soil"


def _duration(seconds):
    """Readable time: seconds, minutes or hours."""
    for unit, length in (("h", 3600.0), ("min", 60.0)):
        if seconds >= length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.3g} s"


def probe(simulation):
    """Probe of a Simulation; its state stays as it is.

    Raises StepError when its linear system cannot be solved.
    """
    stage = simulation.scene.stages[0]
    model, length = simulation.stage_model(stage, 0.0), stage.step or simulation.scene.time.step
    state, systems = _disturbed(model.begin(simulation.state), model.soil.grid.smallest_cell), Systems(model)
    parts, random = _Timed(), np.random.default_rng(1)
    while parts.again():
        step = parts.time("begin", lambda: Step(model, state, length, False, systems))
        guess = step.start() if step.evaluate(step.start()) else step.still()
        evaluation = parts.time("evaluation", lambda: step.evaluate(guess))
        parts.time("tangent", lambda: step.assemble(evaluation))
        right = random.normal(size=len(evaluation.soil)), random.normal(size=len(evaluation.body))
        krylov = parts.time("solution", lambda: step.system.solve(*right))[2]
        parts.time("end", lambda: _end(step, evaluation))
    step.system.destroy()
    timing.collect()
    return Probe(parts.median(), krylov, _kind(model), simulation.total_steps, peak_memory())


def peak_memory():
    """Most memory [bytes] that this process has held; what a parent held does not count where Linux tells."""
    try:
        with open("/proc/self/status", encoding="ascii") as file:
            return 1024 * next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def _disturbed(state, cell):
    """`state` as it may look after a while; no point leaves the grid, whose smallest cell is `cell` [m]."""
    position = state.points.position
    centre = 0.5 * (position.min(axis=0) + position.max(axis=0))
    return replace(
        state, points=replace(state.points, position=centre + (1 - DRAWN) * (position - centre)),
        bodies=[replace(b, position=b.position - (0.0, 0.0, LOWERED * cell)) for b in state.bodies])


def _end(step, evaluation):
    """What is done with a converged evaluation."""
    step.overturned(evaluation.unknowns)
    step.overreach(evaluation.unknowns)
    step.passed_through(evaluation)
    energies(step.model, step.accept(evaluation), evaluation)


def _kind(model):
    return "held" if model.soil.held else "plastic" if model.soil.law.plastic else "elastic"


class _Timed:
    """Times of each part over rounds, the first of which does not count."""

    def __init__(self):
        self._times, self._rounds, self._spent = {part: [] for part in PARTS}, 0, 0.0

    def again(self):
        """Whether to go round another time: twice at least, more where that is quick."""
        self._rounds += 1
        return self._rounds <= 2 or self._rounds <= 8 and self._spent < ENOUGH

    def time(self, part, work):
        """Result of `work`, whose time counts for `part`."""
        begin = perf_counter()
        result = work()
        if self._rounds > 1:
            self._times[part].append(perf_counter() - begin)
            self._spent += self._times[part][-1]
        return result

    def median(self):
        return {part: float(np.median(times)) for part, times in self._times.items()}
