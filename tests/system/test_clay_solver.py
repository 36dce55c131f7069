"""Nearly incompressible clay in three dimensions: the default linear solver finishes where the Krylov method stops."""

import pytest

from hybrid.linalg import petsc, solver_choice
from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import NO_OUTPUT, box


def pressed(cells=8, steps=3, **solver):
    """Simulation of a quarter of a footing of 2 m, pressed 1 mm a step into a block of clay; no increment is halved."""
    size = 2.0 / cells
    side = Axis(0.0, 2.0, size)
    clay = Material(law="von-mises", young=50e6, poisson=0.49, density=1.0, strength=10e3)
    footing = box(2.0, 2.0, 0.5, size=20.0, rest_on=1.0, held=("x", "y", "rx", "ry", "rz"), driven=("z",),
                  velocity=(0.0, 0.0, -0.001))
    return build(Scene(
        name="clay", grid=Grid(side, side, Axis(0.0, 1.0 + size, size), Faces(z_min="fixed")),
        soil=Soil(clay, top=1.0, geostatic=False, fbar=True, ghost=0.0033), bodies=(footing,), gravity=(0.0, 0.0, 0.0),
        time=Time(1.0, inertia=False, smallest=1.0), stages=(Stage("press", steps),), solver=Solver(**solver),
        output=NO_OUTPUT))


@pytest.fixture
def prepared(monkeypatch):
    """Numbers of the solvers that were set up, in order."""
    numbers, prepare = [], petsc.BlockSystem._prepare

    def counted(system, number):
        numbers.append(number)
        prepare(system, number)

    monkeypatch.setattr(petsc.BlockSystem, "_prepare", counted)
    return numbers


def test_the_default_finishes_what_the_krylov_method_does_not(prepared):
    with pytest.raises(StepError, match=r'linear solver: no convergence.*Use solver.linear = "auto"'):
        list(pressed(linear="krylov").steps())
    prepared.clear()
    records = list(pressed().steps())
    exact = list(pressed(linear="direct").steps())
    assert [record.rejections for record in records] == [0, 0, 0]
    assert sum(record.krylov for record in records) > 10 * sum(record.krylov for record in exact)
    for record, other in zip(records, exact, strict=True):
        assert record.bodies[0].contact_force[2] == pytest.approx(other.bodies[0].contact_force[2], rel=1e-4)


def test_a_direct_factor_is_remembered_from_step_to_step(prepared, monkeypatch):
    monkeypatch.setattr(petsc, "MAX_ITERATIONS", petsc.SWITCH_AFTER)     # more iterations do not help then
    simulation = pressed()
    records = list(simulation.steps())
    first = prepared.index(3)
    assert prepared[first - 3:first] == [0, 1, 2] and set(prepared[first:]) == {3} and len(prepared) - first > 5
    assert records[-1].krylov == records[-1].iterations


def test_a_factor_without_memory_is_refused(monkeypatch):
    monkeypatch.setattr(petsc, "MAX_ITERATIONS", petsc.SWITCH_AFTER)
    monkeypatch.setattr(solver_choice, "available_memory", lambda: 2**20)
    with pytest.raises(StepError, match="a direct factor does not fit: .*larger cells .* a machine with more memory"):
        list(pressed().steps())
