"""A run that stops keeps what it has and goes on from there to the same end."""

import numpy as np
import pytest

import hybrid
from hybrid import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.build import build
from hybrid.errors import StepError
from hybrid.output.history import read_history


def scene(geometry, steps=6, **solver):
    axis = Axis(start=0.0, end=0.8, size=0.2)
    return Scene(
        name="pressed", grid=Grid(axis, axis, Axis(start=-0.6, end=0.2, size=0.2), Faces(z_min="fixed")),
        soil=Soil(Material(law="hencky", young=1e6, poisson=0.3, density=1800.0), top=0.0),
        bodies=(Body(geometry=geometry / "sphere.geo", density=3000.0, parameters={"radius": 0.25, "size": 0.12},
                     position=(0.41, 0.39, 0.0), rest_on=0.0, friction=0.3),),
        time=Time(step=0.01), stages=(Stage("press", steps),), solver=Solver(tolerance=1e-9, **solver),
        output=Output(every=0, checkpoint=2))


def test_resumed_run_ends_where_the_whole_run_ends(geometry, tmp_path):
    whole = build(scene(geometry))
    list(whole.steps())
    hybrid.run(scene(geometry, steps=3), out=tmp_path, quiet=True)
    resumed = hybrid.run(scene(geometry, steps=6), out=tmp_path, resume=True, quiet=True)
    assert resumed.state.step == 6 and resumed.state.time == pytest.approx(0.06)
    assert np.allclose(resumed.state.bodies[0].position, whole.state.bodies[0].position, rtol=0, atol=1e-9)
    assert np.allclose(resumed.state.points.position, whole.state.points.position, rtol=0, atol=1e-9)
    history = read_history(tmp_path)
    assert history["step"].tolist() == [1, 2, 3, 4, 5, 6]


def test_failed_run_keeps_its_steps_and_says_how_to_go_on(geometry, tmp_path):
    hybrid.run(scene(geometry, steps=3), out=tmp_path, quiet=True)
    with pytest.raises(StepError, match="time.step") as failure:
        hybrid.run(scene(geometry, steps=6, iterations=1), out=tmp_path, resume=True, quiet=True)
    assert "All accepted steps are kept" in str(failure.value)
    assert read_history(tmp_path)["step"].tolist()[:3] == [1, 2, 3]
    assert (tmp_path / "checkpoint.npz").exists() and '"failed"' in (tmp_path / "summary.json").read_text()


def test_direct_and_krylov_agree(geometry):
    ends = []
    for linear in ("krylov", "direct"):
        simulation = build(scene(geometry, linear=linear))
        list(simulation.steps())
        ends.append(simulation.state.bodies[0].position)
    assert np.allclose(*ends, rtol=0, atol=1e-9)
