"""Figures from the history and pictures of soil and bodies."""

import logging
import os
from ctypes.util import find_library
from dataclasses import replace

import numpy as np
import pytest
from fake_run import FakeScene, FakeSimulation, Output

from hybrid.output import figures, history, pictures
from hybrid.output.trajectory import _horizontal, rolled, trajectory


def test_figures_are_drawn_from_the_history_alone(tmp_path):
    FakeSimulation().run([history.History(tmp_path)])
    for path in (trajectory(tmp_path, 0.1), figures.tension(tmp_path),
                 figures.tension(tmp_path, tmp_path / "drag.pdf", against="distance")):
        assert path.stat().st_size > 5000
    turned = rolled(history.read_history(tmp_path), "anchor", "y")
    np.testing.assert_allclose(turned, np.degrees(0.02 * np.arange(1, 7)), atol=1e-10)


def test_motion_beside_a_cell_is_drawn(tmp_path, monkeypatch):
    """Axes span a ten-thousandth of one at least."""
    spans = []
    monkeypatch.setattr("hybrid.output.trajectory._limits_at_least", lambda limits, set_limits, span: spans.append(span))
    FakeSimulation().run([history.History(tmp_path)])
    trajectory(tmp_path, 0.02)
    assert spans == pytest.approx([2e-6, 2e-6])


@pytest.mark.parametrize("axis", ["x", "y"])
def test_rotation_counts_full_turns(axis):
    angle = np.linspace(0, 20, 200)
    columns = {f"b_q{part}": np.sin(angle / 2) * (part == axis) for part in "xyz"} | {"b_qw": np.cos(angle / 2)}
    np.testing.assert_allclose(rolled(columns, "b", axis), np.degrees(angle))


@pytest.mark.parametrize("way, expected", [((1.0, 0.2, 0.5), ("x", False)), ((0.2, 1.0, 0.5), ("y", False)),
                                           ((0.0, 0.0, 0.5), ("x", True)), ((1e-9, 2e-9, 0.0), ("x", True))])
def test_trajectory_is_drawn_along_the_way_or_against_time(way, expected):
    columns = {f"b_{axis}_m": np.linspace(0.0, length, 5) for axis, length in zip("xyz", way)}
    assert _horizontal(columns, ["b"], 1e-5) == expected


def test_comparison_of_two_quantities(tmp_path):
    time = np.linspace(0.01, 1, 100)
    values = [(k * time**2, k * time) for k in (1, 2)]
    curves = [figures.Curve(f"$\\mu = {k}$", time, pair, pair) for k, pair in enumerate(values)]
    assert figures.comparison(tmp_path / "rolling.png", curves).stat().st_size > 5000


def test_errors_against_the_step_in_one_or_two_panels(tmp_path):
    steps = 0.1 / 2.0 ** np.arange(3)
    curves = {name: [(steps, steps**order), (steps / 2, steps**order)] for name, order in (("a", 1), ("b", 2))}
    for count in (1, 2):
        one = {name: pairs[:count] for name, pairs in curves.items()}
        path = figures.convergence(tmp_path / f"{count}.png", one, ("here", "there")[:count], "error [m]")
        assert path.stat().st_size > 5000


def test_colour_limit_is_round_and_never_zero():
    assert pictures.colour_limit(np.array([0.0, -0.23]), np.zeros(0), 0.1) == pytest.approx(0.3)
    assert pictures.colour_limit(np.zeros(5), np.full(3, -3.4), 0.1) == 4
    assert pictures.colour_limit(np.zeros(5), np.zeros(0), 0.1) == pytest.approx(1e-3)
    assert pictures.colour_limit(np.full(5, -2e-10), np.zeros(0), 1e-3) == pytest.approx(2e-10)     # a sample of millimetres


