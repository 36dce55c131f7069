"""Figures of studies, drawn from made-up records: what is in their panels."""

from contextlib import contextmanager

import numpy as np
import pytest

from hybrid.output import failure_map, figures, panels, scatter, work_precision
from hybrid.output.failure_map import COLOURS, LABELS, Map, draw_one_parameter_maps, draw_two_parameter_maps
from hybrid.output.scatter import Cloud
from hybrid.output.work_precision import Panel, Series

PANELS = [
    Panel("column", "stress error", [
        Series("default", [1.0, 10.0], [0.1, 0.01], [0.0, 0.1]),
        Series("fine", [20.0, 2.0], [0.02, 0.2], [0.0, 0.0], 1),
        Series("other program", [5.0], [0.3], [0.0], foreign=True)], [(1.0, 0.1), (10.0, 0.01)]),
    *(Panel(name, "error", [Series("default", [1.0], [0.1], [0.0])], []) for name in ("wave", "footing"))]
LINE = Map("apex", ("cohesion",), {
    "plain": {(0.0,): "silent", (10.0,): "right"}, "remedy": {(10.0,): "reported"}}, "plain")
PLANE = Map("cuts", ("share", "ghost"), {"plain": {(0.1, 0.0): "degraded", (0.1, 1e5): "right", (0.2, 0.0): "silent"}},
            "plain")


@pytest.fixture
def drawn(monkeypatch):
    """Figures of the modules, kept when they are written."""
    kept, figure = [], figures.figure

    @contextmanager
    def keeping(*args, **values):
        with figure(*args, **values) as drawing:
            yield drawing
            kept.append(drawing)

    for module in (failure_map, figures, panels):
        monkeypatch.setattr(module, "figure", keeping)
    return kept


def test_error_against_cost(drawn, tmp_path):
    path = work_precision.work_precision(tmp_path / "time.png", PANELS, "seconds", "a machine")
    assert path.read_bytes().startswith(b"\x89PNG") and len(drawn[0].axes) == 4
    first, *_, unused = drawn[0].axes
    assert first.get_xscale() == first.get_yscale() == "log" and not unused.axison
    assert (first.get_title(loc="left"), first.get_xlabel(), first.get_ylabel()) == (
        "(a) column", "seconds", "stress error")
    labels = {text.get_text(): text.get_position()[1] for text in first.texts if text.get_text()}
    assert set(labels) == {"default", "fine (1 failed)", "other program"}
    assert labels["default"] < labels["fine (1 failed)"] < labels["other program"] <= 1.0   # as their last errors
    curves = {bars.get_label(): bars.lines[0] for bars in first.containers}
    assert curves["fine"].get_xdata().tolist() == [2.0, 20.0]       # in the order of their costs
    assert curves["other program"].get_linestyle() == ":" != curves["default"].get_linestyle()


@pytest.mark.parametrize("ending, label", [
    ("tension_N", "line tension [N]"), ("tension_whole_N", "line tension, whole body [N]")])
def test_axis_of_tension_names_the_whole_body_only_where_half_is_modelled(drawn, tmp_path, monkeypatch, ending, label):
    columns = dict.fromkeys(("time_s", "stage", "wholesale_x_m", "wholesale_y_m", "wholesale_tension_N"), np.arange(3.0))
    monkeypatch.setattr(figures, "read_history", lambda folder: columns | {f"wholesale_{ending}": np.arange(3.0)})
    monkeypatch.setattr(figures, "stage_starts", lambda history: [])
    figures.tension(tmp_path)
    assert drawn[0].axes[0].get_ylabel() == label


def test_labels_keep_apart_and_in_the_panel():
    moved = work_precision._apart([0.5, 0.5, 1.0, 0.99, 0.1])
    assert np.argsort(moved, kind="stable").tolist() == [4, 0, 1, 3, 2] and moved.max() == 1.0 and moved[4] == 0.1
    assert (np.diff(np.sort(moved)) > work_precision.GAP - 1e-12).all()


def test_map_over_one_parameter(drawn, tmp_path):
    assert draw_one_parameter_maps(tmp_path / "atlas.png", [LINE], "a machine").is_file()
    axes, unused = drawn[0].axes
    assert [text.get_text() for text in axes.get_yticklabels()] == ["plain", "remedy"]
    assert [text.get_fontweight() for text in axes.get_yticklabels()] == ["bold", "normal"]
    assert [text.get_text() for text in axes.get_xticklabels()] == ["0", "10"] and not unused.axison
    shown = axes.images[0].get_array()
    for (row, column), kind in {(0, 0): "silent", (0, 1): "right", (1, 1): "reported"}.items():
        assert shown[row, column].tolist() == failure_map._colour(COLOURS[kind])
    assert shown[1, 0].tolist() == [255, 255, 255]      # not tried
    crosses, = (line for line in axes.lines if line.get_marker() == "x")
    assert np.transpose(crosses.get_data()).tolist() == [[0.0, 0.0]]
    assert [text.get_text() for text in drawn[0].legends[0].get_texts()] == list(LABELS.values())


def test_map_over_two_parameters(drawn, tmp_path):
    assert draw_two_parameter_maps(tmp_path / "maps.png", [PLANE], "a machine").is_file()
    axes, = drawn[0].axes
    assert axes.get_title(loc="left") == "(a) cuts: plain (default)"
    assert [text.get_text() for text in axes.get_yticklabels()] == ["0", "1e5"]
    assert axes.images[0].get_array().shape == (2, 2, 3)


def test_dots_beyond_the_panel_are_drawn_at_its_edge(drawn, tmp_path):
    cloud = Cloud("sphere", "slope", "error", [10.0, 20.0, 30.0, 40.0], [0.1, -0.4, 50.0, -90.0], [0.0, 0.3, 0.6, 1.0],
                  [55.0], 0.5)
    assert scatter.scatter(tmp_path / "rides.png", [cloud] * 3, "mu", "a machine").is_file()
    first, *_, unused, bar = drawn[0].axes
    dots, above, below = (part.get_offsets() for part in first.collections[-3:])
    assert dots[:, 1].tolist() == [0.1, -0.4] and first.get_ylim() == (-5.0, 5.0)
    assert (above[:, 0], above[0, 1] > 4, below[:, 0], below[0, 1] < -4) == ([30.0], True, [40.0], True)
    assert first.lines[-1].get_xdata().tolist() == [55.0] and not unused.axison and bar.get_ylabel() == "mu"
