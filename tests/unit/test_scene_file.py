"""Scene files: what is read, and that each error names a remedy."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from small_scene import SCENE, refused

from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Grid, Material, Pull, Scene, Soil, Stage, Time
from hybrid.scene.file import load_scene, scene_from_dict, toml_value, validate

DEMOS = Path(__file__).parents[2] / "demos"


def test_a_file_becomes_the_dataclasses(scene, path):
    assert scene.name == "small"  # after the file
    assert scene.grid.x == Axis(0.0, 4.0, 0.5, fine=(1.0, 2.0))
    assert (scene.grid.y.start, scene.grid.y.end) == (0.0, 2.5)  # from the nodes
    assert scene.grid.faces.z_min == "fixed" and scene.grid.faces.z_max == "free"
    assert scene.soil.material == Material(relative_density=38.0)
    (ball,) = scene.bodies
    assert ball.geometry == path.parent / "ball.geo"  # relative to the scene file, not to the working folder
    assert ball.parameters == {"radius": 1.0}
    assert ball.pull == Pull("eye", (0.5, 0.0, 0.0), 1e6, 10.0)
    assert [stage.name for stage in scene.stages] == ["settle", "drag"]
    assert isinstance(scene.grid.x.start, float) and isinstance(ball.density, float)


def test_a_single_body_table_is_one_body(path):
    tables = SCENE.replace("[[body]]", "[body]")
    path.write_text(tables)
    assert load_scene(path, ["body.0.friction=0.3"]).bodies[0].friction == 0.3
    assert load_scene(path, ["body.friction=0.3"]).bodies[0].friction == 0.3
    assert load_scene(path, ["body.ball.friction=0.3"]).bodies[0].friction == 0.3
    path.write_text(tables.replace('name = "ball"\n', ""))
    assert load_scene(path, ["body.body.friction=0.3"]).bodies[0].friction == 0.3    # the name that it has by default


@pytest.mark.parametrize("demo", sorted(DEMOS.glob("*.toml")), ids=lambda demo: demo.stem)
def test_every_demo_is_a_valid_scene(demo):
    scene = load_scene(demo)
    assert scene.name == demo.stem
    assert validate(scene) == scene


@pytest.mark.parametrize("override, read", [
    ("body.0.friction=0.3", lambda s: s.bodies[0].friction == 0.3),
    ("body.0.friction=1", lambda s: s.bodies[0].friction == 1.0),
    ("stage.1.steps = 20", lambda s: s.stages[1].steps == 20),
    ("soil.material.law=hencky", lambda s: s.soil.material.law == "hencky"),
    ("soil.material.law='hencky'", lambda s: s.soil.material.law == "hencky"),
    ("soil.points_per_axis=[2, 3, 1]", lambda s: s.soil.points_per_axis == (2, 3, 1)),
    ("soil.held=true", lambda s: s.soil.held is True),
    ("gravity.2=0.0", lambda s: s.gravity == (0.0, 0.0, 0.0)),
    ("output.pictures=[1, 5]", lambda s: s.output.pictures == (1, 5)),
    ("body.0.parameters.size=0.2", lambda s: s.bodies[0].parameters == {"radius": 1.0, "size": 0.2}),
    ("body.0.pull.point=[1, 0, 0]", lambda s: s.bodies[0].pull.point == (1.0, 0.0, 0.0)),
    ("name=a=b", lambda s: s.name == "a=b"),
    ("body.ball.friction=0.3", lambda s: s.bodies[0].friction == 0.3),
    ("body.ball.pull.length=3", lambda s: s.bodies[0].pull.length == 3.0),
    ("stage.drag.steps=20", lambda s: (s.stages[0].steps, s.stages[1].steps) == (5, 20)),
])
def test_overrides(path, override, read):
    path.write_text("gravity = [0, 0, -9.81]\n" + SCENE)
    assert read(load_scene(path, [override]))


def test_later_overrides_win(path):
    assert load_scene(path, ["time.step=1", "time.step=0.5"]).time.step == 0.5


@pytest.mark.parametrize("text, value", [("1e-2", 0.01), ("[1, 2]", [1, 2]), ("true", True), ("sand", "sand"),
                                         ("1\nother = 2", "1\nother = 2"), ("", "")])
def test_values_are_toml_and_else_text(text, value):
    assert toml_value(text) == value


@pytest.mark.parametrize("override, words", [
    ("body.0.frction=0.3", ["body.0.frction", "'friction'", "valid in [body.0]", "penalty"]),
    ("tim.step=1", ["'tim'", "'time'", "the top level"]),
    ("body.0.pull.stifness=1", ["'stiffness'", "[body.0.pull]"]),
    ("soil.material.law=drucker", ["soil.material.law = 'drucker'", "drucker-prager, hencky"]),
    ("grid.faces.x_min=rollr", ["'roller'"]),
    ("body.0.held=['y', 'rxy']", ["body.0.held.1 = 'rxy'", "x, y, z, rx, ry, rz"]),
])
def test_unknown_names_come_with_the_nearest_and_the_list(path, override, words):
    message = refused(path, override)
    assert all(word in message for word in words), message


@pytest.mark.parametrize("override, words", [
    ("time.step=fast", ["time.step = 'fast'", "a number"]),
    ("time.step=true", ["time.step = true", "a number"]),
    ("stage.0.steps=true", ["a whole number"]),
    ("stage.0.steps=2.5", ["stage.0.steps = 2.5", "a whole number"]),
    ("stage.0.pull=1", ["true or false"]),
    ("name=3", ["text"]),
    ("gravity=[0, -9.81]", ["gravity = [0, -9.81]", "3 numbers"]),
    ("gravity=[0, 0, nan]", ["gravity.2", "finite"]),
    ("body.0.density=inf", ["body.0.density", "finite"]),
    ("body.0.parameters.radius=big", ["body.0.parameters.radius", "a number"]),
    ("body.0.parameters=1", ["a table of named numbers"]),
    ("body.0.pull.point=3", ["text or a list of 3 numbers"]),
    ("body.0.pull.point=[1, 2, true]", ["body.0.pull.point.2 = true", "a number"]),
    ("body.0.geometry=1", ["a path"]),
    ("soil.points_per_axis=[2, 2]", ["3 whole numbers"]),
    ("grid=3", ["a table (x, y, z, faces, follow, behind)"]),
    ("stage=3", ["a list of tables"]),
    ("time=[]", ["a table"]),
    ("time.step=2024-01-01", ["a number"]),
    ("soil.ground=0.1", ["soil.ground = 0.1: expected a list of lists", "write rows, such as [[0, 0], [10, 0.1]]"]),
])
def test_wrong_types_name_key_value_and_what_was_expected(path, override, words):
    message = refused(path, override)
    assert all(word in message for word in words), message


@pytest.mark.parametrize("override, words", [
    ("time.step", ["key.path=value"]),
    ("=3", ["key.path=value"]),
    ("a..b=3", ["key.path=value"]),
    ("body.friction=3", ["list of 1", "no item 'friction'", "write body.0.friction or body.ball.friction"]),
    ("body.bal.pull.length=3", ["no item 'bal' (did you mean 'ball'?)", "body.0.pull.length or body.ball.pull.length"]),
    ("stage.steps=3", ["list of 2", "write stage.0.steps or stage.settle.steps"]),
    ("body.1.friction=3", ["1 in it"]),
    ("time.step.x=3", ["time.step = 0.04 is a value"]),
])
def test_malformed_overrides(path, override, words):
    message = refused(path, override)
    assert all(word in message for word in words), message


@pytest.mark.parametrize("overrides, words", [
    (["time.scheme=generalised-alpha", "time.spectral_radius=1.5"], ["spectral_radius = 1.5", "from 0 to 1"]),
    (["time.scheme=generalised-alpha", "time.beta=0.25"], ["time.beta = 0.25", "or set scheme = 'newmark'"]),
    (["time.scheme=energy-momentum", "time.gamma=0.5"], ["time.gamma = 0.5", "left out with scheme"]),
    (["time.scheme=energy-momentum", "time.spectral_radius=0.8"], ["left out with scheme = 'energy-momentum'"]),
    (["time.scheme=energy-momentum", "stage.0.gamma=1"], ["stage.0.beta = 0.25", "(0.5625, 1)"]),
])
def test_schemes_take_their_own_parameters_only(path, overrides, words):
    message = refused(path, *overrides)
    assert all(word in message for word in words), message


def test_all_wrong_keys_are_named_at_once(path):
    message = refused(path, "time.stp=1", "body.0.density=heavy", "body.0.held=['u', 'v']", "gravity=[0, 0]")
    assert message.startswith("5 faults")
    for words in ("unknown key 'time.stp' (did you mean 'step'?)", "body.0.density = 'heavy': expected a number",
                  "body.0.held.0 = 'u'", "body.0.held.1 = 'v'", "gravity = [0, 0]: expected a list of 3 numbers"):
        assert words in message


def test_missing_keys_and_files(path, tmp_path):
    path.write_text(SCENE.replace('geometry = "ball.geo"\ndensity = 7850\n', ""))
    assert "missing in [body.0]: geometry, density" in refused(path)
    path.write_text(SCENE.replace("end = 1.0\n", ""))
    assert "grid.z: missing end" in refused(path)
    path.write_text("")
    assert "missing in the top level: grid, soil, time, stage" in refused(path)
    assert "did you mean 'small.toml'" in refused(tmp_path / "smal.toml")
    assert "directory" in refused(tmp_path).lower()


def test_syntax_errors_give_the_line(path):
    path.write_text("[time]\nstep = = 3\n")
    assert "line 2" in refused(path)
    path.write_text("[time]\nstep = [1,\n")
    assert "line 2" in refused(path)
    path.write_bytes(b"name = '\xff'")
    assert "UTF-8" in refused(path)


def from_python(geometry):
    """A scene as one would write it in Python: arrays, whole numbers and paths as text."""
    axis = Axis(0, 2, 0.5)
    return Scene(
        name="python", grid=Grid(axis, Axis(nodes=np.array([0.0, 1.0])), axis),
        soil=Soil(Material(relative_density=38)),
        bodies=[Body(str(geometry), 7850, velocity=np.array([1, 0, 0]), friction=np.float64(0.3))],
        time=Time(np.float32(0.5)), stages=[Stage("only", np.int64(3))])


def test_scenes_from_python_are_converted_and_checked(path):
    given = from_python(path.parent / "ball.geo")
    scene = validate(given)
    assert scene.grid.y.nodes == (0.0, 1.0) and scene.grid.y.end == 1.0
    assert scene.bodies[0].velocity == (1.0, 0.0, 0.0) and type(scene.bodies[0].friction) is float
    assert isinstance(scene.bodies[0].geometry, Path) and type(scene.stages[0].steps) is int
    assert validate(scene) == scene
    with pytest.raises(SceneError, match="stage.0.steps = 0"):
        validate(dataclasses.replace(given, stages=[Stage("only", 0)]))
    with pytest.raises(SceneError, match="body = 'ball': expected a list of tables"):
        validate(dataclasses.replace(given, bodies="ball"))
    with pytest.raises(SceneError, match="soil.held = 1"):
        validate(dataclasses.replace(given, soil=Soil(Material(relative_density=38), held=1)))
    with pytest.raises(SceneError, match="load_scene"):
        validate("demos/anchor.toml")


def test_dicts_are_read_relative_to_a_folder(path):
    import tomllib

    tables = {"name": "dict", **tomllib.loads(SCENE)}
    assert scene_from_dict(tables, path.parent).bodies[0].geometry.is_file()
    with pytest.raises(SceneError, match="existing file"):
        scene_from_dict(tables, path.parent / "elsewhere")


def test_shipped_geometries_go_by_name(path):
    """In a scene file of any folder, and from Python; a file beside the scene comes first."""
    shipped = validate(from_python("sphere.geo")).bodies[0].geometry
    assert shipped == GEOMETRY / "sphere.geo"
    path.write_text(SCENE.replace("ball.geo", "sphere.geo"))
    assert load_scene(path).bodies[0].geometry == shipped
    own = path.with_name("sphere.geo")
    own.write_text("")
    assert load_scene(path).bodies[0].geometry == own
    path.write_text(SCENE.replace("ball.geo", "folder/box.geo"))
    assert "folder/box.geo: must be an existing file" in refused(path)
    path.write_text(SCENE.replace("ball.geo", "spere.geo"))
    assert "did you mean 'sphere.geo'?" in refused(path) and "hybrid comes with" in refused(path)


def test_a_byte_order_mark_is_left_aside_and_one_override_may_be_a_text(tmp_path):
    path = tmp_path / "marked.toml"
    path.write_bytes(b"\xef\xbb\xbf" + (Path(__file__).parents[2] / "demos" / "slope.toml").read_bytes())
    assert load_scene(path, "time.step=0.5").time.step == 0.5
