"""Travels that limits see: of each stage by itself, along the face that leads, at any angle to the grid."""

from dataclasses import replace

import numpy as np
import pytest
from limit_texts import limit_texts

from hybrid.laws.von_mises import VonMises
from hybrid.monitors.limits import cells, limit_warnings, sand_cells
from hybrid.monitors.limits.loading import driven, loaded
from hybrid.monitors.limits.materials import law_at, stays_attached
from hybrid.monitors.limits.shape import sides
from hybrid.monitors.limits.travels import travels_of
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Joint, Layer, Load, Material, Motion, Pull, Scene, Soil, Stage, Time
from hybrid.setup.build import build

SAND = Material(young=5e7, poisson=0.3, density=1700.0, friction_angle=30.0, dilation_angle=0.0, cohesion=0.0)
CLAY = Material(law="von-mises", young=5e6, poisson=0.49, density=1700.0, strength=1e4)


def described(*stages, material=SAND, rotation=None, velocity=(0.0, 0.0, 0.0), z=0.5, size=(2.0, 1.0), **values):
    """A strip in plane strain that a scene drives in x and z; size: [m] length and height of the box."""
    strip = Body(GEOMETRY / "box.geo", 2000.0, name="strip", position=(0.0, 0.5, z), rotation=rotation, held=("ry",),
                 driven=("x", "z"), velocity=velocity,
                 parameters={"length": size[0], "width": 1.0, "height": size[1], "size": 20.0}, **values)
    return Scene(name="travel", grid=Grid(Axis(-4.0, 4.0, 0.25), Axis(0.0, 1.0, collapsed=True), Axis(-5.0, 2.0, 0.25),
                                       Faces(z_min="fixed")),
                 soil=Soil(material, top=0.0, geostatic=False), bodies=(strip,), time=Time(1.0, inertia=False),
                 stages=stages or (Stage("one", 10),))


def drive(name, x=0.0, z=0.0):
    """A stage of ten seconds with these speeds [m/s]."""
    return Stage(name, 10, motions=(Motion(component="x", velocity=x), Motion(component="z", velocity=z)))


def travels(*stages):
    scene = described(*stages)
    found = travels_of(scene, scene.bodies[0], np.array([0, 1, 0], bool))
    return [tuple(np.round(np.concatenate(pair), 6)) for pair in found]


def test_each_stage_has_its_way_and_those_of_one_direction_are_one():
    down, further, along = drive("down", z=-0.01), drive("further", z=-0.02), drive("along", x=0.01)
    assert travels(down, along) == [(0, 0, 0, 0, 0, -0.1), (0, 0, -0.1, 0.1, 0, 0)]
    assert travels(down, further) == [(0, 0, 0, 0, 0, -0.3)]
    assert travels(down, along, further) == [(0.1, 0, -0.1, 0, 0, -0.2), (0, 0, -0.1, 0.1, 0, 0)]
    assert travels(down, drive("up", z=0.01)) == [(0, 0, 0, 0, 0, -0.1), (0, 0, -0.1, 0, 0, 0.1)]
    assert travels(drive("still")) == []


@pytest.mark.parametrize("stages", [
    [drive("press", z=-0.005)], [drive("press", z=-0.005), drive("drag", x=0.005)], [drive("press", x=0.001, z=-0.005)],
    [drive("drag", x=0.005), drive("press", z=-0.005)]])
def test_a_strip_on_sand_is_told_the_same_whatever_it_does_besides(stages):
    text, = limit_texts(sand_cells.footings, described(*stages))
    assert "a base 8 cells of 0.25 m wide" in text and "about 89%" in text


@pytest.mark.parametrize("angle, excess", [(0.0, 22), (90.0, 22), (30.0, 16), (45.0, 16)])
def test_a_plate_that_clay_sticks_to_is_judged_across_its_normal(angle, excess):
    """Drawn by 0.05 m along it; found 22 % above what smaller cells tend to along the grid, 15 % at 30 and 45 degrees."""
    normal = np.array([np.sin(np.radians(angle)), 0.0, np.cos(np.radians(angle))])
    scene = described(material=CLAY, rotation=(0.0, 1.0, 0.0, angle), velocity=tuple(0.005 * normal), z=-3.0,
                      size=(1.0, 0.25), adhesion=1.0, tension="full")
    scene = replace(scene, grid=replace(scene.grid, x=Axis(-4.0, 4.0, 0.125), z=Axis(-6.0, 1.0, 0.125)))
    text, = limit_texts(cells.few_cells, scene)
    assert "is 8 cells of 0.125 m wide" in text and f"about {excess}%" in text


