"""A target error as a scene's `accuracy`: the cheapest settings of a problem alike that were recorded to reach it.

    size = L / n,  p_f = (p_f L)* / L       n cells across the length L of the scene that stands for the problem's

(p_f L)* is the problem's: springs of ε_N = p_f E A overlap by p / (p_f E) under a pressure p, p / (E p_f L) of L. What
is set besides are options of soil, solver and bodies, and only those that a scene leaves at their defaults. Steps stay
the scene's own. The size becomes the next smaller one whose cells fill an axis and end where the soil does.
"""

import difflib
from dataclasses import MISSING, dataclass, field, fields, replace
from math import ceil

from hybrid.runtime.errors import SceneError


@dataclass(frozen=True)
class Settings:
    """What reached an error [-]: a setting in words, cells across the length, values of tables that are no defaults;
    body.penalty is p_f times the length [-]."""

    error: float
    setting: str
    cells: float
    soil: dict = field(default_factory=dict)
    solver: dict = field(default_factory=dict)
    body: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Reference:
    """A problem that scenes may resemble: what its length is, in words, and Settings, the cheapest first."""

    length: str
    settings: tuple


def apply_target(scene, problems):
    """(Scene with the settings of its Target, texts of what was set); problems: {name: Likeness}.

    Raises SceneError for a problem that is none of them, an error below all recorded, and cells given one by one.
    """
    target = scene.accuracy
    found = cheapest(target, problems)
    size = target.length / found.cells
    grid = replace(scene.grid, **{name: _fitted(scene, name, size) for name in "xyz"})
    soil, solver = taken("soil", scene.soil, found.soil), taken("solver", scene.solver, found.solver)
    springs = {name: value / target.length if name == "penalty" else value for name, value in found.body.items()}
    bodies = [taken(f"body.{i}", body, springs) for i, body in enumerate(scene.bodies)]
    changed = replace(scene, accuracy=None, grid=grid, soil=soil[0], solver=solver[0],
                      bodies=tuple(body for body, _ in bodies))
    told = [f"error {found.error:.2g} of {target.like} ({found.setting}): {found.cells:g} cells in its "
            f"{problems[target.like].length}, here {target.length:g} m", _sizes(grid, size)]
    told += [text for _, texts in (soil, solver, *bodies) for text in texts]
    return changed, told


def cheapest(target, problems):
    """Settings of a Target. Raises SceneError."""
    if target.like not in problems:
        near = difflib.get_close_matches(target.like, problems, 1, 0.5)
        raise SceneError(f"accuracy.like = {target.like!r}: unknown problem" + "".join(
            f" (did you mean {name!r}?)" for name in near) + f"; valid: {', '.join(problems)}")
    settings = problems[target.like].settings
    for found in settings:
        if found.error <= target.error:
            return found
    least = min(settings, key=lambda s: s.error)
    raise SceneError(f"accuracy.error = {target.error:g}: must be at least {least.error:.3g}, the smallest recorded of "
                     f"{target.like!r}, by {least.setting!r}; ask for no less, or give grid sizes instead of accuracy")


def taken(key, table, values):
    """(`table` with the `values` of which it has the defaults, texts of what was set and what was kept)."""
    own, texts = {}, []
    defaults = {f.name: f.default for f in fields(table)}
    for name, value in values.items():
        given = getattr(table, name)
        assert defaults[name] is not MISSING
        if given == defaults[name]:
            own[name] = value
            texts += [f"{key}.{name} = {_shown(value)}"] * (value != given)
        else:
            texts.append(f"{key}.{name} = {_shown(given)} kept")
    return replace(table, **own), texts


def _shown(value):
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)


def _sizes(grid, size):
    """Text of the size asked for and of axes that have another."""
    own = {name: getattr(grid, name).size for name in "xyz" if not getattr(grid, name).collapsed}
    others = [f"{name} {other:.4g} m" for name, other in own.items() if abs(other / size - 1) > 1e-6]
    return f"h = {size:.4g} m" + f", fitted to the axes: {', '.join(others)}" * bool(others)


def _fitted(scene, name, size):
    """The axis with the largest size of at most `size` [m] whose cells fill it and end where the soil does."""
    axis, number = getattr(scene.grid, name), "xyz".index(name)
    if axis.collapsed:
        return axis
    if axis.nodes is not None:
        raise SceneError(f"grid.{name}.nodes: accuracy cannot change cells that are given one by one; give "
                         f"grid.{name}.size, or leave accuracy out")
    (start, end), block = axis.fine or (axis.start, axis.end), 2**axis.doublings if axis.travels else 1
    ends = [corner[number] for corner in (scene.soil.lower, scene.soil.upper) if corner]
    ends += [scene.soil.top] * (name == "z" and scene.soil.top is not None)
    inside = [(place - start) / (end - start) for place in ends if start < place < end]
    first = ceil((end - start) / (size * block) - 1e-9) * block
    counts = range(first, 8 * first + 100 * block, block)
    fits = (n for n in counts if all(abs(share * n - round(share * n)) < 1e-6 for share in inside))
    return replace(axis, size=(end - start) / next(fits, first))
