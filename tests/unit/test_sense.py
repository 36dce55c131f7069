"""Numbers that are allowed and look wrong give a note; demos, benchmarks and random scenes give none."""

import re
from dataclasses import replace

import pytest

from hybrid.bench.scenes import block
from hybrid.monitors.limits.place import LIMITS, beside_roller, friction_of_one, heavy_body, odd_places, odd_points
from hybrid.runtime.data import DEMOS, GEOMETRY
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Contact, Joint, Load, Motion, Pull, Stage, Time
from hybrid.scene.check_sense import sense_notes
from hybrid.scene.defaults import resolve
from hybrid.scene.file import load_scene, validate
from hybrid.setup.build import build
from hybrid.study.random.registry import FAMILIES
from hybrid.study.scenes import box, soil_scene

SHARED = ["gravity=[0, 0, -9.81]"]


def notes(name, *overrides):
    return list(sense_notes(resolve(load_scene(DEMOS / f"{name}.toml", overrides))[0]))


CLAY = "soil.material={ law = 'von-mises', young = 5e6, poisson = 0.49, density = 1800.0, strength = 10e3 }"
SLOPE = "slope"


@pytest.mark.parametrize("name, overrides, words", [
    ("anchor", ["soil.material.relative_density=0.38"], "relative_density = 0.38 % looks wrong: per cent expected"),
    (SLOPE, ["soil.material.young=20e3"], "soil.material.young = 20000 Pa looks wrong: Pa expected; is this"),
    (SLOPE, ["soil.material.cohesion=1.0"], "soil.material.cohesion = 1 Pa looks wrong: Pa expected"),
    (SLOPE, ["soil.material.density=1.7"], "soil.material.density = 1.7 kg/m³ looks wrong: kg/m³ expected"),
    (SLOPE, ["soil.material.density=1.7e6"], "a soil has 1000 to 2500 kg/m³"),
    (SLOPE, ["soil.material.friction_angle=0.57", "soil.material.dilation_angle=0.57"], "friction_angle = 0.57 deg"),
    (SLOPE, ["soil.material.friction_angle=85"], "friction_angle = 85 deg looks wrong: soils have 20 to 50 degrees"),
    (SLOPE, ["soil.material.poisson=-0.5"], "poisson = -0.5 looks wrong: soils have 0.1 to 0.5"),
    (SLOPE, ["gravity=[0, 0, -9810]"], "gravity = [0, 0, -9810] m/s² looks wrong: 9.81 m/s² expected"),
    (SLOPE, ["gravity=[0, 0, 9.81]"], "it acts upwards"),
    ("rolling_sphere", ["time.step=100"], "time.step = 100 s looks wrong: what falls goes 4.9e+04 m in one step, and"),
    ("rolling_sphere", ["stage.0.step=20"], "stage.0.step = 20 s looks wrong"),
    (SLOPE, [CLAY, *SHARED, "soil.material.strength=10"], "strength = 10 Pa looks wrong"),
    (SLOPE, [CLAY, *SHARED, "soil.material.strength_gradient=1.5"],
     "strength_gradient = 1.5 Pa/m looks wrong: Pa/m expected; is this a number of kPa/m"),
    (SLOPE, ["gravity=[0, 0, 0]", "time.inertia=false", "soil.material.cohesion=0"],
     "sand without pressure has no strength and no stiffness"),
    (SLOPE, [CLAY, *SHARED, "soil.material.young=5e3"], "the weight of the soil, 3.53e+04 Pa at its foot, is over 2"),
    (SLOPE, [CLAY, *SHARED, "soil.material.young=5e4"], "over strength = 10000 Pa is 5, which looks wrong"),
    (SLOPE, ["grid.x.end=20000", "grid.x.size=500"], "grid.x, 20000 m long, looks wrong: SI units expected"),
    (SLOPE, ["grid.x.size=0.01"], "grid.z.size = 0.25 m beside grid.x.size = 0.01 m looks wrong: cells 25 times"),
    ("anchor", ["body.0.density=7.85"], "body.0.density = 7.85 kg/m³ looks wrong"),
    ("anchor", ["body.0.density=7850e3"], "the heaviest metals"),
    ("anchor", ["body.0.friction=24"], "body.0.friction = 24 looks wrong: a coefficient expected"),
    ("anchor", ["body.0.tangential=1e4"], "body.0.tangential = 10000 looks wrong"),
    ("anchor", ["body.0.rotation=[0, 1, 0, 1.57]"], "is 1.57 in radians, 90 degrees?"),
    ("anchor", ["body.0.pull.velocity=[500, 0, 0]"], "body.0.pull.velocity = [500, 0, 0] m/s looks wrong"),
    ("anchor", ["body.0.pull.direction=[-1, 0, 0]"], "it points away from where the velocity"),
    ("embedded", ["body.0.pull.diameter=76"], "body.0.pull.diameter = 76 m looks wrong: SI units expected"),
    ("first", ["body.0.velocity=[0, 0, 0]"], "body.0.driven = [z] with velocity = [0, 0, 0] and spin = [0, 0, 0] looks"),
])
def test_a_number_that_looks_wrong_gives_a_note(name, overrides, words):
    found = notes(name, *overrides)
    assert any(words in note for note in found), found


