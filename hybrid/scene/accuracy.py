"""What a scene's `accuracy` stands for. A level changes what a scene gives, by what the study of precision recorded:

    draft       cells and steps twice as large, tolerances as loose as they go without a part in the error
    standard    cells and steps as they are given
    reference   cells and steps half as large, tolerances that leave no trace

A Target takes cells and options that reached an error in a problem alike (`hybrid.scene.targets`). accuracy.json has the
numbers of both, made from the records of the study by `hybrid.study.levels`. Values of the solver that a scene gives
itself stay.
"""

import json
from dataclasses import dataclass, replace
from math import ceil
from pathlib import Path

from hybrid.runtime.errors import SceneError
from hybrid.scene import Solver, Target
from hybrid.scene.targets import Reference, Settings, apply_target

WRITTEN = Path(__file__).with_name("accuracy.json")


@dataclass(frozen=True)
class Level:
    """size, step: factors on cells and steps; tolerance, linear_tolerance: of solver."""

    size: float
    step: float
    tolerance: float
    linear_tolerance: float

    def __str__(self):
        return (f"cells x {self.size:g}, steps x {self.step:g}, tolerance {self.tolerance:.0e}, of GMRES "
                f"{self.linear_tolerance:.0e}")


def levels():
    """{name: Level} as recorded."""
    return {name: Level(**values) for name, values in _written()["levels"].items()}


def problems():
    """{name: Likeness} of the problems that a Target may name, as recorded."""
    return {name: Reference(values["length"], tuple(Settings(**row) for row in values["settings"]))
            for name, values in _written()["problems"].items()}


def _written():
    return json.loads(WRITTEN.read_text(encoding="utf-8"))


def apply_level(scene):
    """(Scene without `accuracy`, text or texts of what that stood for): as it was where the scene asks for none.

    Raises SceneError where a level has no say, cells that are given one by one, and for a Target that nothing recorded
    reaches.
    """
    if scene.accuracy is None:
        return scene, ""
    if isinstance(scene.accuracy, Target):
        return apply_target(scene, problems())
    level = levels()[scene.accuracy]
    axes = {name: _resized(f"grid.{name}", getattr(scene.grid, name), level.size) for name in "xyz"}
    stages = tuple(replace(stage, steps=ceil(stage.steps / level.step), step=stage.step and stage.step * level.step)
                   for stage in scene.stages)
    output = replace(scene.output, every=_counted(scene.output.every, level.step),
                     checkpoint=_counted(scene.output.checkpoint, level.step),
                     pictures=tuple(_counted(step, level.step) for step in scene.output.pictures))
    own = {name: getattr(level, name) for name in ("tolerance", "linear_tolerance")
           if getattr(scene.solver, name) == getattr(Solver(), name)}
    return replace(
        scene, accuracy=None, grid=replace(scene.grid, **axes), stages=stages, output=output,
        time=replace(scene.time, step=scene.time.step * level.step), solver=replace(scene.solver, **own)), str(level)


def _resized(key, axis, factor):
    if axis.nodes is not None and factor != 1:
        raise SceneError(f"{key}.nodes: accuracy cannot change cells that are given one by one; give {key}.size, or "
                         'set accuracy = "standard"')
    return axis if axis.size is None else replace(axis, size=axis.size * factor)


def _counted(steps, factor):
    """A count of steps, 0 stays 0."""
    return max(1, round(steps / factor)) if steps else 0
