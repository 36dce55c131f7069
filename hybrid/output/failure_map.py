"""Maps of the outcomes of a failure study: each method over one parameter or two."""

from dataclasses import dataclass
from string import ascii_lowercase
from textwrap import fill

import numpy as np

from hybrid.output.figures import PAGE, figure
from hybrid.output.panels import stamp_corner

# Distinct in grey too: the worse, the darker; silent failures have a cross as well.
COLOURS = {"right": "#cfe8d5", "degraded": "#f2d479", "reported": "#6f9fc8", "silent": "#9c2a1c"}
LABELS = {"right": "right", "degraded": "degraded", "reported": "failed and reported", "silent": "failed silently"}
MISSING = "#ffffff"


@dataclass(frozen=True)
class Map:
    """A failure mode: title, one or two parameters, {method: {setting: kind of outcome}}, and the default method."""

    title: str
    parameters: tuple
    kinds: dict
    default: str


def draw_one_parameter_maps(path, maps, mark):
    """A panel for each mode over one parameter, with a row for each method, in two columns; `mark` in the corner."""
    rows = (len(maps) + 1) // 2
    pairs = [maps[i:i + 2] for i in range(0, len(maps), 2)]
    heights = [max(len(m.kinds) for m in pair) + 2.6 for pair in pairs]
    with figure(path, PAGE, 0.135 * sum(heights) + 0.35) as drawing:
        panels = drawing.subplots(rows, 2, squeeze=False, gridspec_kw={"height_ratios": heights})
        for number, (axes, case) in enumerate(zip(panels.ravel(), maps)):
            settings = list(dict.fromkeys(s for kinds in case.kinds.values() for s in kinds))
            _paint(axes, [[kinds.get(s) for s in settings] for kinds in case.kinds.values()])
            _title(axes, number, case.title)
            axes.set_xticks(range(len(settings)), [_label(s[0]) for s in settings], fontsize=5.5)
            axes.set_xlabel(case.parameters[0], fontsize=6, labelpad=1)
            _methods(axes, case)
        _finish(drawing, panels.ravel()[len(maps):], mark)
    return path


def draw_two_parameter_maps(path, maps, mark):
    """A row for each mode over two parameters, with a panel for each method."""
    columns = max(len(m.kinds) for m in maps)
    with figure(path, PAGE, 1.9 * len(maps) + 0.35) as drawing:
        panels = drawing.subplots(len(maps), columns, squeeze=False)
        unused = []
        for number, (row, case) in enumerate(zip(panels, maps)):
            first, second = (list(dict.fromkeys(s[i] for kinds in case.kinds.values() for s in kinds)) for i in (0, 1))
            for axes, (method, kinds) in zip(row, case.kinds.items()):
                _paint(axes, [[kinds.get((a, b)) for a in first] for b in second])
                text = f"{case.title}: {method}" + " (default)" * (method == case.default)
                _title(axes, number, fill(text, 44))    # titles must not reach the next map
                axes.set_xticks(range(len(first)), [_label(a) for a in first], fontsize=5.5)
                axes.set_yticks(range(len(second)), [_label(b) for b in second], fontsize=5.5)
                axes.set_xlabel(case.parameters[0], fontsize=6, labelpad=1)
                axes.set_ylabel(case.parameters[1], fontsize=6, labelpad=4)
            unused += list(row[len(case.kinds):])
        _finish(drawing, unused, mark)
    return path


def _paint(axes, kinds):
    """Squares of the kinds, a list of rows; None where there was no run."""
    shown = np.array([[_colour(COLOURS.get(kind, MISSING)) for kind in row] for row in kinds], np.uint8)
    axes.imshow(shown, aspect="auto", interpolation="nearest")
    y, x = np.nonzero([[kind == "silent" for kind in row] for row in kinds])
    axes.plot(x, y, "x", color="white", markersize=3, markeredgewidth=0.8)
    for at in np.arange(shown.shape[1] - 1) + 0.5:
        axes.axvline(at, color="white", linewidth=1.2)
    for at in np.arange(shown.shape[0] - 1) + 0.5:
        axes.axhline(at, color="white", linewidth=1.2)
    axes.grid(False)
    axes.tick_params(length=0, pad=2)


def _colour(code):
    """(red, green, blue) of "#rrggbb"."""
    return [int(code[i:i + 2], 16) for i in (1, 3, 5)]


def _methods(axes, case):
    axes.set_yticks(range(len(case.kinds)), list(case.kinds), fontsize=6)
    for label in axes.get_yticklabels():
        label.set_fontweight("bold" if label.get_text() == case.default else "normal")


def _title(axes, number, text):
    letter = ascii_lowercase[number % 26] * (1 + number // 26)
    axes.set_title(f"({letter}) {text}", loc="left", fontsize=7, pad=3)


def _label(value):
    if not isinstance(value, (int, float)):
        return str(value)
    return f"{value:.0e}".replace("+0", "").replace("-0", "-") if abs(value) >= 1e4 else f"{value:g}"


def _finish(drawing, unused, mark):
    for axes in unused:
        axes.set_axis_off()
    drawing.suptitle(" ", fontsize=7)   # room for the legend
    squares = [drawing.axes[0].plot([], [], "s", color=COLOURS[kind], label=LABELS[kind])[0] for kind in COLOURS]
    drawing.legend(handles=squares, loc="upper center", ncol=len(COLOURS), fontsize=6.5)
    stamp_corner(drawing, mark)
