"""checkpoint.npz: every bit comes back, another scene is refused, an interrupted write costs nothing."""

import errno
from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest
from fake_run import FakeScene, FakeSimulation, Output, Soil, Stage

from hybrid.output import atomic, checkpoint, checkpoint_file


def assert_same(left, right):
    for item in fields(left):
        a, b = getattr(left, item.name), getattr(right, item.name)
        assert (a is None) == (b is None)
        if a is not None:
            a, b = np.asarray(a), np.asarray(b)
            assert a.dtype == b.dtype and a.tobytes() == b.tobytes()


def test_checkpoint_returns_every_bit(tmp_path):
    simulation = FakeSimulation()
    for step in (0, 5):
        state = simulation.state_at(step)
        checkpoint.save(tmp_path / "c.npz", state, extra={"dt": 0.1 / 3, "stage": "drag"})
        back = checkpoint.load(tmp_path / "c.npz")
        assert (back.time, back.step, back.work) == (state.time, state.step, state.work)
        assert_same(back.points, state.points)
        assert_same(back.bodies[0], state.bodies[0])
        assert_same(back.contacts[0], state.contacts[0])
        assert checkpoint.read_extra(tmp_path / "c.npz") == {"dt": 0.1 / 3, "stage": "drag"}


def test_checkpoint_refuses_another_scene_and_names_the_difference(tmp_path):
    simulation, path = FakeSimulation(), tmp_path / "c.npz"
    checkpoint.save(path, simulation.state, simulation.scene)
    longer = FakeScene(stages=(Stage("settle", 2), Stage("drag", 9)), output=Output(every=1))
    assert checkpoint.load(path, longer).step == 0
    with pytest.raises(checkpoint.CheckpointError, match=r"soil\.young: checkpoint 2.*\.0, scene 1.*\.0"):
        checkpoint.load(path, FakeScene(soil=Soil(young=1e7)))
    with pytest.raises(checkpoint.CheckpointError, match=r"stages\.0\.steps"):
        checkpoint.load(path, FakeScene(stages=(Stage("settle", 3), Stage("drag", 4))))


def test_geometry_counts_by_content(tmp_path):
    scenes = []
    for name, text in (("a", "Box"), ("b", "Box"), ("c", "Sphere")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "body.geo").write_text(text)
        scenes.append(SimpleNamespace(bodies=[SimpleNamespace(geometry=tmp_path / name / "body.geo")]))
    first, moved, other = map(checkpoint.fingerprint, scenes)
    assert first == moved != other
    (tmp_path / "a" / "body.geo").write_text('Merge "part.stl";')
    (tmp_path / "a" / "part.stl").write_text("solid")
    before = checkpoint.fingerprint(scenes[0])
    (tmp_path / "a" / "part.stl").write_text("other")
    assert checkpoint.fingerprint(scenes[0]) != before, "the files that it reads count too"


def test_broken_checkpoint_is_refused(tmp_path):
    with pytest.raises(checkpoint.CheckpointError, match="no run to resume"):
        checkpoint.load(tmp_path / "none.npz")
    (tmp_path / "bad.npz").write_bytes(b"PK\x03\x04 half a file")
    with pytest.raises(checkpoint.CheckpointError, match="not a readable checkpoint"):
        checkpoint.load(tmp_path / "bad.npz")


def test_a_checkpoint_that_finds_no_room_leaves_the_last_one(tmp_path, monkeypatch):
    def half(file, arrays):
        file.write(b"PK\x03\x04 half a file")
        raise OSError(errno.ENOSPC, "No space left on device")

    simulation, path = FakeSimulation(), tmp_path / "c.npz"
    checkpoint.save(path, simulation.state_at(2))
    checkpoint.reserve(path)
    assert (tmp_path / ".c.npz.partial").stat().st_size > 1.25 * path.stat().st_size
    with monkeypatch.context() as patch, pytest.raises(OSError):
        patch.setattr(checkpoint_file, "_write", half)
        checkpoint.save(path, simulation.state_at(4))
    assert checkpoint.load(path).step == 2
    checkpoint.save(path, simulation.state_at(4))
    assert checkpoint.load(path).step == 4 and [p.name for p in tmp_path.iterdir()] == ["c.npz"]


def test_a_checkpoint_is_written_every_ten_minutes_too(tmp_path, monkeypatch):
    """Steps of four minutes: a checkpoint after every third."""
    clock = iter(range(0, 10**6, 240))
    monkeypatch.setattr(checkpoint, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    saved, simulation = [], FakeSimulation(FakeScene(output=Output(checkpoint=100)))
    save = checkpoint.save
    monkeypatch.setattr(checkpoint, "save", lambda path, state, *rest: (saved.append(state.step), save(path, state, *rest)))
    simulation.run([checkpoint.Checkpoints(tmp_path)])
    assert saved[0] == 0 and 1 < saved[1] <= 3 and saved[-1] == 6


def test_interrupted_write_keeps_the_old_file(tmp_path):
    (tmp_path / "f").write_text("old")
    with pytest.raises(KeyboardInterrupt), atomic(tmp_path / "f") as partial:
        partial.write_text("half")
        raise KeyboardInterrupt
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]


def test_checkpoints_are_saved_every_so_often_and_at_the_end(tmp_path):
    simulation = FakeSimulation()
    simulation.run([observer := checkpoint.Checkpoints(tmp_path)], until=5, outcome="interrupted")
    assert checkpoint.load(tmp_path / "checkpoint.npz", simulation.scene).step == 5
    (tmp_path / "checkpoint.npz").unlink()      # with its folder, say: written again though that step had been saved
    observer.finish({}, simulation)
    assert checkpoint.load(tmp_path / "checkpoint.npz", simulation.scene).step == 5
    FakeSimulation(FakeScene(output=Output(checkpoint=0))).run([checkpoint.Checkpoints(tmp_path / "none")])
    assert not (tmp_path / "none").exists()


def test_the_last_stage_may_become_longer_unless_its_gravity_changes_over_it():
    """It would then be another share of gravity at once."""
    def longer(**gravity):
        last = [SimpleNamespace(steps=steps, **gravity) for steps in (8, 16)]
        return [checkpoint.fingerprint(FakeScene(stages=(Stage("lie", 2), one))) for one in last]

    short, long = longer()
    assert short == long
    short, long = longer(gravity=(1.0, 3.0))
    assert short != long


def test_a_geometry_that_is_edited_while_a_run_computes_is_another_one(tmp_path, monkeypatch):
    """What checkpoints say of the scene is read once, when the run starts."""
    read = iter([{"scene": "1"}, {"scene": "2"}])
    monkeypatch.setattr(checkpoint, "_of_scene", lambda scene: next(read) | {"settings": "{}"})
    FakeSimulation().run([checkpoint.Checkpoints(tmp_path)])
    with np.load(tmp_path / checkpoint.NAME) as saved:
        assert str(saved["scene"]) == "1"
