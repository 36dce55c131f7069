"""A target error as `accuracy`: what is taken from the records and how it is scaled; a scene alike keeps to it."""

import dataclasses

import numpy as np
import pytest

from hybrid.bench.timed_steps import newton_iterations, sizes, timed_steps
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Target, Time, accuracy
from hybrid.scene.accuracy import Reference, Settings
from hybrid.scene.file import scene_from_dict, validate
from hybrid.setup.build import build

HEIGHT, YOUNG, DENSITY, GRAVITY = 12.0, 1.1e5, 2000.0, 50 / 3   # weight/E = 3.6; that of the column recorded is 4
BEAM = Reference("depth", (Settings(0.1, "coarse", 2.0), Settings(
    0.02, "fine", 4.5, {"ghost": 0.033, "points_per_axis": 3}, {"line_search": False}, {"penalty": 30.0})))


def column(target, z=None, soil=(), solver=Solver(), bodies=()):
    side = Axis(start=0.0, end=1.0, collapsed=True)
    return Scene(
        name="column", grid=Grid(side, side, z or Axis(start=0.0, end=HEIGHT, size=6.0), Faces()),
        soil=Soil(Material(law="hencky", young=YOUNG, poisson=0.0, density=DENSITY), geostatic=False, **dict(soil)),
        gravity=(0.0, 0.0, -GRAVITY), time=Time(step=1.0, inertia=False), accuracy=target, bodies=bodies,
        stages=(Stage("load", 40, gravity=(0.0, 1.0)),), solver=solver, output=Output(every=0, checkpoint=0))


def with_target(*target, **values):
    """Scene and texts under the settings of BEAM."""
    return accuracy.apply_target(column(Target(*target), **values), Target(*target), {"beam": BEAM})


# ---------------------------------------------------------------- what it does to a scene


def measured(error):
    """(Error of stress, iterations times unknowns) of a column that asks for an `error`."""
    simulation = build(column(Target("column", error, HEIGHT)))
    records, _ = timed_steps(simulation)
    points, constants = simulation.state.points, simulation.model.soil.constants
    exact = -DENSITY * GRAVITY * (HEIGHT - constants.position[:, 2])
    wrong = np.average(np.abs(points.stress[:, 2, 2] - exact), weights=constants.volume)
    return wrong / (DENSITY * GRAVITY * HEIGHT), newton_iterations(records) * sizes(simulation)["unknowns"]


def test_a_column_of_another_height_keeps_to_its_target():
    """Measured errors: 0.98 and 0.05 %, for twice the work. With the cells of the scene, 6 m, the error is 7 %."""
    (rough, cheap), (fine, expensive) = measured(0.01), measured(0.002)
    assert 0.002 < rough <= 0.0105 and fine <= 0.0021
    assert 1.5 * cheap < expensive


def test_cells_and_options_are_set_and_reported():
    """1.5 m across 4.5 cells are 0.33 m; 12 m are 36 of them."""
    scene, texts = with_target("beam", 0.05, 1.5)
    assert scene.accuracy is None and scene.grid.z.size == pytest.approx(1 / 3) and scene.grid.x.collapsed
    assert (scene.soil.ghost, scene.soil.points_per_axis, scene.solver.line_search) == (0.033, 3, False)
    assert scene.stages == column(None).stages and scene.time == column(None).time
    assert "error 0.02 of beam (fine): 4.5 cells in its depth, here 1.5 m" in texts and "h = 0.3333 m" in texts
    assert "soil.ghost = 0.033" in texts and "solver.line_search = false" in texts


def test_it_is_on_the_sheet():
    texts = build(column(Target("column", 0.05, HEIGHT))).sheet()["modelled"]["accuracy"]
    assert "error 0.028 of column" in texts[0] and texts[1] == "h = 3 m"


def test_the_cheapest_that_is_near_enough_is_taken():
    assert with_target("beam", 0.5, 1.0)[0].grid.z.size == 0.5
    assert with_target("beam", 0.02, 1.0)[0].grid.z.size == pytest.approx(12 / 54)


