"""A grid that goes along with a driven body: when there is one, what it leaves as it was, and what it is good for."""

from dataclasses import replace

import numpy as np
import pytest
from rank_runs import history, hybrid, largest_difference, launched, needs_mpirun, points, scene_file, settings

from hybrid.output import checkpoint
from hybrid.scene import Material, Motion, Stage
from hybrid.scene.file import load_scene
from hybrid.setup.build import build

PRESSED = """
name = "pressed"
time = { step = 1.0, inertia = false }
output = { pictures = [], every = 0, checkpoint = 2 }
solver = { tolerance = 1e-9, linear_tolerance = 1e-8 }
[grid]
x = { start = -1.2, end = 1.2, size = 0.2 }
y = { start = 0.0, end = 1.0, collapsed = true }
z = { start = -1.6, end = 0.6, size = 0.2 }
faces = { z_min = "fixed" }
[soil]
top = 0.0
material = { law = "von-mises", young = 3e6, poisson = 0.49, density = 1600.0, strength = 1e4 }
[[body]]
name = "bar"
geometry = "GEOMETRY/cylinder.geo"
parameters = { radius = 0.2, height = 1.0, size = 0.1 }
rotation = [1.0, 0.0, 0.0, 90.0]
density = 3000.0
position = [0.03, 0.5, 0.0]
rest_on = 0.0
velocity = [0.0, 0.0, -0.07]
driven = ["z"]
held = ["x", "ry"]
[[stage]]
name = "press"
steps = 6
"""

# cells of 0.2 m from 0.2 m below the bar to 0.2 m above it, of 0.4 m beyond; at 0.13 m of way they are laid out anew
AROUND = PRESSED.replace("end = 0.6, size = 0.2", "end = 1.6, size = 0.2, around = [0.2, 0.2], doublings = 1")


@pytest.fixture
def scene(tmp_path):
    return load_scene(scene_file(tmp_path, PRESSED))


def with_body(scene, **values):
    return replace(scene, bodies=(replace(scene.bodies[0], **values),))


def carried_along(scene):
    """Axes along which the grid of a scene goes along, as the sheet has them."""
    return build(scene).sheet()["modelled"].get("grid goes along with bodies", "")


def test_the_grid_goes_along_with_a_body_that_is_driven_over_more_than_a_cell(scene):
    assert carried_along(scene) == "along z, by half a cell at most"
    assert carried_along(replace(scene, stages=(Stage("press", 2),))) == ""


@pytest.mark.parametrize("change", [
    lambda s: replace(s, time=replace(s.time, inertia=True)),
    lambda s: replace(s, method="published"),
    lambda s: replace(s, soil=replace(s.soil, material=Material(law="hencky", young=3e6, poisson=0.3, density=1600.0))),
    lambda s: replace(s, bodies=(*s.bodies, replace(s.bodies[0], name="other", position=(-0.8, 0.5, 0.0),
                                                    velocity=(0.0, 0.0, 0.0)))),
    lambda s: replace(s, grid=replace(s.grid, z=replace(s.grid.z, fine=(-0.2, 0.6)))),
    lambda s: with_body(s, driven=(), held=("x", "ry", "z"), velocity=(0.0, 0.0, 0.0)),
], ids=["inertia", "published", "elastic", "two bodies, one at rest", "through cells that grow", "held"])
def test_it_stays_where_cells_differ_or_bodies_move_apart(scene, change):
    assert carried_along(change(scene)) == ""


def test_motions_of_stages_count(scene):
    still = with_body(scene, driven=(), velocity=(0.0, 0.0, 0.0))
    motion = Motion(body="bar", component="z", displacement=((0.0, 0.0), (6.0, -0.42)))
    assert carried_along(replace(still, stages=(replace(still.stages[0], motions=(motion,)),))) != ""


