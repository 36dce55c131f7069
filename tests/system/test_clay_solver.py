"""Nearly incompressible clay in three dimensions: the default linear solver takes what solves it."""

from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest

from hybrid.linalg import petsc, solver_choice
from hybrid.linalg.solver_choice import DIRECT, ILU0, ILU0_SHIFTED, LEAST, SSOR
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.step import iteration
from hybrid.study.scenes import NO_OUTPUT, box


def pressed(cells=8, steps=3, **solver):
    """Simulation of a quarter of a footing of 2 m, pressed 1 mm a step into a block of clay; no increment is halved."""
    size = 2.0 / cells
    side = Axis(0.0, 2.0, size)
    clay = Material(law="von-mises", young=50e6, poisson=0.49, density=1.0, strength=10e3)
    footing = box(2.0, 2.0, 0.5, size=20.0, rest_on=1.0, held=("x", "y", "rx", "ry", "rz"), driven=("z",),
                  velocity=(0.0, 0.0, -0.001), penalty=20.0 / size)
    return build(Scene(
        name="clay", grid=Grid(side, side, Axis(0.0, 1.0 + size, size), Faces(z_min="fixed")),
        soil=Soil(clay, top=1.0, geostatic=False, fbar=True, ghost=0.0033), bodies=(footing,), gravity=(0.0, 0.0, 0.0),
        time=Time(1.0, inertia=False, smallest=1.0), stages=(Stage("press", steps),),
        solver=Solver(**{"tolerance": 1e-6, **solver}),
        output=NO_OUTPUT))


def circular(cells=8, steps=2, linear="auto"):
    """Simulation of a quarter of a circular footing, a quarter of the block wide, on the same clay."""
    described = pressed(cells, steps, linear=linear).scene
    disc = Body(GEOMETRY / "cylinder.geo", 1000.0, "disc", {"radius": 0.5, "height": 0.4, "size": 0.25}, rest_on=1.0,
                held=("x", "y", "rx", "ry", "rz"), driven=("z",), velocity=(0.0, 0.0, -0.002))
    return build(replace(described, bodies=(disc,)))


@pytest.fixture
def prepared(monkeypatch):
    """The solvers that were set up, in order."""
    solvers, set_up = [], petsc.BlockSystem._set_up

    def counted(system, solver):
        solvers.append(solver)
        return set_up(system, solver)

    monkeypatch.setattr(petsc.BlockSystem, "_set_up", counted)
    monkeypatch.setattr(iteration, "SLOW", np.inf)     # increments restricted to few nodes have direct factors of their own
    return solvers


def test_the_damped_factor_solves_clay_and_is_remembered(prepared):
    """Where sweeps and the incomplete factor fail, without a direct factor."""
    list(pressed(steps=4).steps())
    first = prepared.index(ILU0_SHIFTED)
    assert set(prepared[:first]) == {SSOR, ILU0} and set(prepared[first:]) == {ILU0_SHIFTED} and len(prepared) > first + 5


@pytest.mark.parametrize("scene", [pressed, circular])
def test_the_result_is_that_of_a_direct_factor(prepared, scene):
    records = list(scene().steps())
    assert DIRECT not in prepared and not any(record.rejections for record in records)
    for record, other in zip(records, list(scene(linear="direct").steps()), strict=True):
        assert record.bodies[0].contact_force[2] == pytest.approx(other.bodies[0].contact_force[2], rel=1e-4)


def test_a_run_that_is_continued_takes_the_same_solvers_to_the_last_bit(prepared):
    whole = pressed(steps=4)
    list(whole.steps())
    first = len(prepared)
    stopped, rest = pressed(steps=2), pressed(steps=4)
    list(stopped.steps())
    rest.resume(stopped.state, stopped.increment, stopped.backtrack, stopped.solver_memory)
    list(rest.steps())
    assert prepared[first:] == prepared[:first]
    np.testing.assert_array_equal(rest.state.points.position, whole.state.points.position)


def test_a_direct_factor_is_remembered_where_no_iterations_help(prepared, monkeypatch):
    monkeypatch.setattr(petsc, "RAISED", 1.0)       # the damped factor is then as unstable as the incomplete one
    # the last iteration would do without: a tenth of the residual is enough
    monkeypatch.setattr(iteration, "LEFT", 0.0)
    list(pressed(steps=9).steps())
    pauses = [len(list(group)) for solver, group in groupby(prepared) if solver == DIRECT]
    assert 2 * pauses[0] - 1 <= pauses[1] <= 2 * pauses[0] <= 12


def test_a_factor_without_memory_is_refused(monkeypatch):
    monkeypatch.setattr(solver_choice, "MOST", LEAST)
    monkeypatch.setattr(petsc, "RAISED", 1.0)       # the damped factor is then as unstable as the incomplete one
    monkeypatch.setattr(solver_choice, "available_memory", lambda: 2**20)
    with pytest.raises(StepError, match="a direct factor does not fit: .*larger cells .* a machine with more memory"):
        list(pressed().steps())
