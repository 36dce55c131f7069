"""Soil that nothing supports and loads that lift a body, without inertia: reported before the first step fails."""

from dataclasses import replace

import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits import LIMITS, unsupported
from hybrid.scene import Faces, Joint, Load, Motion, Stage, Time
from hybrid.study.scenes import box, collapsed, soil_scene, sphere

QUASI_STATIC = Time(1.0, inertia=False)
PLATE = {"density": 8000.0, "position": (0.4, 0.4, 0.0)}


def soil(bodies=(), time=QUASI_STATIC, gravity=(0.0, 0.0, -9.81), **table):
    return soil_scene(bodies, time=time, gravity=gravity, **table)


def test_soil_with_weight_over_a_free_face():
    text, = limit_texts(unsupported.soil_without_support, soil(faces=Faces(z_min="free")))
    assert "weight of the soil, 4.52e+03 N" in text and 'grid.faces.z_min = "free"' in text
    assert 'Set grid.faces.z_min = "fixed"' in text
    text, = limit_texts(unsupported.soil_without_support, soil(lower=(0.0, 0.0, -0.2)))
    assert "ends at z = -0.2 m, 0.2 m above the grid's lower end" in text
    pressed = box(0.2, 0.2, 0.2, rest_on=0.0, position=(0.4, 0.4, 0.0), driven=("z",), velocity=(0.0, 0.0, -0.01))
    text, = limit_texts(unsupported.soil_without_support,
                        soil([pressed], gravity=(0.0, 0.0, 0.0), faces=Faces(z_min="free")))
    assert text.startswith("Nothing holds the soil along z, without inertia") and "gives way as a whole" in text


@pytest.mark.parametrize("table", [
    {}, {"faces": Faces(z_min="roller")}, {"faces": Faces(z_min="free", x_min="fixed")},
    {"faces": Faces(z_min="free"), "gravity": (0.0, 0.0, 0.0)},
    {"faces": Faces(z_min="free"), "time": Time(0.01)},
    {"faces": Faces(z_min="free"), "z": (-0.6, 0.4), "lower": (0.0, 0.0, -0.4),
     "bodies": [box(0.8, 0.8, 0.2, position=(0.4, 0.4, -0.5), held=("x", "y", "z", "rx", "ry", "rz"))]},
    {"faces": Faces(z_min="free"),
     "bodies": [box(0.8, 0.8, 0.2, position=(0.4, 0.4, 0.0), rest_on=0.0, held=("x", "y", "z", "rx", "ry", "rz"),
                    tension="full")]}])
def test_soil_that_is_supported_or_needs_no_support(table):
    """By a face below or at a side, by a body below or one to which it is bonded; without weight, and with inertia."""
    assert not limit_texts(unsupported.soil_without_support, soil(**table))


def loaded(force, time=QUASI_STATIC, **table):
    """Texts about a plate of 64 kg on soil with a force [N]."""
    plate = box(0.2, 0.2, 0.2, **PLATE | {"rest_on": 0.0} | table)
    described = soil([plate], time=time)
    lifted = replace(described, stages=(replace(described.stages[0], loads=(Load(force=force),)),))
    return limit_texts(unsupported.loads_that_lift, lifted)


@pytest.mark.parametrize("force", [(0.0, 0.0, 200e3), ((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 0.0, 200e3))])
def test_a_load_that_lifts_a_body_off_names_its_sign(force):
    text, = loaded(force)
    assert "stage.0.load on body, fz = 200 kN, lifts it off the soil" in text and "its weight, 628 N" in text
    assert "change its sign" in text


def test_loads_that_lift_nothing():
    """Downwards, less than the weight, in space, on a body that is held, or in the soil."""
    assert not loaded((0.0, 0.0, -200e3)) and not loaded((0.0, 0.0, 600.0))
    assert not loaded((0.0, 0.0, 200e3), time=Time(0.01))
    assert not loaded((0.0, 0.0, 200e3),
                      held=("z",)) and not loaded((0.0, 0.0, 200e3), position=(0.4, 0.4, -0.3), rest_on=None)


ALL = ("x", "y", "z", "rx", "ry", "rz")
PUSH = Load(force=(10.0, 0.0, 0.0))
LIFT = Stage("lift", 1, motions=(Motion(component="z", velocity=0.15),))


def staged(*stages, **table):
    """Texts about the plate, 0.5 of friction, in stages."""
    plate = box(0.2, 0.2, 0.2, **PLATE | {"rest_on": 0.0, "friction": 0.5} | table)
    return limit_texts(unsupported.released_bodies, replace(soil([plate], time=QUASI_STATIC), stages=stages))


@pytest.mark.parametrize("stages, table, words", [
    ((Stage("hold", 1, held=ALL), Stage("go", 1)), {"rest_on": 0.15}, "stage 'go': body is free along z, 0.15 m above"),
    ((LIFT, Stage("go", 1)), {}, "stage 'go': body is free along z, 0.15 m above the soil"),
    ((Stage("hold", 1, held=ALL), Stage("go", 1, motions=(Motion(free=("z",)),))), {"rest_on": 0.15, "held": ALL},
     "stage 'go': body is free along z"),
    ((Stage("rest", 1), Stage("go", 1, loads=(PUSH,))), {"friction": 0.0},
     "stage 'go': body is pushed along x on its plane")])
