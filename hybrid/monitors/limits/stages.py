"""Limits of what stages do to bodies: steps of driven bodies, tables of loads and motions."""

import numpy as np

from hybrid.body.table import Table
from hybrid.scene.check_stage import components, velocities
from hybrid.scene.stage import table_rows

# Cells that a driven body may move by in a step, by whether the soil yields. Hertz problems (hybrid.study.random) are
# right on elastic soil with 0.7 of their finest cells.
PER_STEP = {False: 1.0, True: 0.5}
REACHED = 1e-3      # of the largest value of a table: what may be missing from its last row when its stage ends
SHORT, LATE = 0.5, 0.01     # of a step and of a stage: a table that ends so much later ends with its stage
# Share of a mass that the scheme adds to it, in a load that swings so often; a block on soil, shaken at its natural
# frequency in 30 steps a period, 4 %, had 20 % too little after eight periods, 3 % with 60
HEAVIER, SWINGS = 0.03, 2.0
OFF = 0.1           # of the impulse, or the peak, of a load: what may be wrong of it
FINE = 1 / 36       # of a period: a step in which that is less
TIMES = 10000       # of a stage at which a table is looked at


def long_increments(scene, model):
    """Bodies that are driven by more than half a cell a step, a cell on elastic soil: the soil they meet is crushed or
    passed in one increment."""
    if model.soil.held or scene.time.accuracy:
        return
    limit = PER_STEP[bool(model.soil.law.plastic)]
    otherwise = ", or set time.accuracy" if model.scheme.inertia else ""
    for described, body in zip(scene.bodies, model.bodies):
        moved = [(displacement_per_step(scene, stage, described, name) / np.diff(nodes).min(), name, stage)
                   for stage in scene.stages for name, nodes in zip("xyz", model.soil.grid.lines) if len(nodes) > 1]
        cells, name, stage = max(moved, key=lambda one: one[0], default=(0.0, "", None))
        if cells > limit * (1 + 1e-9):
            length = scene.step_of(stage)
            yield (f"{body.name} is driven by {cells:.3g} cells along {name} in each step of stage {stage.name!r}, limit "
                   f"{limit:g}: soil in its way is deformed too much for one increment, so that steps fail, are cut into "
                   f"many, or give a wrong load. Use steps of at most {length * limit / cells:.2g} s (time.step or "
                   f"stage.step, with more stage.steps){otherwise}")


def displacement_per_step(scene, stage, described, name):
    """Largest distance [m], or angle [rad], by which a body is driven in a component in a step of a stage."""
    length = scene.step_of(stage)
    own = [motion for motion in stage.motions if motion.body in (None, described.name) and name in components(motion)]
    if not own:
        driven = name in described.driven and name not in stage.held
        return driven * abs(velocities(described)[name]) * length
    times = length * np.linspace(0.0, stage.steps, min(stage.steps, TIMES) + 1)
    return max(_of_motion(motion, times, length) for motion in own)


def _of_motion(motion, times, length):
    if motion.component is None:
        return 0.0
    if motion.velocity is not None:
        return length * np.abs(_values(motion.velocity, 2, times)).max()
    moved = np.abs(np.diff(_values(motion.displacement, 2, times), axis=0)).max()
    degrees = np.pi / 180 if motion.component.startswith("r") else 1.0
    return degrees * moved * length / (times[1] - times[0])


def _values(given, columns, times):
    """Values (t, c) of a table of a scene at `times` (t,) [s]."""
    return Table.of(table_rows(given, columns, "stage"), 0.0).at(times)


def unreached_ends(scene, model):
    """Tables of loads and motions that end after their stage does, or begin after it, so that their last value is never
    reached."""
    for s, stage in enumerate(scene.stages):
        end = stage.steps * scene.step_of(stage)
        for path, given, columns, unit in _tables(f"stage.{s}", stage):
            table = Table.of(table_rows(given, columns, path), 0.0)
            first = table.values[0] if path.endswith("displacement") else 0.0     # to which displacements are relative
            reached, last = table.at(end) - first, table.values[-1] - first
            all_but_reached = np.abs(reached - last).max() <= REACHED * np.abs(table.values - first).max()
            slack = min(SHORT * scene.step_of(stage), LATE * end)
            if table.times[-1] <= end + slack or all_but_reached:
                continue
            if table.times[0] >= end * (1 - 1e-9):
                remedy = f"let them begin at 0, and not at {table.times[0]:g} s, when the stage is over"
            else:
                steps = int(np.ceil(stage.steps * table.times[-1] / end - 1e-9))
                remedy = f"set stage.{s}.steps to {steps}, or end the table earlier"
            yield (f"{path} ends at {table.times[-1]:g} s, and its stage {stage.name!r} at {end:g} s: it reaches "
                   f"{_shown(reached)} {unit}, not its last row, {_shown(last)} {unit}. Times count from the start of "
                   f"the stage: {remedy}")


