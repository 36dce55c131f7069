"""`accuracy` of a scene: which settings it changes, which it keeps, and the accuracy and cost that result."""

import dataclasses

import numpy as np
import pytest

from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time, accuracy
from hybrid.setup.build import build

HEIGHT, YOUNG, DENSITY = 10.0, 1e4, 80.0


def column(accuracy=None, solver=Solver(), z=None):
    """A column that its weight compresses by a quarter, in eight quasi-static steps of eight cells."""
    side = Axis(start=0.0, end=1.0, size=1.0, collapsed=True)
    return Scene(
        name="column", grid=Grid(side, side, z or Axis(start=0.0, end=HEIGHT, size=HEIGHT / 8), Faces()),
        soil=Soil(Material(law="hencky", young=YOUNG, poisson=0.0, density=DENSITY), geostatic=False),
        gravity=(0.0, 0.0, -10.0), time=Time(step=1.0, inertia=False), stages=(Stage("load", 8, gravity=(0.0, 1.0)),),
        accuracy=accuracy, solver=solver, output=Output(every=5, pictures=(1, 8), checkpoint=0))


def test_levels_change_cells_steps_and_tolerances():
    scene, texts = accuracy.apply_accuracy(column("reference"))
    level = accuracy.levels()["reference"]
    assert (scene.grid.z.size, scene.time.step, scene.stages[0].steps) == (HEIGHT / 16, 0.5, 16)
    assert scene.output == Output(every=10, pictures=(2, 16), checkpoint=0)
    own = dataclasses.replace(column("draft"), stages=(Stage("load", 8, 0.5, gravity=(0.0, 1.0)),))
    assert accuracy.apply_accuracy(own)[0].stages[0].step == 0.5 * accuracy.levels()["draft"].step == 1.0
    assert scene.solver.tolerance == level.tolerance


@pytest.mark.parametrize("steps", [1, 5, 8, 25])
@pytest.mark.parametrize("step", [None, 0.3])
def test_a_stage_is_as_long_with_other_steps(steps, step):
    scene, _ = accuracy.apply_accuracy(dataclasses.replace(column("draft"), stages=(Stage("load", steps, step),)))
    stage, own = scene.stages[0], step or column("draft").time.step
    assert stage.steps == -(-steps // 2) and stage.steps * (stage.step or scene.time.step) == pytest.approx(steps * own)


def test_a_reference_says_what_it_sets():
    scene, texts = accuracy.apply_accuracy(column("reference"))
    assert scene.accuracy is None and "cells x 0.5" in texts[0]
    assert build(column("reference")).sheet()["modelled"]["accuracy"] == texts


@pytest.mark.parametrize("start, end, top, size, wanted", [
    (-0.25, 0.0, None, 0.25, 0.25),     # held ground of one cell
    (-1.2, 0.8, 0.0, 0.2, 0.4), (-1.4, 0.8, 0.0, 0.2, 0.2), (0.0, 1.0, None, 0.2, 1 / 3)])
def test_cells_of_a_draft_fill_the_axis_and_end_where_the_soil_does(start, end, top, size, wanted):
    axis = Axis(start=start, end=end, size=size)
    scene = column("draft", z=axis)
    scene = dataclasses.replace(scene, soil=dataclasses.replace(scene.soil, top=top))
    changed, texts = accuracy.apply_accuracy(scene)
    assert changed.grid.z.size == pytest.approx(wanted)
    assert (f"fitted to the axes: z {wanted:.4g} m" in texts[0]) == (wanted != 2 * size)


def test_what_a_scene_gives_of_the_solver_stays():
    scene, _ = accuracy.apply_accuracy(column("draft", Solver(tolerance=1e-9)))
    assert scene.solver.tolerance == 1e-9


def test_without_accuracy_nothing_changes():
    assert accuracy.apply_accuracy(column()) == (column(), [])
    assert "accuracy" not in build(column()).sheet()["modelled"]
    ours, standard = column(), accuracy.apply_accuracy(column("standard"))[0]
    assert dataclasses.replace(standard, solver=ours.solver) == ours


def test_cells_given_one_by_one_are_refused():
    axis = Axis(nodes=(0.0, 5.0, 10.0))
    with pytest.raises(SceneError, match="grid.z.nodes: accuracy cannot change cells"):
        build(column("draft", z=axis))


def test_a_level_that_does_not_exist_names_the_nearest():
    with pytest.raises(SceneError, match="accuracy = 'drafts': unknown .did you mean 'draft'"):
        build(column("drafts"))


def test_a_draft_is_cheaper_and_a_reference_nearer():
    """Iterations times unknowns, which no machine changes; errors against the exact stress of the deformed column."""
    work, errors = [], []
    for name in ("draft", "standard", "reference"):
        simulation = build(column(name))
        iterations = sum(record.iterations for record in simulation.steps())
        points, constants = simulation.state.points, simulation.model.soil.constants
        exact = -DENSITY * 10.0 * (HEIGHT - constants.position[:, 2])
        errors.append(np.average(np.abs(points.stress[:, 2, 2] - exact), weights=constants.volume))
        work.append(iterations * len(simulation.evaluation.soil))
    assert work[0] * 1.5 < work[1] and work[1] * 1.5 < work[2]
    assert errors[0] > 2 * errors[1] > 4 * errors[2]