def test_a_line_that_carries_compression_may_lead_against_its_motion():
    assert notes("anchor", "body.0.pull.direction=[-1, 0, 0]", "body.0.pull.tension_only=false") == notes("anchor")


CUBE = (f"body=[{{ geometry = '{GEOMETRY / 'box.geo'}', density = 2000.0, position = [0.0, 0.5, 0.0], rest_on = 2.0, "
        "adhesion = 1.0, tension = %s }]")


@pytest.mark.parametrize("tension, noted", [("20", "20"), ("5.0", "5"), ("20e3", ""), ("200.0", ""), ("'full'", "")])
def test_a_tension_far_below_the_strength_of_the_clay(tension, noted):
    found = notes(SLOPE, CLAY, *SHARED, CUBE % tension)
    text = f"body.0.tension = {noted} Pa beside strength = 10000 Pa looks wrong: Pa expected; is this a number of kPa?"
    assert [note for note in found if "body.0.tension" in note] == [text] * bool(noted)


@pytest.mark.parametrize("overrides", [
    ["gravity=[0, 0, 0]", "time.inertia=true", "soil.material.cohesion=0"],
    ["time.inertia=false", "soil.material.cohesion=0"],
    [CLAY, *SHARED, "soil.material.strength_gradient=1500"],
    ["gravity=[0, 0, 0]", "time.inertia=false", "soil.material.cohesion=300"]])
def test_sand_with_weight_cohesion_or_inertia_and_usual_gradients_look_right(overrides):
    assert not [note for note in notes(SLOPE, *overrides) if "looks wrong" in note
                and ("cohesion" in note or "gradient" in note)]


def test_a_layer_of_sand_without_weight_is_noted_once():
    found = notes(SLOPE, "gravity=[0, 0, 0]", "time.inertia=false", "soil.material.cohesion=0",
                  "soil.layer=[{ name = 'low', top = 1.0, material = { young = 2e7 } }]")
    assert sum("no stiffness" in note for note in found) == 1


def test_a_scene_that_is_refused_says_which_numbers_look_wrong():
    with pytest.raises(SceneError, match=r"more than the law can carry(.|\n)*strength = 10 Pa looks wrong: .* of kPa\?"):
        build(load_scene(DEMOS / "slope.toml", [CLAY, *SHARED, "soil.geostatic=true", "stage.0.gravity=[1, 1]",
                                                    "soil.material.strength=10"]))


def test_layers_are_looked_at_for_their_own_values():
    layer = "soil.layer=[{ name = 'low', top = 1.0, material = { young = 2e4 } }]"
    assert [note[:39] for note in notes(SLOPE, layer)] == ["soil.layer.0.material.young = 20000 Pa "]


# ------------------------------------------------------------------ places


