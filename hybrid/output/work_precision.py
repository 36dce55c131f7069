"""Error against cost, drawn from what a study recorded: every curve has its label at its end, beside the panel."""

from dataclasses import dataclass

import numpy as np

from hybrid.output.figures import COLOURS, MARKERS
from hybrid.output.panels import panels, stamp_corner

GAP = 0.075     # smallest distance of two labels in heights of the panel


@dataclass(frozen=True)
class Series:
    """A curve: costs and errors of what was done, costs of repeats beyond it as a share, how many settings failed;
    foreign: of another program."""

    label: str
    cost: list
    error: list
    spread: list
    failed: int = 0
    foreign: bool = False


@dataclass(frozen=True)
class Panel:
    """A problem: its name, which error, its curves and the front [(cost, error)]."""

    title: str
    error: str
    series: list
    front: list


def work_precision(path, problems, cost, mark):
    """A Panel for each of the `problems`: error against `cost` (its name), the front in grey behind; `mark` in the
    corner."""
    with panels(path, [problem.title for problem in problems], height=2.3, room=0.2, size=9) as (drawing, places):
        stamp_corner(drawing, mark)
        for panel, axes in zip(problems, places):
            axes.set_xlabel(cost, fontsize=7)
            axes.set_ylabel(panel.error, fontsize=7)
            axes.tick_params(labelsize=6, which="both")
            _draw(axes, panel)
    return path


def _draw(axes, panel):
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_minor_locator().set_params(subs=(2, 5))
        axis.get_minor_formatter().minor_thresholds = 1.5, 1.5      # decades up to which they have numbers
    if panel.front:
        x, y = np.array(panel.front).T
        axes.step(x, y, where="post", color="#cccccc", linewidth=4, solid_capstyle="round", zorder=1)
    ends = []
    for series, look in zip(panel.series, _looks(panel.series)):
        x, y = np.array(series.cost), np.array(series.error)
        order = np.argsort(x, kind="stable")
        x, y, spread = x[order], y[order], np.array(series.spread)[order]
        axes.errorbar(x, y, xerr=np.array([0 * x, x * spread]), label=series.label, markersize=3, elinewidth=0.6, **look)
        label = series.label + f" ({series.failed} failed)" * bool(series.failed)
        ends.append((label, look["color"], (x[-1], y[-1]) if len(x) else None))
    _widen(axes)
    _label(axes, ends)


def _looks(series):
    """Colour, marker and line of each curve: the default is black, other programs are dotted."""
    others = iter(zip(COLOURS * 2, MARKERS * 2))
    for one in series:
        if one.label == "default":
            yield {"color": "black", "marker": "o", "linewidth": 1.8, "zorder": 4}
            continue
        colour, marker = next(others)
        yield {"color": colour, "marker": marker, "linewidth": 0.8, "zorder": 3} | (
            {"linestyle": ":", "markerfacecolor": "white"} if one.foreign else {})


def _widen(axes):
    """Let both axes span a decade at least, for ticks to have numbers."""
    for limits, setting in ((axes.get_xlim(), axes.set_xlim), (axes.get_ylim(), axes.set_ylim)):
        middle, half = np.sqrt(limits[0] * limits[1]), max(np.sqrt(limits[1] / limits[0]), 3.3)
        setting(middle / half, middle * half)


def _label(axes, ends):
    """Write (label, colour, end of the curve or None) beside the panel, each as near to the height of its end as the
    others allow, with a thin line from the end to it."""
    low, high = np.log(axes.get_ylim())
    heights = [(np.log(end[1]) - low) / (high - low) if end else 1.0 for _, _, end in ends]
    for (label, colour, end), height in zip(ends, _apart(heights)):
        if end:
            axes.annotate("", xy=end, xytext=(1.02, height), textcoords="axes fraction", zorder=2,
                          arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.4, "alpha": 0.7})
        axes.text(1.03, height, label, transform=axes.transAxes, color=colour, fontsize=6, va="center",
                  fontweight="bold" if colour == "black" else "normal")


def _apart(heights):
    """Heights moved until neighbours are GAP or more apart and the highest is at most 1."""
    order, moved = np.argsort(heights, kind="stable"), np.array(heights, float)
    for below, above in zip(order, order[1:]):
        moved[above] = max(moved[above], moved[below] + GAP)
    moved[order[-1:]] = np.minimum(moved[order[-1:]], 1.0)
    for above, below in zip(order[::-1], order[-2::-1]):
        moved[below] = min(moved[below], moved[above] - GAP)
    return moved
