"""What a scene's `accuracy` sets: a level scales cells and steps and sets a tolerance; a target looks settings up in
records.

Level, by name:

    draft       cells and steps twice as large
    standard    cells and steps as given
    reference   cells and steps half as large

and the tolerance of the study of precision, without a share in the error.

Target: the cheapest settings that reached an error in a similar problem of the study of precision,

    size = L / n      p_f = (p_f L)* / L

with n cells across the length L of the scene that corresponds to the problem's. (p_f L)* is the problem's: a spring of
ε_N = p_f E A has the overlap p / (p_f E) under a pressure p, which is p / (E p_f L) of L. A target also sets options of
soil, solver and bodies; steps stay as given. The size is the largest one up to L / n whose cells fill an axis and end
where the soil does.

Both change only values that the scene leaves at their defaults, apart from cells and, of a level, steps. accuracy.json
has the numbers of both, made from the records of the study by `hybrid.study.precision.fit_accuracy`.
"""

import json
from dataclasses import MISSING, dataclass, field, fields, replace
from math import ceil
from pathlib import Path

from hybrid.runtime.errors import SceneError
from hybrid.scene import Solver, Target
from hybrid.scene.grid import cells_between
from hybrid.scene.read import did_you_mean
from hybrid.scene.table import shown

MOST_CELLS = 10**6   # along an axis, up to which a number that fits is looked for
WRITTEN = Path(__file__).with_name("accuracy.json")


@dataclass(frozen=True)
class Level:
    """size, step: factors on cells and steps; tolerance: of [solver]."""

    size: float
    step: float
    tolerance: float

    def __str__(self):
        return f"cells x {self.size:g}, steps x {self.step:g}, tolerance {self.tolerance:.0e}"


@dataclass(frozen=True)
class Settings:
    """Settings that reached an `error` [-]: their name, cells across the length, and values of tables that are not
    defaults; body["penalty"] is p_f times the length [-]."""

    error: float
    setting: str
    cells: float
    soil: dict = field(default_factory=dict)
    solver: dict = field(default_factory=dict)
    body: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Reference:
    """A problem that scenes may resemble: its length, in words, and its Settings, the cheapest first."""

    length: str
    settings: tuple


def levels():
    """{name: Level} as recorded."""
    return {name: Level(**values) for name, values in _written()["levels"].items()}


def problems():
    """{name: Reference} of the problems that a Target may name, as recorded."""
    return {name: Reference(values["length"], tuple(Settings(**row) for row in values["settings"]))
            for name, values in _written()["problems"].items()}


def _written():
    return json.loads(WRITTEN.read_text(encoding="utf-8"))


def apply_accuracy(scene):
    """(Scene without `accuracy`, texts of what that set); the scene itself and no texts without `accuracy`.

    Raises SceneError for cells that are given one by one, and for a Target that no recorded settings reach.
    """
    if scene.accuracy is None:
        return scene, []
    if isinstance(scene.accuracy, Target):
        return apply_target(scene, scene.accuracy, problems())
    level = levels()[scene.accuracy]
    changed = apply_level(scene, level)
    pairs = {name: (getattr(scene.grid, name), getattr(changed.grid, name)) for name in "xyz"}
    asked = {name: level.size * old.size for name, (old, _) in pairs.items() if old.size and not old.collapsed}
    return changed, [str(level) + _fitted_ones(changed.grid, asked)]


# ------------------------------------------------------------------ levels


def apply_level(scene, level):
    """Scene with the cells, steps and tolerance of a Level, and as many frames and checkpoints as it had."""
    axes = {name: _resized(scene, name, level.size) for name in "xyz"}
    stages = tuple(_restepped(stage, scene.time.step, level.step) for stage in scene.stages)
    output = replace(scene.output, every=_counted(scene.output.every, level.step),
                     checkpoint=_counted(scene.output.checkpoint, level.step),
                     pictures=tuple(_counted(step, level.step) for step in scene.output.pictures))
    own = {"tolerance": level.tolerance} if scene.solver.tolerance == Solver().tolerance else {}
    return replace(
        scene, accuracy=None, grid=replace(scene.grid, **axes), stages=stages, output=output,
        time=replace(scene.time, step=scene.time.step * level.step), solver=replace(scene.solver, **own))


def _resized(scene, name, factor):
    """The axis with cells `factor` times as large, or the largest smaller ones that fill it and end where the soil does."""
    axis = getattr(scene.grid, name)
    if factor == 1 or axis.nodes is None and axis.size is None:
        return axis
    return _fitted(scene, name, factor * axis.size if axis.nodes is None else None)


