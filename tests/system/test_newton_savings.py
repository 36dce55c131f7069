"""What Newton's method saves changes the way to a solution, not the solution: sphere pressed into loose sand."""

from types import SimpleNamespace

import pytest

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Solver, Stage
from hybrid.setup.build import build
from hybrid.soil.model import Refusal
from hybrid.step import iteration
from hybrid.study.scenes import scene

EXACT = {"tangent_tolerance": 0.0, "linear_tolerance": 1e-10}
SAVINGS = {
    "kept tangents": {"tangent_tolerance": 1e-2},
    "loose Krylov": {"linear_tolerance": 1e-2},
    "both": {"tangent_tolerance": 1e-2, "linear_tolerance": 1e-2},
}
TOLERANCE = 1e-8
WAY = 0.03  # [m] that the sphere moves in these steps


def pressed(**solver):
    """(state, Newton iterations) after a sphere has sunk into sand for three steps."""
    simulation = pressed_simulation(tolerance=TOLERANCE, **solver)
    records = list(simulation.steps())
    return simulation.state, sum(r.iterations for r in records)


def pressed_simulation(**solver):
    """Simulation of a sphere that sinks into sand for three steps."""
    axis = Axis(start=0.0, end=0.8, size=0.2)
    body = Body(geometry=GEOMETRY / "sphere.geo", density=3000.0, parameters={"radius": 0.25, "size": 0.12},
                position=(0.43, 0.37, 0.255), velocity=(0.4, 0.1, -1.0), friction=0.4)
    sand = {"law": "drucker-prager", "young": 1e6, "poisson": 0.3, "friction_angle": 30.0, "dilation_angle": 5.0,
            "cohesion": 100.0}
    grid = Grid(axis, axis, Axis(start=-0.6, end=0.2, size=0.2), Faces(z_min="fixed"))
    return build(scene("pressed", grid, sand, [body], 0.01, [Stage("one", 3)], soil={"top": 0.0}, solver=solver,
                       gravity=(0.0, 0.0, -9.81)))


@pytest.fixture(scope="module")
def exact():
    return pressed(**EXACT)


@pytest.mark.parametrize("name", SAVINGS)
def test_the_answer_is_the_same_within_the_tolerance(exact, name):
    state, iterations = pressed(**{**EXACT, **SAVINGS[name]})
    assert state.points.position == pytest.approx(exact[0].points.position, abs=1e3 * TOLERANCE * WAY)
    assert state.bodies[0].position == pytest.approx(exact[0].bodies[0].position, abs=1e3 * TOLERANCE * WAY)
    assert state.points.plastic_strain == pytest.approx(exact[0].points.plastic_strain, abs=1e-5)
    assert exact[0].points.plastic_strain.max() > 1e-3   # the sand yields, so tangents change
    assert iterations < 3 * exact[1]


def test_a_linear_system_is_not_solved_farther_than_the_tolerance_needs():
    """Far from the solution to the tolerance of the scene, near it to a tenth of what is left to gain, never worse than
    0.1."""
    solver = Solver(tolerance=1e-4, linear_tolerance=1e-3)
    assert iteration.linear_tolerance(solver, 1e-3, 0.5) == 1e-3
    assert iteration.linear_tolerance(solver, 1e-3, 2e-4) == pytest.approx(0.05)
    assert iteration.linear_tolerance(solver, 1e-3, 1.01e-4) == pytest.approx(0.1, rel=0.02)
    assert iteration.linear_tolerance(solver, 1e-5, 2e-4) == pytest.approx(5e-4)      # stiff contact: in proportion


def test_the_last_linear_system_takes_fewer_iterations(monkeypatch):
    assert krylov_of(monkeypatch, iteration.LEFT) < krylov_of(monkeypatch, 0.0)


def krylov_of(monkeypatch, left):
    monkeypatch.setattr(iteration, "LEFT", left)
    return sum(record.krylov for record in pressed_simulation().steps())


def test_an_update_that_gains_little_is_shortened():
    """Soil that opens and closes: |r| = |1 - 1.95 s| along the update; the whole of it gains 5 %, half of it 97 %."""
    tried = []

    class Step:
        model = None

        def moved(self, unknowns, soil, body, scale):
            return scale

        def evaluate(self, scale, keep=None):
            tried.append(scale)
            return SimpleNamespace(error=abs(1 - 1.95 * scale), unknowns=scale)

    old = SimpleNamespace(error=1.0, unknowns=None)
    found, share = iteration.line_search(Step(), old, None, None, True)
    assert found.unknowns == share == 0.5 and tried == [1.0, 0.5]
    tried.clear()
    found, share = iteration.line_search(Step(), old, None, None, False)
    assert found.unknowns == share == 1.0


@pytest.mark.parametrize("error, best", [(lambda s: 1 - 0.3 * s, 1.0), (lambda s: 1 + s, 1 / 16),
                                         (lambda s: 0.8 if s == 0.5 else 0.9, 0.5)])
def test_the_best_evaluation_is_returned_and_stays_valid(error, best):
    tried = []

    class Step:
        def moved(self, unknowns, soil, body, scale):
            return scale

        def evaluate(self, scale, keep=None):
            for earlier in tried:
                earlier.valid &= earlier is keep
            tried.append(SimpleNamespace(error=error(scale), unknowns=scale, valid=True))
            return tried[-1]

    found, share = iteration.line_search(Step(), SimpleNamespace(error=1.0, unknowns=None), None, None, True)
    assert found.unknowns == share == best and found.valid
    assert len({one.unknowns for one in tried}) == len(tried)   # nothing is evaluated twice


def test_an_update_without_any_evaluation_is_refused_with_the_last_reason():
    class Step:
        def moved(self, unknowns, soil, body, scale):
            return scale

        def evaluate(self, scale, keep=None):
            return Refusal(f"fails at {scale:g}")

    old = SimpleNamespace(error=1.0, unknowns=None)
    assert iteration.line_search(Step(), old, None, None, True)[0] == Refusal("fails at 0.0625")