def early_rows(scene, model):
    """Tables of loads and motions with rows before the start of their stage, which are passed over."""
    for s, stage in enumerate(scene.stages):
        for path, given, columns, unit in _tables(f"stage.{s}", stage):
            table = Table.of(table_rows(given, columns, path), 0.0)
            begins, first = table.at(0.0), table.values[0]
            if table.times[0] < 0.0 and np.abs(begins - first).max() > REACHED * np.abs(table.values).max():
                yield (f"{path} begins at {table.times[0]:g} s, limit 0: times count from the start of the stage "
                       f"{stage.name!r}, where it has {_shown(begins)} {unit} already, not its first row, {_shown(first)} "
                       f"{unit}, and what comes before is left out. Let its times begin at 0")


def missed_changes(scene, model):
    """Loads that change between the ends of steps, at which alone they act, so that their impulse, or without inertia their
    peak, is another one."""
    for s, stage in enumerate(scene.stages):
        length = scene.step_of(stage)
        ends = length * np.arange(stage.steps + 1)
        for path, given, columns, unit in _tables(f"stage.{s}", stage):
            table = Table.of(table_rows(given, columns, path), 0.0)
            inside = table.times[(table.times > 0.0) & (table.times < ends[-1])]
            if ".load." not in path or not len(inside):
                continue
            fine, values = np.union1d(inside, ends), table.at(ends)
            sizes = np.linalg.norm(table.at(fine), axis=1)
            if model.scheme.inertia:
                acts, given = (each.integral(0.0, ends[-1]) for each in (Table(ends, values), table))
                what = f"an impulse, in {unit} s,"
                off = np.linalg.norm(acts - given) / max(Table(fine, sizes[:, None]).integral(0.0, ends[-1])[0], 1e-300)
                acts, given = np.linalg.norm(acts), np.linalg.norm(given)
            else:
                acts, given = np.linalg.norm(values, axis=1).max(), sizes.max()
                what = f"a peak, in {unit},"
                off = 1.0 - acts / max(given, 1e-300)
            if off > OFF:
                yield (f"{path} changes between the ends of steps of {length:.3g} s, at which alone loads act: it has "
                       f"{what} of {acts:.4g} there, and of {given:.4g} by its rows. Use steps that end at its rows, of at "
                       f"most {np.diff(np.union1d(inside, [0.0, ends[-1]])).min():.2g} s")


def coarse_swings(scene, model):
    """Loads that swing in so few steps that the default scheme answers them by too little.

    With ρ∞ = 0 a mass counts as |2 - exp(-ip)| (2 - 2 cos p)/p² times itself for a harmonic of p = ω Δt: a free block moves
    by 12 % too little with 15.7 steps in a period, one on a column of soil, near its resonance, by 41 %, and 11 % with 31.
    """
    if not model.scheme.auxiliary or model.scheme.spectral_radius > 0.0 or scene.time.accuracy:
        return
    for s, stage in enumerate(scene.stages):
        for path, swings, steps, _ in swinging_tables(scene, s):
            phase = 2.0 * np.pi * swings / steps
            if ".load." not in path:
                continue
            heavier = abs(2.0 - np.exp(-1j * phase)) * (2.0 - 2.0 * np.cos(phase)) / phase**2 - 1.0
            if heavier > HEAVIER:
                yield (f"{path} swings with {2.0 * np.pi / phase:.3g} steps in a period: for it the time integration makes "
                       f"masses {heavier:.1%} heavier, limit {HEAVIER:.0%}, so that they move by as much too little, and by "
                       "more near a resonance. Use steps of at most "
                       f"{FINE * 2.0 * np.pi / phase * scene.step_of(stage):.2g} s, or time.spectral_radius = 0.8")


def swinging_tables(scene, s):
    """[(key, number of periods, steps, name of the body or None)] of the loads and motions of the stage with number `s` that
    swing SWINGS times or more."""
    stage, found = scene.stages[s], []
    times = scene.step_of(stage) * np.arange(stage.steps + 1)
    for path, given, columns, _ in _tables(f"stage.{s}", stage):
        values = _values(given, columns, times)
        turns = np.diff(values > values.mean(axis=0), axis=0)
        swings = 0.5 * (turns.sum(axis=0).max(initial=0) - 1)
        if swings >= SWINGS:
            kind, number = path.split(".")[2:4]
            found.append((path, swings, stage.steps, getattr(stage, f"{kind}s")[int(number)].body))
    return found


def _tables(path, stage):
    """(key, given table, columns, unit) of each load and motion of a stage that has one."""
    tables = [(f"load.{i}.{name}", getattr(load, name), 4, unit) for i, load in enumerate(stage.loads)
              for name, unit in (("force", "N"), ("moment", "N m"))]
    for i, motion in enumerate(stage.motions):
        turns = len(motion.component or "") > 1
        for name, unit in (("velocity", "rad/s" if turns else "m/s"), ("displacement", "degrees" if turns else "m")):
            tables.append((f"motion.{i}.{name}", getattr(motion, name), 2, unit))
    return [(f"{path}.{key}", given, *rest) for key, given, *rest in tables if given is not None]


def _shown(values):
    text = ", ".join(f"{value:.4g}" for value in values)
    return f"({text})" if len(values) > 1 else text


LIMITS = (long_increments, unreached_ends, early_rows, missed_changes, coarse_swings)