def test_a_body_lies_in_its_cells_at_the_end_of_each_step_as_at_the_start(scene):
    """A step behind, the edges of a plate that starts on lines of the grid would be between them. Limits in cells go by
    the same cell all the while."""
    simulation = build(scene)
    before = simulation.model.soil.grid

    def place():
        lines, height = simulation.model.soil.grid.lines[2], simulation.state.bodies[0].position[2]
        return (height - lines[np.argmin(np.abs(lines - height))]) / before.smallest_cell

    start, steps = place(), simulation.steps()
    for _ in range(4):
        next(steps)
        assert (place() - start + 0.5) % 1.0 - 0.5 == pytest.approx(0.0, abs=1e-6)
    after = simulation.model.soil.grid
    assert (after.smallest_cell, after.resolution) == (before.smallest_cell, before.resolution)
    assert np.diff(after.lines[2]).min() < 0.99 * before.smallest_cell
    steps.close()


def test_cells_that_follow_a_body_go_along_too(tmp_path):
    """Before the step in which they are laid out anew, in it and after it."""
    simulation = build(load_scene(scene_file(tmp_path, AROUND)))
    assert simulation.sheet()["modelled"]["grid goes along with bodies"] == "along z, by half a cell at most"
    sizes, steps = [], simulation.steps()
    start = simulation.state.bodies[0].position[2]
    for _ in range(4):
        next(steps)
        lines, height = simulation.model.soil.grid.lines[2], simulation.state.bodies[0].position[2]
        sizes.append(len(lines))
        assert np.abs((lines - height + start + 1.6 + 0.1) % 0.2 - 0.1).min() < 1e-6
        near = np.diff(lines)[(lines[1:] > height - 0.2) & (lines[:-1] < height + 0.2)]
        assert near == pytest.approx(0.2) and lines[[0, -1]] == pytest.approx([-1.6, 1.6])
    assert len(set(sizes)) > 1
    steps.close()


def test_soil_that_nothing_touches_stays_where_it_is(scene):
    """Over two cells of way the surface moves by 2e-6 of a cell; under its own weight it would settle by 3 % of one."""
    simulation = build(with_body(scene, rest_on=0.5, velocity=(0.0, 0.0, -0.075)))
    before, lines = simulation.state.points.position.copy(), simulation.model.soil.grid.lines[2].copy()
    records = list(simulation.steps())
    moved = simulation.model.soil.grid.lines[2] - lines
    assert np.abs(moved).max() > 0.02 and not moved[[0, -1]].any()
    assert np.abs(simulation.state.points.position - before).max() < 1e-5
    assert sum(record.iterations for record in records) < 12


@pytest.mark.parametrize("text", [PRESSED, AROUND], ids=["whole grid", "cells that follow the bar"])
def test_a_run_goes_on_to_the_last_bit(tmp_path, text):
    """But for what it remembers of notes: one is about how far the bar will go, which the first part does not know."""
    path = scene_file(tmp_path, text)
    hybrid("run", path, "--out", tmp_path / "whole")
    hybrid("run", path, "--out", tmp_path / "parts", "--set", "stage.0.steps=4")
    hybrid("run", path, "--out", tmp_path / "parts", "--resume")
    with np.load(tmp_path / "whole" / checkpoint.NAME) as whole, np.load(tmp_path / "parts" / checkpoint.NAME) as parts:
        differ = [name for name in whole.files if whole[name].tobytes() != parts[name].tobytes()]
    assert set(differ) <= {"run", "extra/remembered"}


@needs_mpirun
@pytest.mark.parametrize("text", [PRESSED, AROUND], ids=["whole grid", "cells that follow the bar"])
def test_several_processes_give_the_same(tmp_path, text):
    """In steps of 10 iterations: with 30 round-off may decide which of them is halved. Split points have other numbers."""
    path, short = scene_file(tmp_path, text), settings("body.bar.velocity=[0.0, 0.0, -0.03]", "stage.press.steps=8")
    hybrid("run", path, "--out", tmp_path / "one", *short)
    launched("run", path, "--out", tmp_path / "two", "--ranks", 2, *short)
    assert largest_difference(history(tmp_path / "one"), history(tmp_path / "two")) < 1e-5
    one, two = (points(tmp_path / name) for name in ("one", "two"))
    if text is AROUND:
        one, two = ({name: np.sort(values, axis=0) for name, values in each.items()} for each in (one, two))
    assert largest_difference(one, two) < 1e-5