def test_values_that_a_scene_gives_stay():
    scene, texts = with_target("beam", 0.02, 1.0, soil={"ghost": 0.1})
    assert (scene.soil.ghost, scene.soil.points_per_axis) == (0.1, 3) and "soil.ghost = 0.1 kept" in texts


def test_springs_of_contact_scale_with_the_length():
    """p_f L is what counts; a penalty that is given stays."""
    body = Body(GEOMETRY / "box.geo", 1000.0)
    scene, texts = with_target("beam", 0.02, 1.5, bodies=(body, dataclasses.replace(body, name="b", penalty=7.0)))
    assert [b.penalty for b in scene.bodies] == [20.0, 7.0]
    assert "body.0.penalty = 20" in texts and "body.1.penalty = 7 kept" in texts


@pytest.mark.parametrize("axis, soil, size", [
    (Axis(start=0.0, end=11.9, size=6.0), {}, 11.9 / 24),                                  # fills the axis
    (Axis(start=0.0, end=12.0, size=6.0), {"top": 10.5}, 0.5),                             # has a line at the surface
    (Axis(start=0.0, end=12.0, size=6.0), {"top": 10.4}, 0.4),
    (Axis(start=0.0, end=12.0, size=6.0, fine=(2.0, 9.8)), {}, 7.8 / 16),                  # where it is fine
    (Axis(start=0.0, end=12.0, size=0.1, around=(1.0, 1.0)), {"top": 10.0}, 0.5),          # in blocks of 2^3
    (Axis(start=0.0, end=0.3, size=0.1), {}, 0.3)])
def test_the_next_smaller_size_that_fits(axis, soil, size):
    scene, texts = with_target("beam", 0.5, 1.0, z=axis, soil=soil)
    assert scene.grid.z.size == pytest.approx(size)
    assert ("fitted" in texts[1]) == (size != 0.5)


# ---------------------------------------------------------------- what is refused


@pytest.mark.parametrize("target, text", [
    (Target("colum", 0.01, 1.0), "accuracy.like = 'colum': unknown problem .did you mean 'column'..; valid: column, "),
    (Target("cantilever", 1e-3, 1.0), "accuracy.error = 0.001: must be at least 0.004, the smallest recorded for "
                                      "'cantilever', by '3 points an axis, h = 0.5 m'"),
    (Target("column", 0.01, 0.0), "accuracy.length = 0: must be positive"),
    (Target("column", 2.0, 1.0), "accuracy.error = 2: must be above 0 and below 1")])
def test_refused(target, text):
    with pytest.raises(SceneError, match=text):
        build(column(target))


def test_cells_given_one_by_one_are_refused():
    with pytest.raises(SceneError, match="grid.z.nodes: accuracy cannot change cells"):
        build(column(Target("column", 0.01, 1.0), z=Axis(nodes=(0.0, 5.0, 10.0))))


def as_table(accuracy):
    """The column as a scene file has it."""
    axis = {"start": 0.0, "end": 1.0, "size": 1.0}
    return scene_from_dict({
        "name": "c", "grid": dict.fromkeys("xyz", axis), "time": {"step": 1.0}, "accuracy": accuracy,
        "soil": {"material": {"law": "hencky", "young": 1e5, "poisson": 0.0, "density": 1e3}},
        "stage": [{"name": "s", "steps": 1}]})


def test_scene_files_have_it():
    table = {"like": "footing", "error": 0.02, "length": 1}
    assert as_table(table).accuracy == Target("footing", 0.02, 1.0) == validate(as_table(table)).accuracy
    for given, text in (({"like": "footing", "error": 0.02}, r"missing in \[accuracy\]: length"),
                        ({**table, "lengths": 1.0}, "unknown key 'accuracy.lengths' .did you mean 'length'"),
                        ("drafts", "accuracy = 'drafts': unknown .did you mean 'draft'"),
                        (3, "accuracy = 3: expected one of 'draft', 'standard', 'reference' or a table .like, error")):
        with pytest.raises(SceneError, match=text):
            as_table(given)
