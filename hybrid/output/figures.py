"""Figures for a paper, drawn from saved records only: line tension, comparison with closed forms.

One style for all: 85 mm (one column) or 170 mm (two columns) wide, 300 dpi, SI units. No global matplotlib
state is touched, so the functions can be called from any script or notebook.
"""

import math
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from hybrid.output import atomic
from hybrid.output.history import body_names, force_column, read_history
from hybrid.runtime.units import force_unit

COLUMN, PAGE = 85 / 25.4, 170 / 25.4  # widths [in]
COLOURS = ("#1f5a94", "#c8553d", "#3a7d44", "#7a4e9c", "#c28f0e", "#4d4d4d")
MARKERS = "osD^vP"

# Blue below, white at zero, red above; the ends are light enough for shading and edges to be visible.
DIVERGING = LinearSegmentedColormap.from_list(
    "blue white red", ["#1b4f9c", "#3f86c4", "#9dc9e4", "#ffffff", "#f7b799", "#d9604c", "#a3132a"]
)

STYLE = {
    "font.family": ["STIXGeneral", "DejaVu Serif"],
    "mathtext.fontset": "stix",
    "font.size": 9,
    "axes.labelsize": 9,
    "axes.linewidth": 0.6,
    "axes.prop_cycle": matplotlib.cycler(color=COLOURS),
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.linewidth": 0.4,
    "grid.color": "#dddddd",
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.6,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "savefig.dpi": 300,
    "figure.dpi": 100,
}


@contextmanager
def figure(path, width=COLUMN, height=None):
    """Figure in the common style, saved to `path` (any format matplotlib knows) when the block ends.

    width, height in inches; height defaults to 0.72 of a column's width.
    """
    with matplotlib.rc_context(STYLE):
        drawing = Figure(figsize=(width, height or 0.72 * COLUMN), constrained_layout=True)
        FigureCanvasAgg(drawing)
        yield drawing
        with atomic(path) as partial:
            drawing.savefig(partial, format=Path(path).suffix[1:] or "png", facecolor="white")


def tension(folder, path=None, against="time"):
    """Line tension of every pulled body against "time" [s] or "distance" [m], of the whole body where half of it is
    modelled; from history.csv.

    Distance is how far the centre has moved horizontally since the last stage began; only that stage is then
    drawn. Writes line_tension.png in `folder` unless `path` is given, and returns the path.
    """
    if against not in ("time", "distance"):
        raise ValueError(f"against = {against!r}: choose 'time' or 'distance'")
    history, path = read_history(folder), Path(path or Path(folder) / "line_tension.png")
    starts = stage_starts(history)
    first = max(0, starts[-1] - 1) if against == "distance" else 0
    history = {column: values[first:] for column, values in history.items()}
    column = {name: force_column(history, f"{name}_tension") for name in body_names(history)}
    pulled = [name for name in column if np.any(history[column[name]])]
    whole = ", whole body" if any(column[name].endswith("_whole_N") for name in pulled) else ""
    largest = max((np.abs(history[column[name]]).max() for name in pulled), default=0.0)
    scale, unit = force_unit(largest)
    with figure(path) as drawing:
        axes = drawing.subplots()
        for name, colour in zip(pulled, COLOURS * len(pulled)):
            x, y = history[f"{name}_x_m"], history[f"{name}_y_m"]
            distance = np.hypot(x - x[0], y - y[0])
            abscissa = history["time_s"] if against == "time" else distance
            axes.plot(abscissa, history[column[name]] / scale, color=colour, label=name)
        axes.set_ylim(bottom=0)
        axes.margins(x=0.02)
        axes.set_xlabel("time [s]" if against == "time" else "drag distance [m]")
        axes.set_ylabel(f"line tension{whole} [{unit}]")
        if against == "time":
            _mark_stages(axes, history)
        if len(pulled) > 1:
            axes.legend()
    return path


@dataclass
class Curve:
    """Two computed histories of one case and their closed forms, for `comparison`.

    values and exact are pairs, one array for each panel; exact_time defaults to time.
    """

    label: str
    time: np.ndarray
    values: tuple
    exact: tuple
    exact_time: np.ndarray | None = None


