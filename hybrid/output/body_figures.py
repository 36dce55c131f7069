"""Figures of the soil's action on bodies: resistance to what drives them, stress on parts of surfaces, lines through
soil."""

from pathlib import Path

import numpy as np

from hybrid.output.figures import COLOURS, COLUMN, PAGE, figure, stage_starts
from hybrid.output.history import body_names, force_column, read_history
from hybrid.runtime.units import force_unit

SEEN = 0.05     # of the area of a part: less of it seen against the way counts as along the way
FELT = 1e-3     # of the largest stress on a part: parts with less are not drawn


def resistance(folder, initial, path=None):
    """Force of the soil against every driven translation, against the way driven in the last stage; of the whole body
    where half of it is modelled; from history.csv.

    initial: {body: (3,) [m] at the start of the run}. Writes resistance.png in `folder` unless `path` is given, and returns
    the path; None where no body is driven.
    """
    history, path = read_history(folder), Path(path or Path(folder) / "resistance.png")
    first, curves = stage_starts(history)[-1], {}
    for name in body_names(history):
        for axis, way in driven_ways(history, name, initial[name]):
            column = force_column(history, f"{name}_contact_f{axis}")
            curves[f"{name} along {axis}" + ", whole body" * column.endswith("_whole_N")] = (
                np.abs(way), -np.sign(way[-1]) * history[column][first:])
    if not curves:
        return None
    scale, unit = force_unit(max(np.abs(force).max() for _, force in curves.values()))
    with figure(path) as drawing:
        axes = drawing.subplots()
        for (label, (way, force)), colour in zip(curves.items(), COLOURS * len(curves)):
            axes.plot(way, force / scale, color=colour, label=label)
        axes.margins(x=0.02)
        axes.set_xlabel(f"way in stage '{history['stage'][-1]}' [m]")
        axes.set_ylabel(f"resistance of the soil [{unit}]")
        axes.legend()
    return path


def driven_ways(history, name, initial):
    """Yields (axis, way (steps,) [m] since the last stage began, at its steps) of each translation of body `name` that is
    driven. initial: (3,) [m] of the body at the start of the run."""
    first = stage_starts(history)[-1]
    for axis, start in zip("xyz", initial):
        position = history[f"{name}_{axis}_m"]
        way = position[first:] - (position[first - 1] if first else start)
        if f"{name}_drive_{axis}_J" in history and abs(way[-1]) > 0.0:
            yield axis, way


def parts(folder, initial, areas, path=None):
    """Mean stress on every named part of driven bodies against the way driven in the last stage, one panel a part, as the
    tip resistance and the sleeve friction of a cone (of a body driven down against the depth); from history.csv.

    initial: as of `resistance`; areas: {body: {part: (area [m²], area [m²] seen by what moves along {"x": (down, up), "y":
    ..., "z": ...})}} of the whole. The force along the way is that over the area seen against it, of a part along the way
    over its own area. Parts with less than FELT of the largest stress are left out. Writes parts.png in `folder` unless
    `path` is given, and returns the path; None where no driven body has parts.
    """
    history, path = read_history(folder), Path(path or Path(folder) / "parts.png")
    curves = [curve for name, own in areas.items()
              for curve in _part_curves(history, name, initial[name], own)]
    largest = max((np.abs(stress).max() for _, _, _, stress in curves), default=0.0)
    curves = [curve for curve in curves if largest and np.abs(curve[3]).max() > FELT * largest]
    if not curves:
        return None
    with figure(path, PAGE if len(curves) > 1 else COLUMN) as drawing:
        for axes, (label, down, way, stress) in zip(drawing.subplots(1, len(curves), squeeze=False)[0], curves):
            scale, unit = force_unit(np.abs(stress).max())
            names = f"way in stage '{history['stage'][-1]}' [m]", f"force over area [{unit.replace('N', 'Pa')}]"
            values = way, stress / scale
            axes.plot(*(values[::-1] if down else values))
            axes.set_xlabel(names[down])
            axes.set_ylabel("way down [m]" if down else names[1])
            axes.set_title(label, fontsize=8)
            if down:
                axes.set_ylim(way[-1], 0.0)
    return path


def _part_curves(history, name, initial, own):
    """Yields (label, whether driven down, way [m], stress [Pa]) of the parts of body `name`; initial: (3,) [m] of it; own:
    {part: areas}."""
    first = stage_starts(history)[-1]
    for axis, way in driven_ways(history, name, initial):
        for part, (area, across) in own.items():
            force = history[force_column(history, f"{name}_contact_{part.replace(' ', '_')}_f{axis}")][first:]
            front = across[axis][int(way[-1] > 0.0)]
            area, how = (front, "across") if front > SEEN * area else (area, "along")
            if area:
                down = axis == "z" and bool(way[-1] < 0.0)
                yield f"{name}: {part}, {area:.3g} m² {how}", down, np.abs(way), -np.sign(way[-1]) * force / area


def line_in_soil(folder, shapes, path=None):
    """Lines that cut through soil, one after the other in rows: their shape, and the tension and the angle at the shackle by
    the pull at the mudline; from history.csv.

    shapes: {body: [(label, (n, 2) distance from the shackle and height [m])]}. Writes line_in_soil.png in `folder` unless
    `path` is given, and returns the path; None without lines.
    """
    if not shapes:
        return None
    history, path = read_history(folder), Path(path or Path(folder) / "line_in_soil.png")
    with figure(path, PAGE, 0.72 * COLUMN * len(shapes)) as drawing:
        for (name, curves), row in zip(shapes.items(), drawing.subplots(len(shapes), 3, squeeze=False)):
            pull, tension = (history[force_column(history, f"{name}_{q}")] for q in ("mudline_pull", "tension"))
            scale, unit = force_unit(pull.max())
            for label, curve in curves:
                row[0].plot(*curve.T, label=label)
            row[0].set_xlabel("distance from the shackle [m]")
            row[0].set_ylabel("height [m]")
            row[0].set_title(name, fontsize=8)
            row[0].legend()
            row[1].plot(pull / scale, tension / scale)
            row[1].set_ylabel(f"tension at the shackle [{unit}]")
            row[2].plot(pull / scale, history[f"{name}_shackle_angle_deg"])
            row[2].set_ylabel("angle at the shackle [°]")
            for axes in row[1:]:
                axes.set_xlabel(f"pull at the mudline [{unit}]")
                axes.set_ylim(bottom=0.0)
    return path