def test_pictures_show_soil_and_cut_body(tmp_path):
    pytest.importorskip("pyvista")
    from matplotlib.image import imread

    simulation = FakeSimulation()
    simulation.run([history.History(tmp_path), pictures.Pictures(tmp_path)])
    if not (tmp_path / "soil_step_002.png").exists():
        assert find_library("EGL") is None, "set-up installs it, so the drawing itself has failed"
        pytest.skip("no off-screen OpenGL on this machine")
    image = imread(tmp_path / "soil_step_002.png")[:, :, :3]
    assert image.shape[1] > 1500
    red, blue = image[:, :, 0] - image[:, :, 2] > 0.3, image[:, :, 2] - image[:, :, 0] > 0.3
    assert red.mean() > 0.005 and blue.mean() > 0.005
    assert (tmp_path / "trajectory.png").exists() and (tmp_path / "line_tension.png").exists()


def rendered(path, simulation):
    """Whether a picture of a simulation has been drawn."""
    return pictures.Drawing(path, pictures.scene_arrays(simulation, simulation.initial_bodies), "").collect()


def test_missing_renderer_is_a_warning_not_an_end(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(pictures.sys, "executable", "/bin/false")
    with caplog.at_level(logging.WARNING):
        assert rendered(tmp_path / "a.png", FakeSimulation()) is False
    assert "no picture a.png" in caplog.text and "apt install" in caplog.text
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def child(tmp_path, monkeypatch):
    """Puts a shell script in place of the drawing process; returns the empty folder of temporary files. The script
    gets what to draw as $3, where to as $4 and the caption as $5."""
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(pictures.tempfile, "tempdir", str(temporary))

    def script(text):
        path = tmp_path / "child"
        path.write_text("#!/bin/sh\n" + text)
        path.chmod(0o755)
        monkeypatch.setattr(pictures.sys, "executable", str(path))
        return temporary

    return script


@pytest.mark.parametrize("outcome", ["completed", "interrupted", "failed"])
def test_run_goes_on_while_a_picture_is_drawn(tmp_path, child, outcome):
    """The child ends only once the step after the picture has been accepted."""
    go, out = tmp_path / "go", tmp_path / "out"
    temporary = child(f'for i in $(seq 200); do [ -e {go} ] && break; sleep 0.05; done\n'
                      f'[ -e {go} ] && printf "%s" "$5" > "$4"')

    class Goes:
        start = finish = lambda self, *_: None

        def accepted(self, record, simulation):
            assert not (out / "soil_step_002.png").exists()
            if record.step == 5:
                go.touch()

    FakeSimulation().run([pictures.Pictures(out), Goes()], until=5, outcome=outcome)
    assert (out / "soil_step_002.png").read_text() == "drag: step 2, time 0.16 s"
    assert list(temporary.iterdir()) == [] and len(list(out.iterdir())) == 1


def test_pictures_are_drawn_one_at_a_time(tmp_path, child):
    lock = tmp_path / "lock"
    child(f'mkdir {lock} || exit 1\nsleep 0.1\nrmdir {lock}\nprintf "%s" "$5" > "$4"')
    scene = replace(FakeScene(), output=Output(pictures=(1, 2, 3)))
    FakeSimulation(scene).run([pictures.Pictures(tmp_path / "out")])
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [f"soil_step_00{n}.png" for n in (1, 2, 3)]


def test_a_failing_child_is_tried_with_other_settings(tmp_path, child, caplog):
    temporary = child('[ -z "$VTK_DEFAULT_OPENGL_WINDOW" ] && printf x > "$4"')
    assert rendered(tmp_path / "out" / "a.png", FakeSimulation()) is True
    assert not caplog.text and list(temporary.iterdir()) == []


def test_a_child_that_fails_twice_is_quoted(tmp_path, child, caplog):
    temporary = child('echo "date (0.1s) | ERR| no display" >&2; exit 1')
    assert rendered(tmp_path / "a.png", FakeSimulation()) is False
    assert "no picture a.png: no display; try" in caplog.text and list(temporary.iterdir()) == []


def test_a_child_without_end_is_stopped(tmp_path, child, caplog, monkeypatch):
    monkeypatch.setattr(pictures, "TIME_LIMIT", 0.2)
    temporary = child(f'echo $$ > {tmp_path / "id"}; exec sleep 60')
    assert rendered(tmp_path / "a.png", FakeSimulation()) is False
    assert "no picture a.png" in caplog.text and "timed out" in caplog.text and list(temporary.iterdir()) == []
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "id").read_text()), 0)
