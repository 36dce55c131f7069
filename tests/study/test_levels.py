"""`accuracy` of a scene: what it changes, what it leaves, and that it buys what it says."""

import dataclasses
import json
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time, accuracy
from hybrid.setup.build import build
from hybrid.study import levels as found
from hybrid.study import precision, record
from hybrid.study.record import Record

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
    scene, told = accuracy.apply_accuracy(column("reference"))
    level = accuracy.levels()["reference"]
    assert (scene.grid.z.size, scene.time.step, scene.stages[0].steps) == (HEIGHT / 16, 0.5, 16)
    assert scene.output == Output(every=10, pictures=(2, 16), checkpoint=0)
    own = dataclasses.replace(column("draft"), stages=(Stage("load", 8, 0.5, gravity=(0.0, 1.0)),))
    assert accuracy.apply_accuracy(own)[0].stages[0].step == 0.5 * accuracy.levels()["draft"].step == 1.0
    assert (scene.solver.tolerance, scene.solver.linear_tolerance) == (level.tolerance, level.linear_tolerance)
    assert scene.accuracy is None and "cells x 0.5" in told[0]
    assert build(column("reference")).sheet()["modelled"]["accuracy"] == told


def test_what_a_scene_gives_of_the_solver_stays():
    scene, _ = accuracy.apply_accuracy(column("draft", Solver(tolerance=1e-9, linear_tolerance=1e-8)))
    assert (scene.solver.tolerance, scene.solver.linear_tolerance) == (1e-9, 1e-8)


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


# ---------------------------------------------------------------- from records


def records():
    def swept(problem, curve, errors):
        return [Record(problem, curve, tolerance, {}, {"e": error}, (1.0,), 1, 1) for tolerance, error in errors.items()]

    easy = {"1e-6": 0.1, "1e-4": 0.1001, "1e-3": 0.102, "1e-2": 0.2}
    return [*swept("a", "Newton tolerance", easy), *swept("b", "Newton tolerance", {"1e-8": 1.0, "1e-3": 1.04, "1e-2": 1.2}),
            *swept("a", "Krylov tolerance", {"1e-5": 0.1, "1e-2": 0.1})]


def test_the_loosest_tolerance_that_leaves_every_error_alone():
    assert found.loosest(records(), "Newton tolerance", 0.005) == 1e-8
    assert found.loosest(records(), "Newton tolerance", 0.05) == 1e-3
    assert found.loosest(records(), "Newton tolerance", 0.3) == 1e-3   # of both problems the stricter one
    assert found.loosest(records(), "Krylov tolerance", 0.005) == 1e-2
    with pytest.raises(ValueError, match="no records of the curve 'h'"):
        found.loosest(records(), "h", 0.1)


def test_a_failure_ends_what_is_allowed():
    failed = Record("a", "Newton tolerance", "1e-4", {}, reason="no")
    kept = [r for r in records() if r.key != failed.key] + [failed]
    assert found.loosest(kept, "Newton tolerance", 0.05) == 1e-6
    too_tight = Record("a", "Newton tolerance", "1e-16", {}, reason="no")
    assert found.loosest([*records(), too_tight], "Newton tolerance", 0.05) == 1e-3


def test_the_levels_that_ship_are_those_of_the_records_that_ship():
    assert accuracy.levels() == found.made(record.load(precision.RECORDED)[1])


def test_levels_are_written_as_they_are_read(tmp_path, monkeypatch):
    path = tmp_path / "accuracy.json"
    found.write(records(), path)
    assert set(json.loads(path.read_text())["levels"]) == {"draft", "standard", "reference"}
    monkeypatch.setattr(accuracy, "WRITTEN", path)
    assert accuracy.levels() == found.made(records())
    assert SimpleNamespace(**vars(accuracy.levels()["draft"])).size == 2.0