def test_sides_of_a_way_between_the_axes_lie_in_its_plane():
    scene = described()
    grid = build(scene).model.soil.grid
    place = np.array([[0.0, 0.5, 0.0], [2.0, 0.5, 0.0], [0.0, 0.5, 1.0], [2.0, 0.5, 1.0]])
    side, = sides(grid, place, np.array([1.0, 0.0, 1.0]))
    assert side.axis is None and side.width == pytest.approx(3.0 / np.sqrt(2.0))
    side, = sides(grid, place, np.array([0.0, 0.0, 1.0]))
    assert side.axis == 0 and side.width == pytest.approx(2.0)


def test_notes_about_several_travels_of_a_body_name_them():
    scene = described(drive("up", z=0.005), drive("aside", x=0.005), material=CLAY, z=-3.0, size=(1.0, 0.5), adhesion=1.0,
                      tension="full")
    up, aside = limit_texts(cells.few_cells, scene)
    assert up.startswith("strip, moved up, stays attached") and aside.startswith("strip, moved along x, stays attached")


@pytest.mark.parametrize("stages", [
    (Stage("both", 10, loads=(Load(force=(0.0, 0.0, -3e4), moment=(0.0, 6e3, 0.0)),)),),
    (Stage("first", 10, loads=(Load(force=(0.0, 0.0, -3e4)),)),
     Stage("then", 10, loads=(Load(force=(0.0, 0.0, -3e4), moment=(0.0, 6e3, 0.0)),)))])
def test_a_moment_counts_that_comes_after_the_force(stages):
    scene = described(*stages, material=CLAY, rest_on=0.0)
    strip = replace(scene.bodies[0], driven=(), position=(0.0, 0.5, 0.5), held=("x",))
    text, = limit_texts(cells.few_cells, replace(scene, bodies=(strip,)))
    assert "0.1 of its width beside its middle" in text


@pytest.mark.parametrize("x, told", [(0.0, 1), (3.0, 0)])
def test_a_force_on_a_body_that_stands_on_another_one_loads_the_lower_one(x, told):
    """Of a block on a strip, or beside it in the air."""
    force = Load(body="block", force=((0.0, 0.0, 0.0, 0.0), (10.0, 0.0, 0.0, -2e5)))
    scene = described(Stage("press", 10, loads=(force,)), material=CLAY, rest_on=0.0)
    strip = replace(scene.bodies[0], driven=(), held=("x",), position=(0.0, 0.5, 0.0))
    block = replace(strip, name="block", position=(x, 0.5, 0.0), rest_on=strip.parameters["height"], held=("x", "ry"),
                    parameters={"length": 0.6, "width": 1.0, "height": 0.5, "size": 5.0})
    found = [text for text in limit_texts(cells.few_cells, replace(scene, bodies=(strip, block))) if "strip" in text]
    assert len(found) == told