def _restepped(stage, step, factor):
    """The stage, as long as before, with steps about `factor` times as long; step: [s] of the scene."""
    steps = ceil(stage.steps / factor)
    if steps * factor == stage.steps:
        return replace(stage, steps=steps, step=stage.step and stage.step * factor)
    return replace(stage, steps=steps, step=stage.steps * (stage.step or step) / steps)


def _counted(steps, factor):
    """A count of steps after steps have become `factor` times as long; 0 stays 0."""
    return max(1, round(steps / factor)) if steps else 0


# ------------------------------------------------------------------ targets


def apply_target(scene, target, references):
    """(Scene with the cheapest settings of a Target, texts of what was set and kept); references: {name: Reference}."""
    found = cheapest(target, references)
    size = target.length / found.cells
    grid = replace(scene.grid, **{name: _fitted(scene, name, size) for name in "xyz"})
    soil, soil_texts = replace_defaults("soil", scene.soil, found.soil)
    solver, solver_texts = replace_defaults("solver", scene.solver, found.solver)
    own = {name: value / target.length if name == "penalty" else value for name, value in found.body.items()}
    bodies = [replace_defaults(f"body.{i}", body, own) for i, body in enumerate(scene.bodies)]
    changed = replace(scene, accuracy=None, grid=grid, soil=soil, solver=solver,
                      bodies=tuple(body for body, _ in bodies))
    head = (f"error {found.error:.2g} of {target.like} ({found.setting}): {found.cells:g} cells in its "
            f"{references[target.like].length}, here {target.length:g} m")
    return changed, [head, _sizes(grid, size), *soil_texts, *solver_texts, *(text for _, own in bodies for text in own)]


def cheapest(target, references):
    """Settings of a Target. Raises SceneError for an unknown problem and an error below all recorded ones."""
    if target.like not in references:
        raise SceneError(f"accuracy.like = {target.like!r}: unknown problem{did_you_mean(target.like, references)}; "
                         f"valid: {', '.join(references)}")
    settings = references[target.like].settings
    for found in settings:
        if found.error <= target.error:
            return found
    least = min(settings, key=lambda s: s.error)
    raise SceneError(f"accuracy.error = {target.error:g}: must be at least {least.error:.3g}, the smallest recorded "
                     f"for {target.like!r}, by {least.setting!r}; raise it, or give grid sizes instead of accuracy")


def replace_defaults(path, table, values):
    """(`table` with those of `values` for which it has the default, texts of what was set and what was kept)."""
    own, texts = {}, []
    defaults = {f.name: f.default for f in fields(table)}
    for name, value in values.items():
        given = getattr(table, name)
        assert defaults[name] is not MISSING
        if given == defaults[name]:
            own[name] = value
            texts += [f"{path}.{name} = {_short(value)}"] * (value != given)
        else:
            texts.append(f"{path}.{name} = {_short(given)} kept")
    return replace(table, **own), texts


def _short(value):
    return f"{value:g}" if isinstance(value, float) else shown(value)


def _sizes(grid, size):
    """Text of the size that the target needs, and of axes that got another one."""
    return f"h = {size:.4g} m" + _fitted_ones(grid, {name: size for name in "xyz" if not getattr(grid, name).collapsed})


def _fitted_ones(grid, asked):
    """Text of the axes of a grid whose cells have another size [m] than was `asked` {name: [m]}, empty for none."""
    sizes = {name: getattr(grid, name).size for name in asked}
    others = [f"{name} {size:.4g} m" for name, size in sizes.items() if abs(size / asked[name] - 1) > 1e-6]
    return f", fitted to the axes: {', '.join(others)}" * bool(others)


def _fitted(scene, name, size):
    """The axis with the largest size of at most `size` [m] whose cells fill it and end where the soil does."""
    axis, number = getattr(scene.grid, name), "xyz".index(name)
    if axis.collapsed:
        return axis
    if axis.nodes is not None:
        raise SceneError(f"grid.{name}.nodes: accuracy cannot change cells that are given one by one; give "
                         f'grid.{name}.size, set accuracy = "standard", or leave accuracy out')
    (start, end), block = axis.fine or (axis.start, axis.end), 2**axis.doublings if axis.moves else 1
    ends = [corner[number] for corner in (scene.soil.lower, scene.soil.upper) if corner]
    ends += [scene.soil.top] * (name == "z" and scene.soil.top is not None)
    inside = [(place - start) / (end - start) for place in ends if start < place < end]
    first = cells_between(start, end, size * block) * block
    if first > MOST_CELLS:
        return replace(axis, size=size)     # refused by its size when the grid is built
    counts = range(first, 8 * first + 100 * block, block)
    fits = (n for n in counts if all(abs(share * n - round(share * n)) < 1e-6 for share in inside))
    return replace(axis, size=(end - start) / next(fits, first))
