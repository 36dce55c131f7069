"""A rough square pad on clay that carries its load without flowing is as stiff as on elastic soil, on few cells already."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Joint, Load, Material, Motion, Pull, Scene, Soil, Stage, Time
from hybrid.setup.bearing import base_share
from hybrid.setup.build import build
from hybrid.study.scenes import NO_OUTPUT

WIDTH, LOAD, STRENGTH = 2.0, 5e3, 1e4      # [m]; [N] on a quarter, a twelfth of what it can carry; s_u [Pa]


def pad(cells, law="von-mises", load=LOAD, **table):
    """Quarter of a pad with so many cells in its width, on a block twice as wide and deep as it."""
    size, far = WIDTH / cells, Axis(0.0, 4.0, WIDTH / cells)
    strength = {"strength": STRENGTH} if law == "von-mises" else {}
    soil = Soil(Material(law=law, young=5e6, poisson=0.45, density=1700.0, **strength), top=0.0)
    body = Body(GEOMETRY / "box.geo", 7850.0, name="pad", rest_on=0.0, held=("x", "y", "rx", "ry", "rz"), friction=1.0,
                parameters={"length": WIDTH, "width": WIDTH, "height": 0.5, "size": 5.0}, **table)
    load = Load(force=((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, -load)))
    return build(Scene(name="pad", gravity=(0.0, 0.0, 0.0), soil=soil, bodies=(body,), output=NO_OUTPUT,
                       grid=Grid(far, far, Axis(-4.0, 2 * size, size), Faces(z_min="fixed")),
                       time=Time(1.0, inertia=False), stages=(Stage("press", 1, loads=(load,)),)))


def settlement(*given, **more):
    """[m] under LOAD."""
    simulation = pad(*given, **more)
    start = simulation.state.bodies[0].position[2]
    list(simulation.steps())
    return start - simulation.state.bodies[0].position[2]


def test_four_cells_settle_as_on_elastic_soil_and_as_six_do():
    found, elastic = settlement(4), settlement(4, "hencky")
    assert found == pytest.approx(elastic, rel=0.001) == pytest.approx(settlement(6), rel=0.01)


def test_with_the_springs_of_soil_that_flows_it_settles_too_much():
    assert settlement(4, penalty=20 * 4 / WIDTH) > 1.03 * settlement(4, "hencky")


@pytest.mark.parametrize("geometry, parameters, rotation, expected", [
    ("cylinder.geo", {"radius": 1.0, "height": 0.5, "size": 0.3}, None, 500),
    ("cylinder.geo", {"radius": 0.5, "height": 2.0, "size": 0.3}, (1.0, 0.0, 0.0, 90.0), 20),
    ("cone.geo", {"size": 0.3}, None, 20), ("sphere.geo", {"size": 0.1}, None, 20),
    ("box.geo", {"length": 2.0, "width": 2.0, "height": 0.5, "size": 5.0}, (0.0, 1.0, 0.0, 5.0), 500),
    ("box.geo", {"length": 2.0, "width": 2.0, "height": 2.0, "size": 5.0}, (0.0, 1.0, 0.0, 45.0), 20)])
def test_a_body_needs_a_plane_base(geometry, parameters, rotation, expected):
    more = {} if rotation is None else {"rotation": rotation}
    whole = pad(4, load=50.0).scene
    body = replace(whole.bodies[0], geometry=GEOMETRY / geometry, parameters=parameters, **more)
    assert build(replace(whole, bodies=(body,))).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


def test_a_disc_has_its_own_area_on_the_clay():
    """30 kN, half of what a square carries, is 0.64 of that of a disc."""
    cylinder = {"geometry": GEOMETRY / "cylinder.geo", "parameters": {"radius": 1.0, "height": 0.5, "size": 0.3}}
    for load, expected in ((0.45 * 6 * STRENGTH, 20), (0.35 * 6 * STRENGTH, 500)):
        scene = pad(4, load=load).scene
        scene = replace(scene, bodies=(replace(scene.bodies[0], **cylinder),))
        assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


@pytest.mark.parametrize("load, expected", [
    (Load(force=(0.0, 0.0, -1e4)), 500), (Load(force=(4.9e3, 0.0, -1e4)), 500), (Load(force=(5.1e3, 0.0, -1e4)), 20),
    (Load(force=(0.0, 0.0, -1e4), moment=(0.0, 6.6e3, 0.0)), 500),
    (Load(force=(0.0, 0.0, -1e4), point=(0.8, 0.0, 0.25)), 20),
    (Load(force=(2e3, 0.0, -1e4), point=(0.0, 0.0, 2.4)), 500), (Load(force=(2e3, 0.0, -1e4), point=(0.0, 0.0, 2.7)), 20),
    (Load(force=(0.0, 0.0, -1e4), moment=(0.0, 6.8e3, 0.0)), 20),
    (Load(force=(0.0, 0.0, -1e3), moment=(0.0, 6.9e3, 0.0)), 500),
    (Load(force=(0.0, 0.0, -1e3), moment=(0.0, 7.1e3, 0.0)), 20),
    (Load(force=(4e3, 0.0, -1.9e4)), 500), (Load(force=(4e3, 0.0, -2.1e4)), 20)])
def test_what_may_slide_or_tip_has_softer_springs(load, expected):
    """s_u A = 10 kN on the quarter, 0.7 s_u A B = 14 kN m. Together V + 6 M/B is 30 kN, 27.1 with H = 2 kN, 22.4 with 4."""
    scene = replace(pad(4).scene, stages=(Stage("load", 1, loads=(load,)),))
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


@pytest.mark.parametrize("load, more, expected", [
    (LOAD, {}, 500), (0.49 * 6 * STRENGTH, {}, 500), (0.6 * 6 * STRENGTH, {}, 20),
    (LOAD, {"driven": ("z",), "held": ("x", "y", "rx", "ry", "rz"), "velocity": (0.0, 0.0, -1e-3)}, 20),
    (LOAD, {"velocity": (0.0, 0.0, -0.1)}, 20), (LOAD, {"pull": Pull((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), 1e5, 5.0)}, 20)])
def test_what_may_flow_has_softer_springs(load, more, expected):
    """The quarter has 1 m² on the clay."""
    body = pad(4, load=load).scene.bodies[0]
    scene = replace(pad(4, load=load).scene, bodies=(replace(body, **more),))
    if "driven" in more:
        scene = replace(scene, stages=(Stage("press", 1),))
    elif "velocity" in more:
        scene = replace(scene, time=Time(0.01))
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


@pytest.mark.parametrize("above, joints, x, load, expected", [
    (0.5, (), 0.0, 40e3, 20), (0.5, (), 0.0, 20e3, 500), (0.5, (), 2.8, 40e3, 500), (1.5, (), 0.0, 40e3, 20),
    (0.5, ("weld",), 1.6, 40e3, 20), (0.5, ("weld",), 1.6, 2e3, 500), (0.5, ("ground",), 1.6, 40e3, 500)])
def test_loads_of_bodies_that_it_carries_count_as_its_own(above, joints, x, load, expected):
    """Of a block above the pad, which is 2 m wide, or that a joint connects with it: with V = 5 kN of its own the quarter
    bears 30 kN. A block beside it, or one that is joined to the ground as the pad is, presses it by nothing."""
    scene = pad(4).scene
    side = {"length": 1.0, "width": 1.0, "height": 0.5, "size": 5.0}
    block = replace(scene.bodies[0], name="block", parameters=side, rest_on=above, position=(x, 0.0, 0.0), density=1.0)
    own, onto = scene.stages[0].loads[0], Load(body="block", force=((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, -load)))
    kinds = {"weld": [("pad", "block")], "ground": [("pad",), ("block",)]}
    made = tuple(Joint(f"{kind} {number}", "weld", bodies, (0.0, 0.0, 0.0))
                 for kind in joints for number, bodies in enumerate(kinds[kind]))
    scene = replace(scene, bodies=(*scene.bodies, block), joints=made,
                    stages=(Stage("press", 1, loads=(replace(own, body="pad"), onto)),))
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


@pytest.mark.parametrize("held, pads, density, expected", [
    ((), 1, 4000.0, 20), (("x", "y", "z", "rx", "ry", "rz"), 1, 4000.0, 500), ((), 2, 4000.0, 500), ((), 2, 8000.0, 20)])
def test_several_pads_share_a_deck_and_none_bears_what_is_held(held, pads, density, expected):
    """A quarter of 1 m² that bears 30 kN; a deck over one or two of them, of which one bears 39 kN, two 20 or 39 kN each,
    held by itself or not."""
    scene = pad(4, load=50.0).scene
    one = replace(scene.bodies[0], density=1.0)
    grid = replace(scene.grid, x=Axis(0.0, 8.0, 0.5))
    bodies = [one] + [replace(one, name="other", position=(5.0, 0.0, 0.0))] * (pads - 1)
    length = 2.0 if pads == 1 else 12.0
    deck = replace(one, name="deck", density=density, position=(0.0, 0.0, 0.0), rest_on=0.5, held=held or one.held,
                   parameters={"length": length, "width": 2.0, "height": 2.0 / length, "size": 5.0})
    deck = replace(deck, held=held or ("x", "y", "rx", "ry", "rz"))
    stages = (replace(scene.stages[0], loads=(replace(scene.stages[0].loads[0], body="pad"),)),)
    scene = replace(scene, grid=grid, bodies=(*bodies, deck), gravity=(0.0, 0.0, -9.81), stages=stages)
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


@pytest.mark.parametrize("cohesion, expected", [(10e3, 500), (100.0, 20), (0.0, 20)])
def test_the_cohesion_of_soil_with_friction_bears_a_load(cohesion, expected):
    """5 kN on a quarter; 6 c A is 60 kN and 0.6 kN. What friction alone bears is not known."""
    scene = pad(4, "hencky").scene
    material = Material(law="mohr-coulomb", young=5e6, poisson=0.3, density=1700.0, friction_angle=30.0, dilation_angle=0.0,
                        cohesion=cohesion)
    scene = replace(scene, soil=replace(scene.soil, material=material))
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


def squares(*rows):
    """Surface seen from below of squares; rows: (corner, width, height)."""
    corner = np.array([(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)])
    vertices = np.concatenate([np.column_stack([start + width * corner, np.full(4, z)]) for start, width, z in rows])
    triangles = np.concatenate([4 * i + np.array([(0, 1, 2), (0, 2, 3)]) for i in range(len(rows))])
    return SimpleNamespace(vertices=vertices, triangles=triangles, normals=np.tile([0.0, 0.0, -1.0], (len(triangles), 1)))


def test_a_body_that_nothing_presses_has_soft_springs_whatever_its_base():
    """Without gravity, and without a load of a stage."""
    scene = replace(pad(4).scene, stages=(Stage("rest", 1),))
    assert build(scene).model.bodies[0].penalty == pytest.approx(20 * 4 / WIDTH)


@pytest.mark.parametrize("density, gravity, more, expected", [
    (3900.0, (0.0, 0.0, -9.81), {}, 500), (7800.0, (0.0, 0.0, -9.81), {}, 20), (3900.0, (1.0, 0.0, -9.7), {}, 20),
    (3900.0, (0.0, 0.0, -9.81), {"rest_on": 0.1}, 20), (3900.0, (0.0, 0.0, -9.81), {"rest_on": None}, 20),
    (3900.0, (0.0, 0.0, -9.81), {"held": ("x", "y", "z", "rx", "ry", "rz")}, 20)])
def test_a_body_that_stands_by_its_weight_is_borne_as_by_a_load(density, gravity, more, expected):
    """A load of nothing in a later stage changed its settlement by 6 to 17 %. 0.5 m of 3 900 kg/m³ press with 19 kPa, a
    third of what the clay can carry."""
    if more.get("rest_on", 0.0) is None:
        more = more | {"position": (0.0, 0.0, 0.0)}
    scene = pad(4).scene
    body = replace(scene.bodies[0], density=density, **more)
    scene = replace(scene, bodies=(body,), gravity=gravity, stages=(Stage("rest", 1),),
                    soil=replace(scene.soil, geostatic=False))
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


BESIDE = {"position": (3.2, 3.2, 0.0), "rest_on": 1.0, "held": ("x", "y", "z", "rx", "ry", "rz")}


@pytest.mark.parametrize("place, other, expected", [
    ({"rest_on": None, "position": (0.0, 0.0, 0.25)}, None, 500), ({"rest_on": "ground"}, None, 500),
    ({"rest_on": 0.009}, None, 500), ({}, BESIDE, 500), ({}, BESIDE | {"rest_on": 0.0, "held": ("x", "y")}, 500),
    ({}, BESIDE | {"driven": ("z",), "held": ("x", "y"), "velocity": (0.0, 0.0, -0.1)}, 20),
    ({}, BESIDE | {"rest_on": 0.1, "held": ("x", "y")}, 20), ({}, {"position": (0.0, 0.0, 0.0), "rest_on": 0.7}, 20),
    ({}, {"position": (0.0, 0.0, 0.0), "rest_on": 0.5}, 500),
    ({}, BESIDE | {"driven": ("z",), "held": ("x", "y")}, 500),
    ({}, BESIDE | {"held": ("x", "y"), "pull": Pull((0.0, 0.0, 0.0), (0.0, 0.0, 0.1), 1e5, 1.0)}, 20)])
def test_a_body_that_stands_by_its_weight_is_so_however_it_is_put_there_and_beside_what_stands_still(place, other, expected):
    """A held box far off made it settle by 5 to 43 % more."""
    scene = pad(4).scene
    body = replace(scene.bodies[0], density=3900.0, **place)
    others = () if other is None else (Body(GEOMETRY / "box.geo", 100.0, name="other", parameters={
        "length": 0.5, "width": 0.5, "height": 0.5, "size": 5.0}, **other),)
    scene = replace(scene, bodies=(body, *others), gravity=(0.0, 0.0, -9.81), stages=(Stage("rest", 1),),
                    soil=replace(scene.soil, geostatic=False))
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


@pytest.mark.parametrize("hangs, expected", [(True, 500), (False, 20)])
def test_a_body_that_hangs_above_it_does_not_fall(hangs, expected):
    size = {"length": 0.5, "width": 0.5, "height": 0.5, "size": 5.0}
    hook, load = (Body(GEOMETRY / "box.geo", 100.0, name=name, parameters=size, position=(2.6, 2.6, 0.0), rest_on=at,
                       held=held) for name, at, held in (
                           ("hook", 1.4, ("x", "y", "z", "rx", "ry", "rz")), ("load", 0.5, ())))
    joints = (Joint("ball", "ball", ("hook", "load"), (2.6, 2.6, 1.2)),) if hangs else ()
    scene = pad(4).scene
    scene = replace(scene, bodies=(replace(scene.bodies[0], density=3900.0), hook, load), gravity=(0.0, 0.0, -9.81),
                    joints=joints, stages=(Stage("rest", 1),), soil=replace(scene.soil, geostatic=False))
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


@pytest.mark.parametrize("share, expected", [(1.0, 500), (0.5, 500), (3.0, 20)])
def test_the_largest_gravity_of_all_stages_counts(share, expected):
    scene = pad(4).scene
    scene = replace(scene, bodies=(replace(scene.bodies[0], density=3900.0),), gravity=(0.0, 0.0, -9.81),
                    stages=(Stage("rest", 1), Stage("more", 1, gravity=(1.0, share))),
                    soil=replace(scene.soil, geostatic=False))
    assert build(scene).model.bodies[0].penalty == pytest.approx(expected * 4 / WIDTH)


def test_a_body_that_a_later_stage_lets_fall_does_not_stand_still():
    scene = pad(4).scene
    other = Body(GEOMETRY / "box.geo", 100.0, name="other", parameters={
        "length": 0.5, "width": 0.5, "height": 0.5, "size": 5.0}, **BESIDE)
    fall = Stage("fall", 1, motions=(Motion(body="other", free=("z",)),))
    scene = replace(scene, bodies=(replace(scene.bodies[0], density=3900.0), other), gravity=(0.0, 0.0, -9.81),
                    stages=(Stage("rest", 1), fall), soil=replace(scene.soil, geostatic=False))
    assert build(scene).model.bodies[0].penalty == pytest.approx(20 * 4 / WIDTH)


def test_a_load_on_what_it_carries_counts_for_a_body_that_stands_by_its_weight():
    """25 kN on a quarter would be 0.42 of what clay bears, with the weight 0.75."""
    scene, found = pad(4).scene, []
    body = replace(scene.bodies[0], density=3900.0)
    upper = Body(GEOMETRY / "box.geo", 100.0, name="upper", rest_on=0.5, held=("x", "y", "rx", "ry", "rz"),
                 parameters={"length": 1.0, "width": 1.0, "height": 0.5, "size": 5.0})
    for load in (1e2, 2.5e4):
        press = Stage("press", 1, loads=(Load(body="upper", force=(0.0, 0.0, -load)),))
        found.append(build(replace(scene, bodies=(body, upper), gravity=(0.0, 0.0, -9.81), stages=(press,),
                                   soil=replace(scene.soil, geostatic=False))).model.bodies[0].penalty)
    assert found == pytest.approx([500 * 4 / WIDTH, 20 * 4 / WIDTH])


@pytest.mark.parametrize("height, share", [(0.0, 0.5), (1.0, 0.0)])
def test_a_stem_under_a_slab_is_thebase_share(height, share):
    """A unit square and another beside it, as high or higher: they fill half of the rectangle around them."""
    assert base_share(squares((0.0, 1.0, 0.0), (1.0, 1.0, height)), np.eye(3)) == share
