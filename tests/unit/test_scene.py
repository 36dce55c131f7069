"""Scene files: what is read, what is refused, and that each refusal says what to do."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from hybrid.errors import SceneError
from hybrid.scene import Axis, Body, Grid, Material, Pull, Scene, Soil, Stage, Time
from hybrid.scene_file import load_scene, scene_from_dict, toml_value, validate

DEMOS = Path(__file__).parents[2] / "demos"

SCENE = """
[grid.x]
start = 0
end = 4
size = 0.5
fine = [1, 2]
[grid.y]
nodes = [0, 1, 2.5]
[grid.z]
start = -2.0
end = 1.0
size = 0.5
[grid.faces]
z_min = "fixed"
[soil]
top = 0.0
[soil.material]
relative_density = 38
[[body]]
name = "ball"
geometry = "ball.geo"
density = 7850
held = ["y", "rx", "rz"]
[body.parameters]
radius = 1
[body.pull]
point = "eye"
velocity = [0.5, 0, 0]
stiffness = 1e6
length = 10
[time]
step = 0.04
[[stage]]
name = "settle"
steps = 5
pull = false
[[stage]]
name = "drag"
steps = 10
"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "ball.geo").write_text("// only has to exist")
    file = tmp_path / "small.toml"
    file.write_text(SCENE)
    return file


@pytest.fixture
def scene(path):
    return load_scene(path)


def refused(path, *overrides):
    """Message of the SceneError that the overrides cause, without the file name it must start with."""
    with pytest.raises(SceneError) as error:
        load_scene(path, overrides)
    head, _, message = str(error.value).partition(": ")
    assert head == str(path)
    return message


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
    ("grid=3", ["a table (x, y, z, faces)"]),
    ("stage=3", ["a list of tables"]),
    ("time=[]", ["a table"]),
    ("time.step=2024-01-01", ["a number"]),
])
def test_wrong_types_name_key_value_and_what_was_expected(path, override, words):
    message = refused(path, override)
    assert all(word in message for word in words), message


@pytest.mark.parametrize("override, words", [
    ("time.step", ["key.path=value"]),
    ("=3", ["key.path=value"]),
    ("a..b=3", ["key.path=value"]),
    ("body.friction=3", ["list of 1", "body.0.friction"]),
    ("body.1.friction=3", ["1 in it"]),
    ("time.step.x=3", ["time.step = 0.04 is a value"]),
])
def test_malformed_overrides(path, override, words):
    message = refused(path, override)
    assert all(word in message for word in words), message


@pytest.mark.parametrize("override, words", [
    ("grid.x.growth=1", ["grid.x.growth = 1", "(1, 2]"]),
    ("grid.x.growth=2.5", ["(1, 2]"]),
    ("grid.x.fine=[-1, 2]", ["grid.x.fine = [-1, 2]", "[0, 4]"]),
    ("grid.x.fine=[2, 1]", ["grid.x.fine"]),
    ("grid.x.end=0", ["above start = 0"]),
    ("grid.x.size=0", ["grid.x.size", "positive"]),
    ("grid.x.collapsed=true", ["fine and collapsed"]),
    ("grid.y.nodes=[0, 2, 1]", ["increasing"]),
    ("grid.y.nodes=[]", ["increasing"]),
    ("grid.y.end=7", ["nodes give the extent"]),
    ("soil.top=2", ["soil.top = 2", "at most 1"]),
    ("soil.lower=[-1, 0, -2]", ["soil.lower", "inside the grid"]),
    ("soil.upper=[0, 1, 0]", ["soil.lower", "along each axis"]),
    ("soil.points_per_axis=0", ["from 1 to 10"]),
    ("soil.k0=0", ["soil.k0", "positive"]),
    ("soil.material.relative_density=0", ["(0, 100] %"]),
    ("soil.material.poisson=0.5", ["poisson = 0.5", "below 0.5"]),
    ("soil.material.friction_angle=90", ["90 degrees"]),
    ("soil.material.cohesion=-1", ["at least 0"]),
    ("body.0.geometry=none.geo", ["none.geo", "existing file", "relative to the scene file"]),
    ("body.0.density=0", ["body.0.density", "kg/m³"]),
    ("body.0.friction=-0.1", ["body.0.friction = -0.1", "at least 0"]),
    ("body.0.penalty=0", ["positive"]),
    ("body.0.tangential=0", ["positive"]),
    ("body.0.rotation=[0, 0, 0, 30]", ["axis other than zero"]),
    ("body.0.velocity=[0, 1, 0]", ["held y"]),
    ("body.0.spin=[0, 1, 1]", ["held rz"]),
    ("body.0.name=a/b", ["plain file name"]),
    ("body.0.pull.stiffness=0", ["N/m"]),
    ("body.0.pull.length=-1", ["positive"]),
    ("body.0.pull.velocity=[0, 0, 0]", ["direction"]),
    ("body.0.pull.direction=[0, 0, 0]", ["other than zero"]),
    ("time.step=0", ["time.step = 0", "positive"]),
    ("time.gamma=0.4", ["0.5 to 1"]),
    ("time.beta=0.2", ["gamma/2 = 0.25"]),
    ("time.gamma=1", ["gamma/2 = 0.5"]),
    ("stage.0.gamma=1", ["stage.0.beta = 0.25", "gamma/2 = 0.5"]),
    ("time.spectral_radius=0.8", ["left out with scheme = 'newmark'", "scheme = 'generalised-alpha'"]),
    ("time.scheme=generalized-alpha", ["did you mean 'generalised-alpha'", "valid: newmark"]),
    ("time.smallest=1", ["at most step = 0.04"]),
    ("stage=[]", ["at least one", "[[stage]]"]),
    ("stage.0.steps=0", ["stage.0.steps = 0", "at least 1"]),
    ("stage.0.step=-1", ["positive"]),
    ("stage.1.name=settle", ["different"]),
    ("solver.tolerance=0", ["1e-14"]),
    ("solver.iterations=0", ["at least 1"]),
    ("output.every=-1", ["at least 0"]),
    ("output.pictures=[0]", ["from 1"]),
])
def test_ranges_have_limit_and_remedy(path, override, words):
    message = refused(path, override)
    assert all(word in message for word in words), message
    assert "; " in message  # what follows is the remedy


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


