"""Bodies that cannot roll have softer tangential springs, unless the scene gives them."""

from dataclasses import replace

import pytest

from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Faces, Grid, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import box, collapsed, elastic, scene, sphere

AXIS = Axis(start=-1.0, end=1.0, size=0.5)
LYING = {"rotation": (1.0, 0.0, 0.0, 90.0)}


def ratio(body, held=False, **changes):
    """ε_T/ε_N that a body on a block of elastic soil is given."""
    grid = Grid(AXIS, AXIS, Axis(start=-1.0, end=0.5, size=0.5), Faces(z_min="fixed"))
    described = scene("ratio", grid, elastic(1e6, 0.3), [replace(body, friction=0.5, rest_on=0.0)], 0.01, [Stage("rest", 1)],
                      soil={"top": 0.0, "held": held})
    simulation = build(replace(described, **changes))
    decided = [d for d in simulation.decisions if d.key == "body.0.tangential"]
    assert all(d.value == simulation.model.bodies[0].tangential == simulation.scene.bodies[0].tangential for d in decided)
    return simulation.model.bodies[0].tangential


def cylinder(**body):
    return replace(sphere(0.25, 0.1, 1.0), geometry=sphere(0.25, 0.1, 1.0).geometry.with_name("cylinder.geo"),
                   parameters={"radius": 0.25, "height": 0.5, "size": 0.1}, **body)


def test_a_box_and_a_cylinder_on_its_end_are_soft_and_bodies_that_roll_are_not():
    assert ratio(box(0.5, 0.5, 0.5)) == 0.3
    assert ratio(cylinder()) == 0.3 and ratio(cylinder(**LYING)) == 3.0
    assert ratio(sphere(0.25, 0.1, 1.0)) == 3.0


def test_held_soil_keeps_stiff_springs():
    assert ratio(box(0.5, 0.5, 0.5), held=True) == 3.0


@pytest.mark.parametrize("given", [0.5, 2.0])
def test_a_ratio_that_the_scene_gives_is_kept(given):
    assert ratio(replace(box(0.5, 0.5, 0.5), tangential=given)) == given


def test_the_published_method_keeps_its_own():
    assert ratio(box(0.5, 0.5, 0.5), method="published") == 1.0


def test_a_box_at_rest_on_soil_that_deforms_takes_few_iterations():
    """Let go on a strip of soil of 50 MPa, in plane strain: 59 iterations in 3 steps; with the springs of a body that
    rolls 158, or the first step fails after as many."""
    def iterations(**body):
        grid = Grid(Axis(-1.5, 1.5, 0.1), collapsed(), Axis(-1.0, 0.2, 0.1), Faces(z_min="fixed"))
        fallen = box(0.4, 1.0, 1.0, size=5.0, position=(0.0, 0.5, 0.0), rest_on=0.0, friction=0.5, **body)
        described = scene("rest", grid, elastic(50e6, 0.3), [fallen], 0.01, [Stage("settle", 3)], soil={"top": 0.0},
                          gravity=(0.0, 0.0, -9.81))
        return sum(record.iterations for record in build(described).steps())

    few = iterations()
    assert few <= 75
    try:
        assert 3 * few < iterations(tangential=3.0)
    except StepError:
        pass