def test_a_line_of_the_second_body_is_named_by_its_number():
    near, far = (replace(box(0.2, 0.2, 0.2, name=name), position=(x, 1.0, 0.0), rest_on=0.0,
                         pull=Pull((reach, 0.0, 0.0), (1.0, 0.0, 0.0), 1e6, 10.0))
                 for name, x, reach in (("near", 0.5, 0.1), ("far", 1.5, 3.0)))
    simulation = build(soil_scene([near, far], x=(0.0, 2.0), y=(0.0, 2.0), gravity=(0.0, 0.0, -9.81), time=Time(0.01)))
    text, = odd_points(simulation.scene, simulation.model)
    assert text.startswith("body.1.pull.point of far lies 2.9 m outside its bounding box")


def places(**body):
    """Notes about a cube of 0.2 m over soil of 2 m x 2 m x 0.4 m."""
    cube = replace(box(0.2, 0.2, 0.2, name="cube"), **{"position": (1.0, 1.0, 0.0), "rest_on": 0.0, **body})
    simulation = build(soil_scene([cube], x=(0.0, 2.0), y=(0.0, 2.0), gravity=(0.0, 0.0, -9.81), time=Time(0.01)))
    return [note for limit in LIMITS for note in limit(simulation.scene, simulation.model)]