def test_a_stage_may_have_a_pair_of_newmark_whatever_the_scheme(path):
    pair = ["stage.0.beta=0.5625", "stage.0.gamma=1"]
    for scheme in ("newmark", "generalised-alpha", "energy-momentum"):
        assert load_scene(path, [f"time.scheme={scheme}", *pair]).stages[0].gamma == 1.0


def test_all_faults_are_told_at_once(path):
    message = refused(path, "time.beta=0.1", "stage.0.steps=0", "body.0.friction=-1")
    assert "3 faults" in message
    assert all(key in message for key in ("time.beta", "stage.0.steps", "body.0.friction"))


@pytest.mark.parametrize("given, absent", [
    ({"law": "hencky"}, "poisson, density, young"),
    ({"law": "hencky", "young": 1e6, "poisson": 0.2, "density": 1e3}, None),
    ({"law": "hencky", "reference_young": 1e6, "poisson": 0.2, "density": 1e3}, "stiffness_exponent"),
    ({"young": 1e6, "poisson": 0.2, "density": 1e3, "cohesion": 0.0}, "friction_angle, dilation_angle"),
])
def test_without_the_sand_preset_the_law_needs_its_parameters(scene, given, absent):
    changed = dataclasses.replace(scene, soil=Soil(Material(**given), top=0.0))
    if absent is None:
        validate(changed)
        return
    with pytest.raises(SceneError, match=f"soil.material: missing {absent} for law .*relative_density"):
        validate(changed)


@pytest.mark.parametrize("change, words", [
    ({"young": 1e6, "reference_young": 1e6}, "exclude each other"),
    ({"friction_angle": 10.0, "dilation_angle": 20.0}, "at most friction_angle = 10"),
    ({"friction_angle": 0.0, "dilation_angle": 0.0, "cohesion": 0.0}, "no strength"),
])
def test_materials_that_contradict_themselves(scene, change, words):
    with pytest.raises(SceneError, match=words):
        validate(dataclasses.replace(scene, soil=Soil(Material(relative_density=38.0, **change), top=0.0)))


def test_a_quasi_static_scene_has_no_velocities(path):
    assert not load_scene(path, ["time.inertia=false"]).time.inertia
    assert "time.inertia = true" in refused(path, "time.inertia=false", "body.0.velocity=[1, 0, 0]")


def test_points_without_domains_have_no_second_pass(path):
    message = refused(path, "soil.basis=mpm", "body.0.second_pass=0.5")
    assert "body.0.second_pass = 0.5: must be 0 with soil.basis = 'mpm'" in message and "gimp" in message


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


def test_collapsed_axes_need_no_size(path):
    plane = load_scene(path, ["grid.y={start = 0, end = 1, collapsed = true}"])
    assert plane.grid.y.collapsed and plane.grid.y.size is None
    flat = "{start = -2, end = 1, collapsed = true}"
    assert "uncollapsed" in refused(path, *(f"grid.{axis}={flat}" for axis in "xyz"), "soil.top=0.0")


def test_every_field_of_the_scene_is_explained():
    """Each class says what its fields are, with the unit; new fields are not forgotten."""
    import hybrid.scene as module

    documented = [c for c in vars(module).values() if dataclasses.is_dataclass(c)]
    assert len(documented) == 12
    for cls in documented:
        if cls.__name__ in ("Faces", "Grid", "Scene", "Stage"):  # told in a sentence
            continue
        for f in dataclasses.fields(cls):
            assert f.name in cls.__doc__, f"{cls.__name__}.{f.name}"