@pytest.mark.parametrize("height, law", [(1.0, "mohr-coulomb"), (-0.5, "mohr-coulomb"), (-2.0, "von-mises")])
def test_soil_above_the_top_is_that_of_the_top(height, law):
    scene = described(material=CLAY)
    sand = Layer("sand", bottom=-1.0, law="mohr-coulomb",
                 material={"friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 0.0})
    scene = replace(scene, soil=replace(scene.soil, layers=(sand,)))
    assert law_at(scene, build(described(material=CLAY)).model.soil, height) == law


@pytest.mark.parametrize("tension, stays", [(None, False), (1e5, False), (1e6, True), ("full", True)])
def test_clay_stays_on_a_body_whose_tension_it_never_reaches(tension, stays):
    model = build(described(material=CLAY, tension=tension)).model
    assert stays_attached(model.bodies[0], model.soil) == stays


@pytest.mark.parametrize("table", [{"velocity": (0.0, 0.0, -0.01)}, {"velocity": (0.01, 0.0, 0.0)},
                                   {"driven": (), "held": ("x",), "position": (0.0, 0.5, 0.5)}])
def test_bodies_in_soil_with_a_law_of_the_user_have_no_notes_about_clay(table):
    """Such a law has no parameters by which these could judge."""
    load = Load(force=(0.0, 0.0, -1e3))
    loads = () if "velocity" in table else (load,)
    scene = described(Stage("one", 10, loads=loads), material=Material(law="user", density=1700.0))
    strip = replace(scene.bodies[0], tension=1e3, **table)

    def law(points, stress):
        return VonMises(*(np.full(len(stress), value) for value in (1e7, 0.3, 1e4)))

    simulation = build(replace(scene, bodies=(strip,)), law=law)
    assert not any("clay" in text for text in limit_warnings(simulation.scene, simulation.model))


@pytest.mark.parametrize("point, says", [((0.0, 0.0, -0.5), False), ((0.0, 0.0, 0.0), True), ((0.2, 0.0, -0.5), True)])
def test_a_load_beside_the_middle_of_the_base_is_eccentric(point, says):
    """A force along the base of a strip 1 m high tilts it where it acts above the base only."""
    scene = described(Stage("one", 10, loads=(Load(force=(1e4, 0.0, -3e4), point=point),)), material=CLAY, rest_on=0.0)
    strip = replace(scene.bodies[0], driven=(), position=(0.0, 0.5, 0.5), held=())
    simulation = build(replace(scene, bodies=(strip,)))
    (*_, arm), = loaded(simulation.scene, simulation.model)
    assert (arm > 0.0) == says
    assert not says or arm == pytest.approx(0.5 / 3 if point[0] == 0.0 else 0.2)


def test_a_load_on_a_body_that_is_joined_is_not_eccentric():
    """How much of its moment the joint hands on to the other body is known only when both are in equilibrium."""
    scene = described(Stage("one", 10, loads=(Load("strip", force=(0.0, 0.0, -3e4), point=(0.4, 0.0, 0.5)),)),
                      material=CLAY, rest_on=0.0)
    strip = replace(scene.bodies[0], driven=(), position=(0.0, 0.5, 0.5), held=())
    twin = replace(strip, name="twin", position=(2.1, 0.5, 0.5))
    hinge = Joint("hinge", "hinge", ("strip", "twin"), point=(1.0, 0.0, 0.5), axis=(0.0, 1.0, 0.0))
    arms = []
    for joints in (), (hinge,):
        simulation = build(replace(scene, bodies=(strip, twin), joints=joints))
        arms += [arm for *_, arm in loaded(simulation.scene, simulation.model)]
    assert arms == [pytest.approx(0.4), 0.0]


def test_arms_count_where_nothing_else_of_an_assembly_touches_soil():
    """A mast above hands on nothing, a chain of two to a strip beside it does, and so does the ground."""
    load = Load("strip", force=(0.0, 0.0, -3e4), point=(0.4, 0.0, 0.5))
    scene = described(Stage("one", 10, loads=(load,)), material=CLAY, rest_on=0.0)
    strip = replace(scene.bodies[0], driven=(), position=(0.0, 0.5, 0.5), held=())
    small = {**strip.parameters, "length": 0.2, "height": 0.2}
    mast = replace(strip, name="mast", rest_on=1.0, parameters=small)
    twin = replace(strip, name="twin", position=(2.1, 0.5, 0.5))

    def weld(name, *bodies):
        return Joint(name, "weld", bodies, point=(0.0, 0.0, 0.0))

    arms = []
    chain = weld("b", "mast", "twin"), weld("a", "strip", "mast")
    for joints in (weld("a", "mast", "strip"),), chain, (weld("g", "strip"),):
        simulation = build(replace(scene, bodies=(strip, mast, twin), joints=joints))
        arms += [arm for body, *_, arm in loaded(simulation.scene, simulation.model) if body.name == "strip"]
    assert arms == [pytest.approx(0.4), 0.0, 0.0]
    hinge = Joint("h", "hinge", ("strip",), point=(-1.0, 0.0, -0.5), axis=(0.0, 1.0, 0.0))
    simulation = build(replace(scene, bodies=(strip, mast, twin), joints=(hinge,)))
    assert [arm for body, *_, arm in loaded(simulation.scene, simulation.model) if body.name == "strip"] == [0.0]


@pytest.mark.parametrize("load, told", [(1e4, 0), (6e4, 1)])
def test_clay_that_bears_a_load_by_far_has_no_note_about_what_it_carries(load, told):
    """Of a strip of 2 m on 4 cells, s_u = 10 kPa: half of what it carries is 51 kN, with its weight of 39 kN."""
    scene = described(Stage("one", 10, loads=(Load(force=(0.0, 0.0, -load)),)), material=CLAY, rest_on=0.0)
    strip = replace(scene.bodies[0], driven=(), position=(0.0, 0.5, 0.5), held=("x", "ry"))
    grid = replace(scene.grid, x=Axis(-4.0, 4.0, 0.5), z=Axis(-5.0, 2.0, 0.5))
    assert len(limit_texts(cells.few_cells, replace(scene, bodies=(strip,), grid=grid))) == told


def loads(rotation=None, held=(), of_stage=(), stage_motion=(), **load):
    """(travel, arm, inclined) of a strip of 2 m x 1 m that a load presses on clay."""
    stage = Stage("one", 10, loads=(Load(**load),), held=of_stage, motions=stage_motion)
    scene = described(stage, material=CLAY, rotation=rotation, rest_on=0.0)
    strip = replace(scene.bodies[0], driven=(), position=(0.0, 0.5, 0.5), held=held)
    simulation = build(replace(scene, bodies=(strip,)))
    (_, travel, _, plane, _, inclined, arm), = loaded(simulation.scene, simulation.model)
    assert plane
    return travel, arm, inclined


BESIDE = {"force": (0.0, 0.0, -8e4), "point": (0.25, 0.0, 0.0)}


@pytest.mark.parametrize("held, arm", [({}, 0.25), ({"held": ("ry",)}, 0.0), ({"of_stage": ("ry",)}, 0.0),
                                       ({"stage_motion": (Motion(held=("ry",)),)}, 0.0),
                                       ({"held": ("ry",), "stage_motion": (Motion(free=("ry",)),)}, 0.25)])
def test_a_moment_that_something_holds_is_no_eccentricity(held, arm):
    assert loads(**held, **BESIDE)[1] == pytest.approx(arm)


def test_a_load_normal_to_an_inclined_base_is_central_and_upright():
    """The base is at 30 degrees; a load straight down through the same centre is neither."""
    normal = -8e4 * np.array([0.5, 0.0, np.sqrt(0.75)])
    travel, arm, inclined = loads((0.0, 1.0, 0.0, 30.0), force=tuple(normal))
    assert travel == pytest.approx(normal) and arm == 0.0 and not inclined
    travel, arm, inclined = loads((0.0, 1.0, 0.0, 30.0), force=(0.0, 0.0, -8e4))
    assert travel == pytest.approx(np.sqrt(0.75) * normal) and inclined and arm == pytest.approx(0.5 * np.tan(np.pi / 6))


@pytest.mark.parametrize("normal, inclined", [(True, False), (False, True)])
def test_a_base_on_a_slope_is_judged_as_on_level_ground(normal, inclined):
    """A strip turned by the 15 degrees of the slope, under a load normal to it or straight down."""
    slope = np.tan(np.radians(15.0))
    force = -8e4 * (np.array([-np.sin(np.radians(15.0)), 0.0, np.cos(np.radians(15.0))]) if normal else np.eye(3)[2])
    scene = described(Stage("one", 10, loads=(Load(force=tuple(force)),)), material=CLAY, size=(0.8, 0.3),
                      rotation=(0.0, 1.0, 0.0, -15.0), rest_on="ground")
    strip = replace(scene.bodies[0], driven=(), held=())
    soil = replace(scene.soil, ground=((-4.0, -4.0 * slope - 0.5), (4.0, 4.0 * slope - 0.5)), top=1.0)
    simulation = build(replace(scene, bodies=(strip,), soil=soil, gravity=(0.0, 0.0, 0.0)))
    (_, travel, _, plane, _, found, arm), = loaded(simulation.scene, simulation.model)
    assert plane and found == inclined and arm == 0.0       # 40 mm, less than a twentieth of its size, straight down
    assert travel == pytest.approx((0.0, 0.0, -8e4 * (1.0 if normal else np.cos(np.radians(15.0)))), abs=1.0)


@pytest.mark.parametrize("way, material, told", [
    (0.0075, CLAY, 0), (0.0085, CLAY, 1), (0.0075, replace(CLAY, strength=5e3), 1), (0.001, replace(CLAY, strength=0.0,
                                                                                   strength_gradient=1e4), 1)])
def test_clay_that_hardly_yields_has_no_note_about_what_it_bears_when_it_does(way, material, told):
    """2 s_u B/E is 8 mm; half of it for half the strength, and not known of clay without strength at its top."""
    scene = described(drive("press", z=-0.1 * way), material=material)
    scene = replace(scene, grid=replace(scene.grid, x=Axis(-4.0, 4.0, 0.5), z=Axis(-5.0, 2.0, 0.5)))
    assert len(limit_texts(cells.few_cells, scene)) == told


@pytest.mark.parametrize("down, lowest", [(0.01, -0.1), (-0.01, 0.0)])
def test_a_body_that_goes_forwards_and_down_goes_forwards_as_deep_as_in_the_end(down, lowest):
    """A block that starts on the surface, and one that goes up as it moves away."""
    simulation = build(described(drive("one", 0.04, -down), material=CLAY))
    (_, travel, place, plane, *_), = driven(simulation.scene, simulation.model)
    assert travel == pytest.approx((0.4, 0.0, 0.0)) and plane
    assert place[:, 2].min() == pytest.approx(lowest, abs=1e-9)


def test_a_body_on_which_a_driven_one_stands_is_judged_as_if_it_were_driven():
    """And not where that one is lifted, stands beside it, or does not reach it."""
    found = []
    for x, speed, gap in ((0.0, -0.05, 0.0), (0.0, 0.05, 0.0), (3.0, -0.05, 0.0), (0.0, -0.05, 0.3), (0.0, -0.05, 0.1),
                          (0.0, -0.1, 0.3)):
        strip = described(Stage("press", 4), material=CLAY, size=(1.0, 1.0), z=0.5)
        (lower,) = strip.bodies
        upper = replace(lower, name="upper", position=tuple(np.add(lower.position, (x, 0.0, 1.0 + gap))), driven=("z",),
                        velocity=(0.0, 0.0, speed))
        simulation = build(replace(strip, bodies=(replace(lower, driven=(), held=("ry",)), upper)))
        found.append([body.name for body, *_ in driven(simulation.scene, simulation.model)])
    assert found == [[lower.name], [], [], [], [lower.name], [lower.name]]


ROD = Joint("rod", "rod", ("strip", "ram"), point=(0.4, 0.0, 0.0), end=(-0.4, 0.0, 0.0))
LINE = replace(ROD, kind="line")
HINGE = Joint("hinge", "hinge", ("strip", "ram"), (0.5, 0.5, -0.5), axis=(0.0, 1.0, 0.0))


@pytest.mark.parametrize("joints, gap, speed, held, travel", [
    ((), 0.0, -0.01, ("ry",), -0.1), ((), 0.05, -0.01, ("ry",), -0.05), ((), 0.0, 0.01, ("ry",), None),
    ((), 0.3, -0.1, ("ry",), None), ((), 0.0, -0.01, ("x", "ry"), None),
    ((ROD,), 0.5, -0.01, ("ry",), -0.1), ((ROD,), 0.5, 0.01, ("ry",), 0.1), ((LINE,), 0.5, -0.01, (), None),
    ((LINE,), 0.5, 0.01, (), 0.1), ((replace(LINE, length=0.76),), 0.5, 0.01, (), 0.04),
    ((HINGE,), 0.5, 0.01, ("ry",), 0.1), ((HINGE,), 0.5, 0.01, (), None)])
def test_what_a_ram_beside_it_a_rod_a_line_or_a_hinge_moves_counts_as_driven(joints, gap, speed, held, travel):
    """A strip in the soil, with a driven one `gap` beside it."""
    scene = described(Stage("push", 10), material=CLAY, size=(1.0, 1.0), z=-0.5)
    (strip,) = scene.bodies
    ram = replace(strip, name="ram", position=(1.0 + gap, 0.5, -0.5), driven=("x",), held=("z", "ry"),
                  velocity=(speed, 0.0, 0.0))
    strip = replace(strip, driven=(), held=held)
    simulation = build(replace(scene, bodies=(strip, ram), joints=joints))
    found = [float(way[0]) for body, way, *_ in driven(simulation.scene, simulation.model) if body.name == "strip"]
    assert found == ([] if travel is None else [pytest.approx(travel)])


def test_a_rod_across_a_motion_hands_nothing_on():
    """An upright one, whose upper end goes along the ground."""
    scene = described(Stage("push", 10), material=CLAY, size=(1.0, 1.0), z=-0.5)
    (strip,) = scene.bodies
    crane = replace(strip, name="crane", position=(0.0, 0.5, 1.4), held=("z", "ry"), driven=("x",),
                    velocity=(0.01, 0.0, 0.0))
    rod = Joint("rod", "rod", ("strip", "crane"), point=(0.0, 0.0, 0.5), end=(0.0, 0.0, -0.5))
    simulation = build(replace(scene, bodies=(replace(strip, driven=(), held=("ry",)), crane), joints=(rod,)))
    assert [body.name for body, *_ in driven(simulation.scene, simulation.model) if body.name == "strip"] == []


def test_ropes_and_lines_do_not_press():
    """A strip under a crane that goes down on a rope, and on a rod; one on a line that is let down, and on a strut."""
    (strip,), found = described(material=CLAY, size=(1.0, 1.0), z=0.5).bodies, []
    strip = replace(strip, driven=(), held=("x", "ry"))
    crane = replace(strip, name="crane", position=(strip.position[0], 0.5, 1.8), driven=("z",))
    down = Stage("down", 4, motions=(Motion(body="crane", component="z", velocity=-0.05),))
    for kind in ("line", "rod"):
        joint = Joint("rope", kind, ("strip", "crane"), point=(0.0, 0.0, 0.5), end=(0.0, 0.0, -0.5))
        scene = replace(described(down, material=CLAY), bodies=(strip, crane), joints=(joint,))
        found.append([body.name for body, *_ in driven(scene, build(scene).model)])
    for tension_only in (True, False):
        line = Pull((0.0, 0.0, 0.5), (0.0, 0.0, -0.05), 1e6, 2.0, direction=(0.0, 0.0, 1.0), tension_only=tension_only)
        scene = replace(described(Stage("down", 4), material=CLAY), bodies=(replace(strip, pull=line),))
        found.append([body.name for body, *_ in driven(scene, build(scene).model)])
    assert found == [[], ["strip"], [], ["strip"]]


def test_a_body_welded_to_one_that_is_driven_is_judged_as_that_one_is():
    """A footing under a mast, which itself never gets to the soil."""
    scene = described(material=CLAY)
    foot = replace(scene.bodies[0], driven=(), held=())
    mast = replace(scene.bodies[0], name="mast", position=(0.0, 0.5, 3.0), driven=(), held=())
    press = Stage("press", 10, motions=(Motion(body="mast", component="z", velocity=-0.01),))
    weld = Joint("weld", "weld", ("mast", "strip"), (0.0, 0.5, 1.0))
    simulation = build(replace(scene, bodies=(foot, mast), joints=(weld,), stages=(press,)))
    found = [(one.name, travel[2]) for one, travel, *_ in driven(simulation.scene, simulation.model)]
    assert found == [("strip", pytest.approx(-0.1))]


@pytest.mark.parametrize("held, expected", [(("ry",), [-0.1]), ((), [])])
def test_a_body_that_a_point_drives_counts_as_driven_where_it_cannot_turn(held, expected):
    """And not as one that the point pushes as well."""
    press = Stage("press", 10, motions=(Motion(component="z", velocity=-0.01, point=(0.0, 0.5, 0.5)),))
    scene = described(press, material=CLAY)
    scene = replace(scene, bodies=(replace(scene.bodies[0], driven=(), held=held),))
    simulation = build(scene)
    assert [travel[2] for _, travel, *_ in driven(scene, simulation.model)] == pytest.approx(expected)
    assert bool(list(loaded(scene, simulation.model))) != bool(expected)


def test_the_thickness_of_a_slice_is_no_size_of_a_body():
    """A load 0.25 m beside the middle of a strip of 2 m, in a slice of 8 m."""
    stage = Stage("one", 10, loads=(Load(force=(0.0, 0.0, -6.4e5), point=(0.25, 0.0, 0.0)),))
    scene = described(stage, material=CLAY, rest_on=0.0)
    strip = replace(scene.bodies[0], driven=(), position=(0.0, 4.0, 0.5), held=(),
                    parameters={"length": 2.0, "width": 8.0, "height": 1.0, "size": 20.0})
    simulation = build(replace(scene, bodies=(strip,), grid=replace(scene.grid, y=Axis(0.0, 8.0, collapsed=True))))
    assert [arm for *_, arm in loaded(simulation.scene, simulation.model)] == pytest.approx([0.25])