def comparison(path, curves):
    """Distance and spin over time side by side: computed values as about 12 markers a curve, closed forms as lines.

    curves: list of Curve, one colour and marker each. Returns the path.
    """
    with figure(path, PAGE, 0.8 * COLUMN) as drawing:
        panels = drawing.subplots(1, 2)
        for i, curve in enumerate(curves):
            colour, marker = COLOURS[i % len(COLOURS)], MARKERS[i % len(MARKERS)]
            line_time = curve.time if curve.exact_time is None else curve.exact_time
            every = max(1, len(curve.time) // 12)
            # Staggered starts keep markers of coinciding curves apart.
            shown = slice((i * every // max(1, len(curves))) % every, None, every)
            for panel, value, exact in zip(panels, curve.values, curve.exact):
                panel.plot(line_time, exact, color=colour, linewidth=1.0)
                panel.plot(
                    curve.time[shown], value[shown], marker, color=colour, label=curve.label,
                    markerfacecolor="white", markeredgewidth=0.9,
                )
        for letter, panel, label in zip("ab", panels, ("distance [m]", "spin [rad/s]")):
            panel.set_xlabel("time [s]")
            panel.set_ylabel(label)
            panel.margins(x=0.02)
            panel.set_title(f"({letter})", loc="left", fontsize=9)
        panels[0].plot([], [], color="black", linewidth=1.0, label="analytic")
        panels[0].legend(loc="upper left")
    return Path(path)


def convergence(path, curves, labels, ylabel):
    """Panels side by side of error against step on logarithmic axes, with slopes of orders 1 and 2 in grey.

    curves: {label: [(steps, errors) for each panel]}; labels: what each panel shows. Returns the path.
    """
    with figure(path, PAGE, 0.9 * COLUMN) as drawing:
        panels = drawing.subplots(1, len(labels), sharey=True, squeeze=False)[0]
        for i, (label, pairs) in enumerate(curves.items()):
            # Each curve has smaller markers than the one before, so that coinciding curves are visible.
            for panel, pair in zip(panels, pairs):
                panel.loglog(*pair, MARKERS[i % len(MARKERS)] + "-", color=COLOURS[i % len(COLOURS)], label=label,
                             markerfacecolor="white", markeredgewidth=0.9, markersize=max(2.5, 6.0 - 0.8 * i))
        for letter, panel, label, pairs in zip("abcdef", panels, labels, zip(*curves.values())):
            _draw_slopes(panel, pairs)
            steps = np.unique([step for pair in pairs for step in pair[0]])
            panel.set_xticks(steps, [f"{step:.2g}" for step in steps])
            panel.minorticks_off()
            panel.set_xlabel("step $\\Delta t$ [s]")
            panel.set_title(f"({letter}) {label}", loc="left", fontsize=9)
        panels[0].set_ylabel(ylabel)
        panels[-1].legend(loc="lower right")
    return Path(path)


def _draw_slopes(panel, pairs):
    """Lines of orders 1 and 2 that fan out below the curves, over the first doubling of the step."""
    step, error = (min(np.min(pair[k]) for pair in pairs) for k in (0, 1))
    for order in (1, 2):
        ends = np.array([step, 2 * step]), error / 8 * np.array([1.0, 2.0**order])
        panel.loglog(*ends, color="#888888", linewidth=0.8)
        panel.annotate(str(order), (ends[0][1], ends[1][1]), (3, 0), textcoords="offset points", color="#555555",
                       va="center", fontsize=8)


def picture(path, image, limit, label, caption="", extend="neither", ruler=None):
    """Rendered image over a line with caption and colour bar, 170 mm wide. Returns the path.

    image: (rows, columns, 4), RGB and opacity; limit: the bar runs over [-limit, limit]; extend: "neither",
    "min", "max" or "both" as for a matplotlib colour bar; ruler: (x0, y0, x1, y1, text), a length of the
    model in pixels of the image.
    """
    rows, columns = image.shape[:2]
    foot = 0.62  # height of the line below the image, with room for the ruler's text [in]
    height = PAGE * rows / columns
    with matplotlib.rc_context(STYLE):
        drawing = Figure(figsize=(PAGE, height + foot))
        FigureCanvasAgg(drawing)
        axes = drawing.add_axes((0, foot / (height + foot), 1, height / (height + foot)))
        axes.imshow(image, aspect="auto", interpolation="antialiased")
        # Zero displacement is white, as the paper is: an outline shows where the model ends.
        axes.contour(image[:, :, 3], [127], colors="#404040", linewidths=0.6)
        axes.set_axis_off()
        if ruler:
            _draw_ruler(axes, ruler)
        drawing.text(0.02, 0.35 / (height + foot), caption, ha="left", va="center")
        bar = drawing.add_axes((0.52, 0.3 / (height + foot), 0.45, 0.1 / (height + foot)))
        scale = ScalarMappable(Normalize(-limit, limit), DIVERGING)
        ticks = np.linspace(-limit, limit, 5)
        handle = drawing.colorbar(scale, cax=bar, orientation="horizontal", extend=extend, ticks=ticks)
        handle.outline.set_linewidth(0.5)
        bar.set_xticks(ticks, [_tick(tick, limit) for tick in ticks])
        bar.tick_params(direction="out", length=2, pad=2, top=False)
        drawing.text(0.505, 0.35 / (height + foot), label, ha="right", va="center")
        with atomic(path) as partial:
            drawing.savefig(partial, format=Path(path).suffix[1:] or "png", facecolor="white")
    return Path(path)


def _draw_ruler(axes, ruler):
    x0, y0, x1, y1, text = ruler
    axes.annotate("", (x0, y0), (x1, y1), arrowprops={"arrowstyle": "|-|,widthA=0.25,widthB=0.25",
                                                     "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0})
    angle = math.degrees(math.atan2(y0 - y1, x1 - x0))
    axes.annotate(text, ((x0 + x1) / 2, (y0 + y1) / 2), (0, -3), textcoords="offset points", rotation=angle,
                  ha="center", va="top", fontsize=8)


def _tick(value, limit):
    digits = max(0, 1 - math.floor(math.log10(limit / 2)))
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".") if digits else f"{value:.0f}"
    return "0" if value == 0 else text.replace("-", "\N{MINUS SIGN}")


def stage_starts(history):
    """Row at which each stage begins."""
    stage = history["stage"]
    return [0, *(np.flatnonzero(stage[1:] != stage[:-1]) + 1)]


def _mark_stages(axes, history):
    starts, last, line = stage_starts(history), 0.0, 0
    for i in starts if len(starts) > 1 else []:
        begin = history["time_s"][i - 1] if i else 0.0
        line = line + 1 if 0.0 < begin - last < 0.15 * history["time_s"][-1] else 0   # no room beside the last name
        last = begin
        if i:
            axes.axvline(begin, color="#888888", linewidth=0.7, linestyle=(0, (4, 3)))
        axes.annotate(history["stage"][i], (begin, 1), (3, -3 - 9 * line), xycoords=("data", "axes fraction"),
                      textcoords="offset points", ha="left", va="top", fontsize=8, color="#555555")