@pytest.mark.parametrize("body, words", [
    ({"rest_on": 500.0}, "starts 500 m above the soil"),
    ({"position": (3.0, 1.0, 0.0), "velocity": (-1.0, 0.0, 0.0)}, "lies beside the grid, from x = 2.9 to 3.1 m"),
    ({"position": (1.0, 1.0, -3.0), "rest_on": None, "velocity": (0.0, 0.0, 1.0)}, "lies below the grid, up to z = -2.9 m"),
    ({"position": (2.05, 1.0, 0.0)}, "is half outside the grid: its middle is at x = 2.05 m"),
    ({"position": (1.95, 1.0, 0.0)}, "reaches 0.05 m past the end of the grid at x = 2 m, 25% of its length"),
    ({"parameters": {"length": 0.02, "width": 0.02, "height": 0.02, "size": 1.0}}, ""),
    ({"scale": 0.001}, "is 0.0002 m long, less than 0.5 of a cell, with body.scale = 0.001: STEP files are read in metres"),
    ({"position": (1.95, 1.0, 0.0), "rest_on": 0.3}, ""),      # higher than a cell above the soil
    ({"position": (1.9005, 1.0, 0.0)}, "ends on the face x_max of the grid and may leave it"),
    ({"position": (1.0, 0.1, 0.0)}, "lay the whole one across y = 0 m, with its middle there, or hold y, rx and rz"),
    ({"position": (1.0, 0.1, 0.0), "held": ("y", "rx", "rz")}, ""),
    ({"position": (1.9, 1.0, 0.0), "driven": ("x",), "held": ("y", "z", "rx", "ry", "rz"), "velocity": (-0.1, 0.0, 0.0)},
     ""),
    ({"position": (1.0, 0.05, 0.0), "parameters": {"length": 2.2, "width": 0.2, "height": 0.2, "size": 3.0}},
     "reaches 0.05 m past the start of the grid at y = 0 m"),
    ({"parameters": {"length": 2.2, "width": 0.2, "height": 0.2, "size": 3.0}}, ""),     # a platen
    ({"geometry": GEOMETRY / "box.geo", "parameters": {"length": 200.0, "width": 0.2, "height": 0.2, "size": 200.0}},
     "is 200 m long along x, 100 times the grid"),
    ({"pull": Pull((3.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1e6, 10.0)}, "lies 2.9 m outside its bounding box"),
    ({"penalty": 1e6}, "penalty = 1e+06 /m of cube looks wrong"),
    ({}, ""),
    ({"position": (2.0, 1.0, 0.0)}, ""),
    ({"pull": Pull((0.1, 0.0, 0.0), (1.0, 0.0, 0.0), 1e6, 10.0)}, ""),
])
def test_a_place_that_looks_wrong_gives_a_note(body, words):
    found = places(**body)
    assert len(found) == bool(words) and all(words in note for note in found), found


@pytest.mark.parametrize("stages, found", [
    ((Stage("one", 1, held=("x",)),), 0), ((Stage("one", 1, held=("x",)), Stage("two", 1)), 1),
    ((Stage("one", 1, motions=(Motion(held=("x", "ry")),)),), 0)])
def test_a_body_beside_a_roller_may_leave_it_only_where_a_stage_lets_it(stages, found):
    cube = replace(box(0.2, 0.2, 0.2, name="cube"), position=(1.9, 1.0, 0.0), rest_on=0.0)
    described = soil_scene([cube], x=(0.0, 2.0), y=(0.0, 2.0), gravity=(0.0, 0.0, -9.81), time=Time(0.01))
    simulation = build(replace(described, stages=stages))
    assert len(list(beside_roller(simulation.scene, simulation.model))) == found


@pytest.mark.parametrize("body, words", [
    ({"position": (3.0, 1.0, 0.0)}, "lies beside the grid, from x = 2.9 to 3.1 m, where the grid goes from 0 to 2 m"),
    ({"position": (3.0, 1.0, 0.0), "velocity": (0.0, 1.0, 0.0)}, "lies beside the grid"),
    ({"position": (3.0, 1.0, 0.0), "driven": ("z",), "velocity": (0.0, 0.0, -0.1)}, "lies beside the grid"),
    ({"position": (1.0, 1.0, -3.0), "rest_on": None}, r"lies below the grid, up to z = -2.9 m \(z points up\)")])
def test_a_body_outside_the_grid_that_nothing_moves_there_is_refused(body, words):
    with pytest.raises(SceneError, match=words):
        places(**body)


def test_a_body_that_touches_the_end_of_the_grid_is_not_refused():
    assert places(position=(2.1, 1.0, 0.0), rest_on=-0.1, held=("x", "y", "z", "rx", "ry", "rz"))


@pytest.mark.parametrize("body, rest", [
    ({"velocity": (-1.0, 0.0, 0.0)}, {}), ({"pull": Pull((0.1, 0.0, 0.0), (-1.0, 0.0, 0.0), 1e6, 10.0)}, {}),
    ({}, {"gravity": (-1.0, 0.0, -9.7)}), ({}, {"gravity": (0.0, 0.0, 0.0)}),
    ({}, {"stages": (Stage("go", 1, loads=(Load(force=(-1.0, 0.0, 0.0)),)),)}),
    ({}, {"stages": (Stage("go", 1, motions=(Motion(component="x", velocity=-1.0),)),)})],
    ids=["velocity", "line", "weight along x", "no weight", "load", "motion"])
def test_a_body_beside_the_grid_that_something_may_bring_there_is_not_refused(body, rest):
    cube = replace(box(0.2, 0.2, 0.2, name="cube"), **{"position": (3.0, 1.0, 0.0), "rest_on": 0.0, **body})
    scene = soil_scene([cube], x=(0.0, 2.0), y=(0.0, 2.0), gravity=(0.0, 0.0, -9.81), time=Time(0.01))
    assert build(replace(scene, **rest))


def test_a_pendulum_swings_into_the_grid():
    ram = box(0.2, 0.2, 0.2, name="ram", position=(3.0, 1.0, 1.0))
    pin = Joint("pin", "hinge", ("ram",), (-2.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    scene = soil_scene([ram], x=(0.0, 2.0), y=(0.0, 2.0), gravity=(0.0, 0.0, -9.81), time=Time(0.01))
    assert build(replace(scene, joints=(pin,)))


@pytest.mark.parametrize("x, travel, joined, told", [
    (1.4, 0.0, False, ""), (2.6, 0.0, False, r"reaches from x = 2.5 to 2.7 m at the start, .* at least \[1, 2\]"),
    (1.4, 4.0, False, r"reaches from x = 1.3 to 1.5 m at the end, .* at least \[3.2, 1\]"), (2.6, 0.0, True, "")])
def test_a_second_body_outside_the_window_of_a_grid_that_moves_with_the_first(x, travel, joined, told):
    cubes = [box(0.2, 0.2, 0.2, name="first", position=(0.6, 0.3, 0.0), rest_on=0.0, driven=("x",), held=("rx", "ry", "rz"),
                 velocity=(travel, 0.0, 0.0)),
             box(0.2, 0.2, 0.2, name="second", position=(x, 0.3, 0.0), rest_on=0.0)]
    scene = soil_scene(cubes, x=(0.0, 6.4), y=(0.0, 0.6), gravity=(0.0, 0.0, -9.81), time=Time(0.1),
                       geostatic=True)
    grid = replace(scene.grid, x=Axis(0.0, 6.4, 0.2, doublings=1, window=(1.0, 1.0)))
    joints = (Joint("bar", "weld", ("first", "second"), (0.0, 0.0, 0.0)),) if joined else ()
    simulation = build(replace(scene, grid=grid, joints=joints, stages=(Stage("go", 10),)))
    found = [text for limit in LIMITS for text in limit(simulation.scene, simulation.model)]
    assert len(found) == bool(told) and all(re.search(told, text) for text in found), found


@pytest.mark.parametrize("stage, noted", [
    ({"loads": (Load(force=(0.0, 0.0, -1.0)),)}, True), ({"loads": (Load(body="other", moment=(0.0, 1.0, 0.0)),)}, False),
    ({"motions": (Motion(component="z", velocity=-0.1),)}, True), ({}, False)])
def test_a_body_that_only_a_stage_brings_to_the_soil_has_its_place_looked_at(stage, noted):
    """Weightless, beside the grid."""
    cubes = [replace(box(0.2, 0.2, 0.2, name=name), position=place, rest_on=0.0)
             for name, place in (("cube", (3.0, 1.0, 0.0)), ("other", (1.0, 1.0, 0.0)))]
    stages = (Stage("go", 1, **{key: tuple(replace(each, body=each.body or "cube") for each in given)
                                for key, given in stage.items()}),)
    simulation = build(replace(soil_scene(cubes, x=(0.0, 2.0), y=(0.0, 2.0)), stages=stages))
    found = [note for limit in LIMITS for note in limit(simulation.scene, simulation.model)]
    assert len(found) == noted and all("cube lies beside the grid" in note for note in found), found


@pytest.mark.parametrize("x, noted", [(1.0, 0), (1.5, 1)])
def test_a_body_may_stand_on_another_one_high_above_the_soil(x, noted):
    tower = replace(box(0.2, 0.2, 0.2, name="tower"), position=(1.0, 1.0, 0.0), rest_on=0.0,
                    parameters={"length": 0.4, "width": 0.4, "height": 8.0, "size": 5.0})
    cube = replace(box(0.2, 0.2, 0.2, name="cube"), position=(x, 1.0, 0.0), rest_on=8.0)
    simulation = build(soil_scene([tower, cube], x=(0.0, 2.0), y=(0.0, 2.0), gravity=(0.0, 0.0, -9.81), time=Time(0.01)))
    found = [note for note in odd_places(simulation.scene, simulation.model) if "millimetres" in note]
    assert len(found) == noted


def test_a_body_on_a_joint_may_hang_high_above_the_soil():
    cube = replace(box(0.2, 0.2, 0.2, name="cube"), position=(1.0, 1.0, 0.0), rest_on=500.0)
    described = soil_scene([cube], x=(0.0, 2.0), y=(0.0, 2.0), gravity=(0.0, 0.0, -9.81), time=Time(0.01))
    simulation = build(replace(described, joints=(Joint("pivot", "ball", ("cube",), (0.0, 0.0, 0.5)),)))
    assert not list(odd_places(simulation.scene, simulation.model))


def points(joint=None, **stage):
    """Notes about the points of a cube of 0.2 m, from 2 m x 2 m of soil."""
    cube = replace(box(0.2, 0.2, 0.2, name="cube"), position=(1.0, 1.0, 0.0), rest_on=0.0)
    given = soil_scene([cube], x=(0.0, 2.0), y=(0.0, 2.0), time=Time(0.01))
    simulation = build(replace(given, stages=(Stage("go", 1, **stage),), joints=(joint,) if joint else ()))
    return list(odd_points(simulation.scene, simulation.model))


def hinge(*point):
    return Joint("pin", "hinge", ("cube",), point, axis=(0.0, 1.0, 0.0))


@pytest.mark.parametrize("given, words", [
    ({"joint": hinge(2.0, 2.0, 0.2)}, "joint.0.point of cube lies 2.69 m outside its bounding box, 13 times its size, "
                                      "limit 10"),
    ({"joint": hinge(1.0, 1.0, 0.2)}, ""),      # the arm of a pendulum
    ({"joint": Joint("rod", "rod", ("cube",), (0.0, 0.0, 0.0), end=(1.0, 1.0, 5.0))}, ""),     # the end of a rod is in space
    ({"joint": Joint("rod", "rod", ("cube",), (0.0, 0.0, 3.0), end=(1.0, 1.0, 5.0))}, "joint.0.point of cube"),
    ({"joint": hinge(0.0, 0.0, 0.45)}, ""),
    ({"loads": (Load(force=(0.0, 0.0, -1.0)), Load(force=(0.0, 0.0, -1.0), point=(0.0, 0.0, 25.0)))},
     "stage.0.load.1.point of cube lies 24.9 m"),
    ({"loads": (Load(force=(0.0, 0.0, -1.0), point=(0.15, 0.0, 0.0)),)}, ""),
    ({"motions": (Motion(free=("x",)), Motion(component="z", velocity=-0.1, point=(3.0, 0.0, 0.0)))},
     "stage.0.motion.1.point of cube lies 2.9 m"),
])
def test_a_point_far_from_its_body_gives_a_note(given, words):
    found = points(**given)
    assert len(found) == bool(words) and all(words in note for note in found), found


@pytest.mark.parametrize("young, told", [(2e4, 1), (2e5, 0)])
def test_elastic_soil_that_a_body_would_press_flat_looks_wrong(young, told):
    """Half a metre of 1 000 kg/m³, 4.9 kPa."""
    scene = soil_scene([box(0.4, 0.4, 0.5, position=(0.4, 0.4, 0.0), rest_on=0.0)], young=young, gravity=(0.0, 0.0, -9.81))
    simulation = build(scene)
    found = list(heavy_body(simulation.scene, simulation.model))
    assert len(found) == told and all("4.9e+03 Pa by its weight" in note for note in found)


@pytest.mark.parametrize("friction, gap, contacts, told", [
    ((0.3, None), 0.0, (), "upper has no friction"), ((None, 0.3), 0.05, (), "lower has no friction"),
    ((0.3, 0.0), 0.0, (), ""), ((0.3, 0.3), 0.0, (), ""), ((None, None), 0.0, (), ""), ((0.3, None), 0.5, (), ""),
    ((0.3, None), 0.0, (Contact(("lower", "upper"), friction=0.3),), "")])
def test_friction_that_one_of_two_bodies_lacks_is_told(friction, gap, contacts, told):
    bodies = [box(0.4, 0.4, 0.2, name=name, position=(0.4, 0.4, 0.0), rest_on=at, friction=mu)
              for name, at, mu in zip(("lower", "upper"), (0.0, 0.2 + gap), friction)]
    simulation = build(replace(soil_scene(bodies, z=(-0.4, 1.0), gravity=(0.0, 0.0, -9.81)), contacts=contacts))
    found = list(friction_of_one(simulation.scene, simulation.model))
    assert len(found) == bool(told) and all(told in note for note in found)


# ------------------------------------------------------------------ scenes that are right


def check(scene, built=True):
    scene = validate(scene)
    assert list(sense_notes(resolve(scene)[0])) == []
    if built:
        simulation = build(scene)
        assert [note for limit in LIMITS for note in limit(simulation.scene, simulation.model)] == []


@pytest.mark.parametrize("name", ["anchor", "first", "slope", "rolling_sphere",
                                  *(pytest.param(n, marks=pytest.mark.slow) for n in ("drag", "rolling_slab"))])
def test_the_demos_give_no_note(name):
    check(load_scene(DEMOS / f"{name}.toml"))


def test_the_scenes_of_the_benchmarks_give_no_note():
    check(block(cells=(4, 4, 4), body=(0.05, 50.0)))


@pytest.mark.parametrize("name", FAMILIES)
def test_the_random_scenes_give_no_note(name):
    for seed in range(FAMILIES[name].seeds):
        for scene in FAMILIES[name].scenes(**FAMILIES[name].values(name, seed)):
            check(scene, built=False)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_bodies_of_the_random_scenes_are_where_they_should_be(name):
    for seed in range(FAMILIES[name].seeds):
        check(FAMILIES[name].scenes(**FAMILIES[name].values(name, seed))[0])