def test_components_that_a_stage_releases_and_nothing_supports(stages, table, words):
    """Found by runs, which fail in the stage that is named."""
    text, = staged(*stages, **table)
    assert words in text and "stage.held, body.held" in text


def ball(**table):
    """Texts about a ball on level ground, smooth unless said otherwise."""
    body = sphere(0.1, size=0.05, **PLATE | {"rest_on": 0.0} | table)
    return limit_texts(unsupported.released_bodies, soil([body]))


def test_a_smooth_round_body_on_level_ground():
    text, = ball()
    assert "free along x, y, where only the unevenness of cells" in text and "a step may have no equilibrium" in text
    assert "free along y, where" in ball(held=("x",))[0]
    assert not ball(friction=0.1) and not ball(held=("x", "y")) and not ball(position=(0.4, 0.4, -0.3), rest_on=None)


def tilted(angle=20.0, axes=(), **table):
    """Texts about a bar 0.4 m long and 0.2 m high with friction, turned by `angle` [°] about y; axes: those of the grid."""
    body = box(0.4, 0.2, 0.2, **PLATE | {"rest_on": 0.0, "friction": 0.5, "rotation": (0.0, 1.0, 0.0, angle)} | table)
    return limit_texts(unsupported.released_bodies, soil([body], **dict(axes)))


def test_a_body_that_stands_on_an_edge():
    """0.2 cos 20° - 0.1 sin 20° beside its centre; upright, turned by a few degrees, or held it does not topple; in plane
    strain it does in the plane."""
    text, = tilted()
    assert tilted(axes={"y": collapsed(0.8)}) == [text] and not tilted(90.0, axes={"y": collapsed(0.8)})
    assert "body stands on an edge or a point 0.154 m beside its centre of mass, about which it topples, and" in text
    assert not tilted(90.0) and not tilted(5.0) and not tilted(held=("ry",)) and not tilted(held=("z",))


@pytest.mark.parametrize("stages, table", [
    ((Stage("go", 1),), {}), ((Stage("go", 1),), {"rest_on": 0.02}), ((LIFT, Stage("on", 1, held=("z",))), {}),
    ((Stage("go", 1),), {"friction": 0.0}), ((Stage("go", 1, loads=(PUSH,)),), {"friction": 0.0, "held": ("x",)}),
    ((Stage("go", 1, loads=(PUSH,)),), {}),
    ((Stage("go", 1, loads=(PUSH,)),), {"friction": 0.0, "position": (0.4, 0.4, -0.3), "rest_on": None})])
def test_bodies_that_soil_or_guides_support(stages, table):
    """On the soil or a tenth of a cell above it, held, not pushed, with friction, or in the soil."""
    assert not staged(*stages, **table)


def hinged(rise=0.2, angle=0.0, point=(-0.2, 0.0, 0.1), joint=None, **table):
    """Texts about an arm on a hinge at the top of a box that lies on the soil."""
    base = box(0.2, 0.2, 0.2, **PLATE | {"rest_on": 0.0, "friction": 0.5, "position": (0.2, 0.4, 0.0), "name": "base"})
    place = {"position": (0.5, 0.4, rise), "name": "arm", "rotation": (0.0, 1.0, 0.0, angle)}
    arm = box(0.4, 0.2, 0.2, **PLATE | place | table)
    pin = Joint(**{"name": "pin", "kind": "hinge", "bodies": ("arm", "base"), "point": point, "axis": (0.0, 1.0, 0.0)}
                | (joint or {}))
    described = replace(soil([base, arm]), joints=(pin,))
    return limit_texts(unsupported.swinging_bodies, described)


@pytest.mark.parametrize("changed", [{}, {"angle": 20.0, "rise": 0.4}, {"joint": {"kind": "ball", "axis": None}},
                                     {"joint": {"friction_moment": 1.0}}])
def test_an_arm_that_hangs_on_a_hinge_above_the_soil(changed):
    text, = hinged(**changed)
    assert text.startswith("arm hangs on pin, 0.") and "weight turns it" in text and "body.held" in text


@pytest.mark.parametrize("changed", [
    {"rise": 0.1}, {"joint": {"kind": "weld", "axis": None}}, {"held": ("ry",)}, {"point": (0.0, 0.0, 0.1)},
    {"joint": {"friction_moment": 1e4}}, {"joint": {"limits": (0.0, 10.0)}}, {"joint": {"axis": (0.0, 0.0, 1.0)}}])
def test_joined_bodies_that_their_weight_does_not_turn(changed):
    """On the soil, welded, held, hung in balance, stiff hinges, stops, and a hinge about the vertical."""
    assert not hinged(**changed)


def test_check_and_runs_ask_for_them():
    assert set(unsupported.LIMITS) <= set(LIMITS) and len(unsupported.LIMITS) == 4
