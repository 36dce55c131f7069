"""Values that no scene has: endless, huge, nested or unreadable ones are refused by key and reason, before any work."""

import math
import os

import pytest
from small_scene import SCENE, refused

from hybrid.grid.axes import cells_that_grow, graded_nodes
from hybrid.runtime import memory
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Solver, Time
from hybrid.scene.file import load_scene
from hybrid.setup import size
from hybrid.setup.build import build
from hybrid.soil.size import growing_memory, sizes
from hybrid.study.scenes import box, collapsed, soil_scene

DIGITS = "9" * 5000


@pytest.mark.parametrize("override, words", [
    ("time.step=nan", "time.step = nan: must be a finite number"),
    ("grid.x.end=inf", "grid.x.end = inf: must be a finite number"),
    ("gravity=[0, 0, -1e300]", "gravity.2 = -1e+300: must be from -1e+30 to 1e+30"),
    ("body.0.density=1e-300", "body.0.density = 1e-300: must be at least 1e-30 kg/m³"),
    ("stage.0.steps=10000000000", "stage.0.steps = 10000000000: must be from -1e+09 to 1e+09"),
    (f"stage.0.steps={DIGITS}", "a number, a date or a name cannot be read"),
    (f"stage.0.steps=0x{'f' * 5000}", "stage.0.steps = a whole number of 6021 digits"),
    (f"time.step=0x{'f' * 5000}", "time.step = a whole number of 6021 digits"),
    (f"grid.x.nodes={'[' * 5000}{']' * 5000}", "lie in one another too deeply"),
    (f"name='{'n' * 300}'", "plain file name of at most 100 bytes"),
    ('body.0.name="a\\u0007b"', "plain file name"),
    ('body.0.geometry="a\\u0000b.geo"', "'a\\x00b.geo': must be the path of a file, but: it has a null character"),
    (f"body.0.geometry='{'g/' * 5000}'", "File name too long"),
    (f"body.{DIGITS}.density=1", "has 1 in it"),
    ("body.0.geometry=/dev/zero", "an existing file"),
])
def test_a_value_is_refused_in_a_line(path, override, words):
    message = refused(path, override)
    assert words in message and len(message) < 600


def test_a_message_ends_however_many_faults_there_are(path):
    message = refused(path, f"body.0.driven={[0.0] * 10000}")
    assert message.startswith("10000 faults\n  - body.0.driven.0 = 0.0: expected one of")
    assert "body.0.driven.19 = 0.0" in message and message.endswith("'rz'\n  - and 9980 more")


@pytest.mark.parametrize("text, words", [
    (f"a = {DIGITS}", "cannot be read (Exceeds the limit"),
    (f"a = {'[' * 10000}", "too deeply"),
    ("a = 2000-99-99", "not valid TOML"),
    ("a = \"\x00\"", "not valid TOML"),
])
def test_a_file_that_cannot_be_read(path, text, words):
    path.write_text(text + "\n" + SCENE)
    assert words in refused(path)


def test_a_path_without_an_end_or_a_file(tmp_path, path):
    circle = tmp_path / "circle.toml"
    circle.symlink_to(circle)
    with pytest.raises(SceneError, match="circle.toml: "):
        load_scene(circle)
    assert "must be the path of a file" in refused(path, f"body.0.geometry={circle}")
    with pytest.raises(SceneError, match="a directory or a device"):
        load_scene("/dev/zero")
    with pytest.raises(SceneError, match="File name too long"):
        load_scene("x" * 5000)
    with pytest.raises(SceneError, match="null"):
        load_scene("a\0b.toml")
    os.truncate(path, 2**30)    # a hole, which takes no space
    assert "1073741824 bytes, limit 16777216" in refused(path)


def test_names_that_make_one_file(path):
    second = '[[body]]\nname = "ball_1"\ngeometry = "ball.geo"\ndensity = 1\n'
    path.write_text(SCENE.replace('name = "ball"', 'name = "ball 1"') + second)
    assert "body.1.name = 'ball_1': must be different from 'ball 1' as the name of a file, 'ball_1'" in refused(path)


# ------------------------------------------------------------------ memory


