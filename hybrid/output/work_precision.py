"""Error against cost, drawn from what a study recorded."""

from dataclasses import dataclass

import numpy as np

from hybrid.output.figures import COLOURS, MARKERS, PAGE, figure


@dataclass(frozen=True)
class Series:
    """A curve: costs and errors of what was done, relative spread of the costs, how many settings failed; foreign: of
    another program."""

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


def work_precision(path, panels, cost, mark):
    """Panels two abreast of error against `cost` (its name), the front in grey behind; `mark` in the corner."""
    rows = (len(panels) + 1) // 2
    with figure(path, PAGE, 2.45 * rows + 0.2) as drawing:
        drawing.supxlabel(mark, fontsize=5, x=0.99, ha="right", color="#777777")
        for letter, panel, axes in zip("abcdefghijkl", panels, np.ravel(drawing.subplots(rows, 2, squeeze=False))):
            axes.set_title(f"({letter}) {panel.title}", loc="left", fontsize=9)
            axes.set_xlabel(cost, fontsize=7)
            axes.set_ylabel(panel.error, fontsize=7)
            axes.tick_params(labelsize=6, which="both")
            _draw(axes, panel)
        for axes in drawing.axes[len(panels):]:
            axes.set_axis_off()
    return path


def _draw(axes, panel):
    axes.set_xscale("log")
    axes.set_yscale("log")
    if panel.front:
        x, y = np.array(panel.front).T
        axes.step(x, y, where="post", color="#cccccc", linewidth=4, solid_capstyle="round", zorder=1)
    others = failed = 0
    for series in panel.series:
        own = series.label == "default"
        label = series.label + f" ({series.failed} failed)" * bool(series.failed)
        look = {"color": "black", "marker": "o", "linewidth": 1.6, "zorder": 4} if own else {
            "color": COLOURS[others % len(COLOURS)], "marker": MARKERS[others // len(COLOURS) % len(MARKERS)],
            "linewidth": 0.8, "zorder": 3}
        others += not own
        if series.foreign:
            look |= {"linestyle": ":", "markerfacecolor": "white"}
        x, y = np.array(series.cost), np.array(series.error)
        order = np.argsort(x, kind="stable")
        axes.errorbar(x[order], y[order], xerr=(x * np.array(series.spread))[order], label=label, markersize=3,
                      elinewidth=0.6, **look)
        if series.failed:
            failed += 1
            axes.plot([1 - 0.035 * failed], [0.96], "x", transform=axes.transAxes, color=look["color"], markersize=4)
    axes.legend(fontsize=5, loc="upper left", bbox_to_anchor=(1.0, 1.03), handlelength=1.2, labelspacing=0.3)
