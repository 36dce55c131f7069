"""What is modelled: one frozen dataclass per table of a scene file. SI units, angles in degrees, z upwards.

A scene file (TOML) and these classes correspond one to one; None in Python is a key left out of a file. The tables are
[grid.x], [grid.y], [grid.z], [grid.faces], [soil], [soil.material], [[soil.layer]], [soil.layer.material], [[body]],
[body.parameters], [body.pull], [[joint]], [[contact]], [time], [[stage]], [[stage.motion]], [[stage.load]], [accuracy],
[solver] and [output]. demos/scene-reference.md has all keys on one page. Files are read in `hybrid.scene.file` and
checked in `hybrid.scene.check`; nothing here computes.
"""

from typing import Literal

from hybrid.scene.body import Body, Freedom, Pull, Vector
from hybrid.scene.grid import Axis, Condition, Faces, Grid
from hybrid.scene.joint import Contact, Joint
from hybrid.scene.soil import Law, Layer, Material, Soil
from hybrid.scene.stage import Load, Motion, Stage
from hybrid.scene.table import key, table

__all__ = ["Axis", "Body", "Condition", "Contact", "Faces", "Freedom", "Grid", "Joint", "Law", "Layer", "Load",
           "Material", "Motion", "Output",
           "Pull", "Scene", "Soil", "Solver", "Stage", "Target", "Time", "Vector"]


@table
class Time:
    """The outer step and the scheme of time integration."""

    step: float = key("duration of an outer step", "s", above=0, remedy="for example 0.04",
                      also=("dt", "time_step", "timestep"))
    scheme: Literal["newmark", "generalised-alpha", "energy-momentum"] | None = key(
        "Newmark's; generalised alpha, of second order with damping of high frequencies; or Newmark's (1/4, 1/2) with "
        "rotations that conserve energy and angular momentum", default=None)
    beta: float | None = key("β of newmark; left out: 1/4. Stable for β >= γ/2 >= 1/4, whatever the step", "-",
                             default=None)
    gamma: float | None = key("γ of newmark; left out: 1/2, which damps nothing. First order for γ > 1/2", "-",
                              default=None)
    spectral_radius: float | None = key(
        "share of the highest frequencies that remains after a step of generalised-alpha; left out: 0, and 0.5 of bodies "
        "near nothing that they could touch", "-",
        default=None, at_least=0, at_most=1, remedy="0 removes high frequencies in one step, 1 damps nothing")
    inertia: bool = key("false: quasi-static, no inertia of soil or body", default=True)
    smallest: float | None = key("increment below which a run stops; left out: a 64th of the outer step, with "
                                 "`accuracy` a 4096th", "s", default=None, above=0, remedy="leave it out for step/64")
    accuracy: float | None = key(
        "tolerance of adaptive time stepping: estimated position error per outer step, in units of the smallest cell; "
        "increments are at most an outer step. Left out: an increment is cut only on failure", "-", default=None,
        above=0, at_most=1, remedy="1e-3 is usual")


@table
class Solver:
    """Newton's method and the linear systems inside it."""

    tolerance: float = key("tolerance of the residual, relative to the forces acting", "-", default=1e-4,
                           at_least=1e-14, below=1, remedy="1e-4 is usual")
    linear: Literal["auto", "direct"] = key(
        "auto: GMRES with the cheapest of its preconditioners, or a direct factor where that costs less or they fail, "
        "and the factor fits in memory, by what is counted in the run; direct: a direct factor always, as a reference",
        default="auto")
    linear_tolerance: float = key("relative tolerance of the Krylov method", "-", default=1e-3, at_least=1e-14, below=1,
                                  remedy="1e-3 is usual")
    tangent_tolerance: float = key(
        "change of a point's stress and tangent within an increment, relative to Young's modulus times the root of the "
        "residual, up to which the tangent is not assembled again; 0: always", "-",
        default=1e-2, at_least=0, below=1, remedy="0 switches it off")
    line_search: bool = key("where full Newton updates make no progress, backtrack from those that leave more than 80 % of "
                            "the residual, as long as that lowers it", default=True)


@table
class Output:
    """What is written, counted in outer steps."""

    every: int = key("steps between two VTK frames; 0: none", "-", default=5, at_least=0, remedy="0 writes none")
    pictures: tuple[int, ...] = key("steps of the last stage, from 1, after which a picture is drawn; any beyond its "
                                    "last are ignored", "-", default=(), at_least=1, remedy="leave out step 0")
    checkpoint: int = key("steps between two checkpoints; 0: none", "-", default=10, at_least=0, remedy="0 writes none")


@table
class Target:
    """A target error: cells and options are those that reached it in a similar problem of the study of precision."""

    like: str = key("name of that problem: column, manufactured, cantilever, platen or footing")
    error: float = key("largest error of that problem (`hybrid.scene.accuracy`)", "-", above=0, below=1,
                       remedy="0.02 is 2 %")
    length: float = key(
        "length of this scene that corresponds to that problem's: height of a column, wave length, depth of a beam, "
        "edge of a pressed cube, half the width of a footing", "m", above=0,
        remedy="measure that length in this scene, across which the problem counts its cells")


@table(kw_only=True)
class Scene:
    """Everything a run needs."""

    name: str = key("label of the run; in a file left out: the file's name", in_file=False)
    grid: Grid = key("background grid")
    soil: Soil = key("the deformable body")
    bodies: tuple[Body, ...] = key("the rigid bodies", default=(), name="body")
    joints: tuple[Joint, ...] = key("joints of bodies", default=(), name="joint")
    contacts: tuple[Contact, ...] = key("contacts of bodies with one another that differ from the others", default=(),
                                        name="contact")
    time: Time = key("step and scheme of time integration")
    stages: tuple[Stage, ...] = key("periods of time, one after the other; at least one", name="stage")
    gravity: Vector = key("acceleration of gravity", "m/s²", default=(0.0, 0.0, -9.81))
    method: Literal["default", "published"] = key(
        'of the keys whose default is decided: "published" gives them the values of the published method (corners of '
        "domains against triangles, plain penalty, Newmark's scheme without damping, no F-bar, no ghost penalty)",
        default="default")
    accuracy: Literal["draft", "standard", "reference"] | Target | None = key(
        "cells, steps and tolerances of a draft or of a reference instead of those given, or those that reached a "
        'target, as { like = "footing", error = 0.1, length = 1.0 } (`hybrid.scene.accuracy`)', default=None)
    solver: Solver = key("Newton's method and linear solver", default=Solver())
    output: Output = key("what is written", default=Output())

    @property
    def joined(self):
        """Names of the bodies in joints."""
        return {name for joint in self.joints for name in joint.bodies}

    def step_of(self, stage):
        """Length [s] of the outer steps of a stage."""
        return stage.step or self.time.step
