"""The folder of results: one run at a time, nothing of worth replaced, nothing of an earlier run taken for this one's."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from small_scene import SCENE

from hybrid.output import checkpoint, run_folder
from hybrid.output.run_folder import RunFolder
from hybrid.runtime.errors import RunFolderError, SceneError
from hybrid.scene.file import load_scene
from hybrid.state import Points, State


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "small.toml"
    (tmp_path / "ball.geo").write_text("")
    path.write_text(SCENE)
    return load_scene(path)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "out"


def computed(folder, scene, steps=3, outcome="completed", seconds=1.0):
    """Leave results of a run behind; `outcome` None: it was killed."""
    with RunFolder(folder, scene) as place:
        place.begin()
        (folder / "history.csv").write_text("step,time_s\n" + "".join(f"{k},{0.1 * k}\n" for k in range(1, steps + 1)))
        for name in ("soil.pvd", "soil_000000.vtu", "body_ball.pvd", "body_ball_000000.vtu", "soil_step_005.png"):
            (folder / name).write_text("old")
        if steps:
            state = State(0.1 * steps, steps, Points(*8 * [[]]), [], [])
            checkpoint.save(folder / checkpoint.NAME, state, scene, run=place.run)
        if outcome:
            (folder / "summary.json").write_text(json.dumps(
                {"run": place.run, "outcome": outcome, "totals": {"seconds": {"solve": seconds}}}))
    return place.run


def started(folder, scene, **options):
    """Names of the files of results with which a run starts."""
    with RunFolder(folder, scene, **options) as place:
        place.begin()
        return sorted(path.name for path in folder.iterdir() if path.name != run_folder.LOCK)


def test_the_same_quick_run_again_starts_from_an_empty_folder(folder, scene):
    computed(folder, scene)
    (folder / "notes.txt").write_text("mine")
    (folder / ".history.csv.partial").write_text("step")
    assert started(folder, scene) == ["notes.txt", "run.json"]


@pytest.mark.parametrize("left, words", [
    ({"outcome": "interrupted"}, "3 steps of this scene, which has not been completed: continue by --resume"),
    ({"outcome": None}, "not been completed"),
    ({"outcome": "failed"}, "not been completed"),
    ({"seconds": 7200.0}, "120 minutes of computing: choose another folder by --out"),
])
def test_results_that_cost_something_are_replaced_only_when_asked_for(folder, scene, left, words):
    computed(folder, scene, **left)
    before = sorted(folder.iterdir())
    with pytest.raises(RunFolderError, match=words):
        started(folder, scene)
    assert sorted(folder.iterdir()) == before
    assert started(folder, scene, overwrite=True) == ["run.json"]


def test_another_scene_is_refused_with_what_differs(folder, scene):
    computed(folder, scene)
    other = replace(scene, gravity=(0.0, 0.0, -1.0))
    with pytest.raises(RunFolderError, match=r"3 steps of another scene(.|\n)*gravity.2: folder -9.81, scene -1.0(.|\n)*"
                                             r"--out, or replace them by --overwrite"):
        started(folder, other)
    assert started(folder, other, overwrite=True) == ["run.json"]


def test_a_run_without_a_step_is_replaced_by_any(folder, scene):
    computed(folder, scene, steps=0, outcome="failed")
    assert started(folder, replace(scene, gravity=(0.0, 0.0, -1.0))) == ["run.json"]


def test_results_of_an_unknown_run_are_refused(folder, scene):
    folder.mkdir()
    (folder / "checkpoint.npz").write_text("old")
    with pytest.raises(RunFolderError, match=r"results of an unknown run \(checkpoint.npz, ...\)"):
        started(folder, scene)


def test_a_checkpoint_of_an_earlier_run_is_never_continued(folder, scene, monkeypatch):
    """A run that is killed while it removes old results, just before its first checkpoint, or in between."""
    computed(folder, scene)

    def killed(*_, **__):
        raise SystemExit

    with monkeypatch.context() as patch, pytest.raises(SystemExit):
        patch.setattr(Path, "unlink", killed)
        started(folder, scene)
    assert (folder / "checkpoint.npz").exists()
    with pytest.raises(checkpoint.CheckpointError, match="stopped before its first checkpoint"):
        started(folder, scene, resume=True)
    assert started(folder, replace(scene, gravity=(0.0, 0.0, -1.0))) == ["run.json"]
    with pytest.raises(checkpoint.CheckpointError, match="stopped before its first checkpoint"):
        started(folder, scene, resume=True)


@pytest.mark.parametrize("ending", [SystemExit, KeyboardInterrupt, MemoryError])
def test_a_run_that_is_stopped_while_it_meshes_is_not_continued_from_older_results(folder, scene, ending):
    run = computed(folder, scene)
    with pytest.raises(ending), RunFolder(folder, scene):
        raise ending    # before begin()
    with pytest.raises(checkpoint.CheckpointError,
                       match=r"before its first checkpoint: start it again without --resume; or, "
                                                         r"to continue the earlier run, delete .*\.run\.starting"):
        started(folder, scene, resume=True)
    (folder / run_folder.STARTING).unlink()
    with RunFolder(folder, scene, resume=True) as place:
        assert place.run == run
    with pytest.raises(ending), RunFolder(folder, scene):
        raise ending
    assert started(folder, scene) == ["run.json"]


def test_a_scene_that_is_refused_leaves_the_folder_as_it_was(folder, scene):
    computed(folder, scene)
    before = sorted(folder.iterdir())
    with pytest.raises(SceneError), RunFolder(folder, scene):
        raise SceneError("no")
    assert sorted(folder.iterdir()) == before
    assert "checkpoint.npz" in started(folder, scene, resume=True)


def test_a_checkpoint_put_there_by_hand_is_of_another_run(folder, scene, tmp_path):
    computed(folder, scene)
    computed(tmp_path / "other", scene)
    os.replace(tmp_path / "other" / "checkpoint.npz", folder / "checkpoint.npz")
    with pytest.raises(checkpoint.CheckpointError, match="is of run .*, the folder of run"):
        started(folder, scene, resume=True)


def test_a_resumed_run_keeps_its_name_also_where_run_json_is_lost(folder, scene):
    run = computed(folder, scene, outcome=None)
    for lose in (False, True):
        if lose:
            (folder / "run.json").unlink()
        with RunFolder(folder, scene, resume=True) as place:
            place.begin()
            assert place.run == run == json.loads((folder / "run.json").read_text())["run"]
        assert (folder / "history.csv").exists()


def test_resume_and_overwrite_exclude_each_other(folder, scene):
    with pytest.raises(RunFolderError, match="give one of them"):
        RunFolder(folder, scene, resume=True, overwrite=True)


@pytest.mark.parametrize("options", [{}, {"overwrite": True}, {"resume": True}])
def test_two_runs_at_once_are_refused(folder, scene, options, monkeypatch):
    monkeypatch.setattr(run_folder, "ENDING", 0.0)
    with RunFolder(folder, scene), pytest.raises(RunFolderError, match=rf"another run computes .*process {os.getpid()} on "):
        started(folder, scene, **options)
    assert not folder.exists()      # neither has written anything


def test_the_lock_of_a_killed_run_is_free(folder, scene, monkeypatch):
    monkeypatch.setattr(run_folder, "ENDING", 0.0)
    code = ("import fcntl, os, sys\nfile = open(sys.argv[1], 'a')\nfcntl.flock(file, fcntl.LOCK_EX)\n"
            "print('locked', flush=True)\nsys.stdin.read()")
    folder.mkdir()
    with subprocess.Popen([sys.executable, "-c", code, folder / run_folder.LOCK], stdin=-1, stdout=-1) as other:
        assert other.stdout.readline() == b"locked\n"
        with pytest.raises(RunFolderError, match="another run computes"):
            started(folder, scene)
        other.kill()
        other.wait()
    assert started(folder, scene) == ["run.json"]


def test_a_run_that_is_just_ending_is_waited_for(folder, scene):
    """A process that is killed, or whose other ranks are, frees its lock only once it is gone."""
    code = ("import fcntl, sys, time\nfile = open(sys.argv[1], 'a')\nfcntl.flock(file, fcntl.LOCK_EX)\n"
            "print('locked', flush=True)\ntime.sleep(0.5)")
    folder.mkdir()
    with subprocess.Popen([sys.executable, "-c", code, folder / run_folder.LOCK], stdout=-1) as other:
        assert other.stdout.readline() == b"locked\n"
        assert started(folder, scene) == ["run.json"]


@pytest.mark.parametrize("there", ["file", "folder below a file"])
def test_a_folder_that_cannot_be_made_is_refused(tmp_path, scene, there):
    (tmp_path / "f").write_text("")
    with pytest.raises(RunFolderError, match="results cannot be written there .*; choose another folder by --out"):
        started(tmp_path / "f" / ("" if there == "file" else "o"), scene)
