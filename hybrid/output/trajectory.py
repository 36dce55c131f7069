"""Figure of the way and the rotation of the bodies."""

from pathlib import Path

import numpy as np

from hybrid.output.figures import COLOURS, COLUMN, figure
from hybrid.output.history import body_names, read_history

FLAT = 0.05             # a horizontal way of less than this share of the vertical one: against time
STILL = 1e-4            # cells of motion that is drawn as none
UNTURNED = 0.1          # [°], the same of a rotation
TURNED = {"x": "y", "y": "x"}   # the axis about which a body rolls that moves along x, y


def trajectory(folder, cell, path=None):
    """Height of every body's centre, and rotation where a body rotates, against the position of the centres along x or y,
    whichever they move more along; against time where they go up and down only; from history.csv.

    Writes trajectory.png in `folder` unless `path` is given, and returns the path. cell: smallest one of the grid [m],
    beside which a motion is drawn as none.
    """
    history, path, still = read_history(folder), Path(path or Path(folder) / "trajectory.png"), STILL * cell
    names = body_names(history)
    axis, upright = _horizontal(history, names, still)
    turns = {name: rolled(history, name, TURNED[axis]) for name in names}
    with figure(path, COLUMN, (1.15 if _any_turn(turns) else 0.75) * COLUMN) as drawing:
        if _any_turn(turns):
            height, turn = drawing.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": (3, 2)})
            turn.set_ylabel(f"rotation about ${TURNED[axis]}$ [°]")
        else:
            height = turn = drawing.subplots()
        for name, colour in zip(names, COLOURS * len(names)):
            along = history["time_s" if upright else f"{name}_{axis}_m"]
            height.plot(along, history[f"{name}_z_m"], color=colour, label=name)
            for end, face in ((0, "white"), (-1, colour)):
                height.plot(along[end], history[f"{name}_z_m"][end], "o", color=colour, markerfacecolor=face)
            if turn is not height:
                turn.plot(along, turns[name], color=colour)
        _limits_at_least(height.get_ylim, height.set_ylim, still)
        _limits_at_least(turn.get_xlim, turn.set_xlim, still)
        height.set_ylabel("height of centre $z$ [m]")
        turn.set_xlabel("time [s]" if upright else f"position of centre ${axis}$ [m]")
        if len(names) > 1:
            height.legend()
        drawing.align_ylabels()
    return path


def _horizontal(history, names, still):
    """(horizontal axis of the figure, whether no body moves along x or y by more than a share of the vertical way),
    apart from `still` [m]."""
    way = {axis: max((np.ptp(history[f"{name}_{axis}_m"]) for name in names), default=0.0) for axis in "xyz"}
    axis = "y" if way["y"] > max(way["x"], still) else "x"
    return axis, way[axis] <= max(FLAT * way["z"], still)


def _any_turn(turns):
    """Whether any body rotates by what is drawn. turns: {body: (steps,) [°]}."""
    return any(np.abs(turn).max(initial=0.0) > UNTURNED for turn in turns.values())


def rolled(history, name, axis):
    """Rotation of body `name` about the axis x or y [°], without jumps, shape (steps,); right-handed.

    Angle of the body's x axis in the x-z plane, or of its y axis in the y-z plane, from the quaternion (w, x, y, z).
    """
    w, x, y, z = (history[f"{name}_q{part}"] for part in "wxyz")
    down, along = (2 * (w * y - x * z), 1 - 2 * (y * y + z * z)) if axis == "y" else (
        2 * (w * x + y * z), 1 - 2 * (x * x + z * z))
    return np.degrees(np.unwrap(np.arctan2(down, along)))


def _limits_at_least(limits, set_limits, span):
    """Keep round-off from being drawn as if it were motion: the axis with these `limits` spans `span` or more."""
    low, high = limits()
    if high - low < span:
        set_limits((low + high - span) / 2, (low + high + span) / 2)