@pytest.mark.parametrize("axes", [
    {"size": 1e-9}, {"x": Axis(0.0, 1e25, 1e-3)}, {"x": Axis(0.0, 1.0, 1e-12, fine=(0.4, 0.5))},
    {"x": Axis(0.0, 1.0, 1e-9, fine=(0.5, 0.5 + 1e-9), growth=1 + 1e-9)}, {"size": 1e-3, "points_per_axis": 10}])
def test_a_grid_that_does_not_fit_is_refused_before_it_is_made(axes, monkeypatch):
    monkeypatch.setattr(size, "available_memory", lambda: 2**31)
    with pytest.raises(SceneError, match="grid: .* need about .*iB of memory, and 2 GiB are left: choose"):
        build(soil_scene(**axes))


def test_blocks_of_a_grid_that_follows_a_body_count():
    around = {"around": (0.2, 0.2), "window": (0.5, 0.5)}
    endless = Axis(0.0, 8e8, 0.1, **around)
    with pytest.raises(SceneError, match="need about"):
        build(soil_scene([box(0.2, 0.2, 0.2)], x=endless, y=endless, geostatic=True))


@pytest.mark.parametrize("y", [(0.0, 1.2), collapsed()])
def test_the_prediction_is_that_of_the_model(y, monkeypatch):
    """Within a fifth: it does not know which nodes are held."""
    scene = soil_scene(x=(0.0, 2.4), y=y, z=(-1.6, 0.4), fbar=True, solver=Solver())
    needs = []
    monkeypatch.setattr(size, "_refuse", lambda need, *_: needs.append(need))
    simulation = build(scene)
    soil = simulation.model.soil
    model = growing_memory(soil, len(soil.constants), sizes(soil).entries, sizes(soil).unknowns, scene.solver)
    nodes = size.BYTES_PER_NODE * simulation.model.soil.grid.node_count
    assert 1.0 <= (needs[-1] - nodes) / model < 1.2


def test_the_number_of_cells_that_grow():
    """Close to the number that is then made, also where they hardly grow."""
    for growth in (2.0, 1.3, 1.001):
        nodes = graded_nodes(0.0, 10.0, 0.1, (0.0, 1.0), growth)
        assert abs(len(nodes) - 11 - cells_that_grow(9.0, 0.1, growth)) <= 1


def test_what_is_left_is_the_least_of_all_limits(monkeypatch, tmp_path):
    monkeypatch.setattr(memory.resource, "getrlimit", lambda _: (2**40, 2**40))
    assert 0 < memory._own_memory() < 2**40
    for folder, limit, used, idle in ((tmp_path, "max", 7, 0), (tmp_path / "job", "1000", 600, 100)):
        folder.mkdir(exist_ok=True)
        (folder / "memory.max").write_text(limit)
        (folder / "memory.current").write_text(str(used))
        (folder / "memory.stat").write_text(f"anon 1\ninactive_file {idle}\n")
    (tmp_path / "own").write_text("0::/job/inner\n")
    assert memory._group_memory(tmp_path, tmp_path / "own") == 500
    (tmp_path / "own").write_text("0::/\n")
    assert math.isinf(memory._group_memory(tmp_path, tmp_path / "own"))
    for name in ("_machine_memory", "_group_memory", "_own_memory"):
        with monkeypatch.context() as patched:
            patched.setattr(memory, name, lambda: 5)
            assert memory.available_memory() == 5


# ------------------------------------------------------------------ bodies


@pytest.mark.parametrize("place, overlap", [((0.0, 0.0, 0.0), True), ((0.5, 0.5, 0.5), True), ((1.0, 0.0, 0.0), False),
                                            ((0.0, 0.0, 1.2), False), ((0.0, 0.0, 0.01), True)])
def test_bodies_that_overlap(place, overlap, geometry):
    """Two unit cubes: the same place, a corner inside, face to face, apart, and nearly the same place."""
    bodies = [box(1.0, 1.0, 1.0, name="one", position=(1.0, 1.0, 0.6)),
              box(1.0, 1.0, 1.0, name="two", position=tuple(a + b for a, b in zip((1.0, 1.0, 0.6), place)))]
    scene = soil_scene(bodies, x=(0.0, 3.0), y=(0.0, 3.0), z=(-0.4, 3.0), held=True, time=Time(0.01))
    if overlap:
        with pytest.raises(SceneError, match="bodies 'one' and 'two' overlap at the start, by .* or more and about .* "
                                             "m³; move one"):
            build(scene)
    else:
        build(scene)
