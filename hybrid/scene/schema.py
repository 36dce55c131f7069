"""What is modelled: one frozen dataclass per table of a scene file. SI units, angles in degrees, z upwards.

A scene file (TOML) and these classes map one to one: the tables are [grid.x], [grid.y], [grid.z],
[grid.faces], [soil], [soil.material], [[soil.layer]], [soil.layer.material], [[body]], [body.parameters], [body.pull],
[time], [[stage]], [accuracy], [solver] and [output].
Reading and checking is done in `hybrid.scene.file`; nothing here computes.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from hybrid.scene.soil import Axis, Condition, Faces, Grid, Law, Layer, Material, Soil, Vector

__all__ = ["Axis", "Body", "Condition", "Faces", "Freedom", "Grid", "Law", "Layer", "Material", "Output", "Pull",
           "Scene", "Soil", "Solver", "Stage", "Target", "Time", "Vector"]

Freedom = Literal["x", "y", "z", "rx", "ry", "rz"]


@dataclass(frozen=True)
class Pull:
    """An elastic line from a point of a body to a far end that moves at a constant velocity.

    It is laid out just taut at the start of the first stage that pulls.

    point          name of a physical point of the geometry, or [m] three geometry coordinates
    velocity       [m/s] of the far end
    stiffness      [N/m]
    length         [m] unstretched
    direction      [-] from the point to the far end at the start; None: along `velocity`
    tension_only   the line goes slack instead of pushing
    """

    point: str | Vector
    velocity: Vector
    stiffness: float
    length: float
    direction: Vector | None = None
    tension_only: bool = True


@dataclass(frozen=True)
class Body:
    """A rigid body meshed from a gmsh .geo file.

    geometry     path of the .geo; in a scene file relative to that file
    density      [kg/m³]
    parameters   values of the geometry's named parameters, in the units the .geo states
    position     [m] of the geometry's origin; None: (0, 0, 0)
    rotation     [-, deg] (ax, ay, az, angle) about the geometry's origin; None: as drawn
    rest_on      [m] z at which the lowest contact vertex is put, along z; None: left where it is
    velocity     [m/s] of the centre of mass at the start
    spin         [rad/s] at the start, body frame
    held         translations and rotations (about the spatial axes) that stay as they are
    driven       translations and rotations that keep the velocity and spin of the start, whatever it takes
    friction     [-] Coulomb coefficient against the soil
    penalty      [1/m] p_f in ε_N = p_f E A
    tangential   [-] ε_T / ε_N; what rolls creeps less the larger it is
    enforcement  penalty, or augmented Lagrangian: multipliers take the overlap away, at several solutions a step
    second_pass  [-] share of the contact carried by the body's vertices and edges against the faces of the points'
                 domains, from 0 (none) to 1; the rest is carried by the domains' corners against the body's triangles
    pull         line that drags the body
    """

    geometry: Path
    density: float
    name: str = "body"
    parameters: dict[str, float] = field(default_factory=dict)
    position: Vector | None = None
    rotation: tuple[float, float, float, float] | None = None
    rest_on: float | None = None
    velocity: Vector = (0.0, 0.0, 0.0)
    spin: Vector = (0.0, 0.0, 0.0)
    held: tuple[Freedom, ...] = ()
    driven: tuple[Freedom, ...] = ()
    friction: float = 0.0
    penalty: float = 50.0
    tangential: float = 1.0
    enforcement: Literal["penalty", "augmented"] = "penalty"
    second_pass: float = 0.0
    pull: Pull | None = None


@dataclass(frozen=True)
class Stage:
    """A stretch of time.

    steps   [-] outer steps
    step    [s] of each; None: time.step
    pull    whether pull lines act
    held    components of all bodies that stay as they are in this stage, driven ones too
    gravity [-] shares of gravity that act at the start and at the end of the stage, linear in between
    beta, gamma   [-] of Newmark's scheme, used in this stage if one is given, such as a dissipative pair to settle
                  with; None: time's
    """

    name: str
    steps: int
    step: float | None = None
    pull: bool = True
    held: tuple[Freedom, ...] = ()
    gravity: tuple[float, float] = (1.0, 1.0)
    beta: float | None = None
    gamma: float | None = None


@dataclass(frozen=True)
class Time:
    """The outer step and the scheme of time integration.

    step              [s] outer step
    scheme            Newmark's; generalised alpha, of second order with damping of high frequencies; or Newmark's
                      (1/4, 1/2) with rotations that keep energy and angular momentum
    beta, gamma       [-] of newmark; None: (1/4, 1/2), which damps nothing. Unconditionally stable for
                      beta >= gamma/2 >= 1/4; of first order for gamma > 1/2
    spectral_radius   [-] of generalised-alpha: what a step leaves of high frequencies, from 0 to 1; None: 0.8
    inertia           False: quasi-static, no inertia of soil or body
    smallest          [s] increment below which a run stops; None: a 64th of the outer step, with accuracy a 4096th
    accuracy          [-] error of positions, in smallest cells, that an outer step may add by its increments being too
                      long: they become as short as that asks for, and the outer step is their ceiling. None: they
                      follow convergence alone. 1e-3 is usual
    """

    step: float
    scheme: Literal["newmark", "generalised-alpha", "energy-momentum"] = "newmark"
    beta: float | None = None
    gamma: float | None = None
    spectral_radius: float | None = None
    inertia: bool = True
    smallest: float | None = None
    accuracy: float | None = None


@dataclass(frozen=True)
class Solver:
    """Newton's method and the linear systems inside it.

    tolerance          [-] of the residual, relative to the forces acting
    iterations         [-] of Newton before an increment is rejected and halved
    augmentations      [-] of an augmented Lagrangian, updates of its multipliers in an increment at most
    augmentation_tolerance  [-] of the forces of the overlap that is left, relative to the forces acting
    linear             preconditioned Krylov method, or a direct solver
    linear_tolerance   [-] relative, of the Krylov method near the solution
    loosest_tolerance  [-] the same far from it, where a better solution does not help Newton's method; up to
                       linear_tolerance: none
    tangent_tolerance  [-] change of a point's tangent within an increment, relative to Young's modulus times the root
                       of the residual, up to which it is not assembled again; 0: always. F-bar assembles all points
                       whatever it says
    line_search        shorten a Newton update that leaves more than 0.8 of the residual, where that lowers it further
    elastic_share      [-] of the elastic stiffness mixed into the plastic tangent. 0 is Newton's method; 0.1 saves
                       a tenth of the iterations of the anchor of 0.2 m cells and costs a tenth at 0.4 m
    """

    tolerance: float = 1e-6
    iterations: int = 15
    augmentations: int = 5
    augmentation_tolerance: float = 1e-3
    linear: Literal["krylov", "direct"] = "krylov"
    linear_tolerance: float = 1e-3
    loosest_tolerance: float = 0.02
    tangent_tolerance: float = 1e-2
    line_search: bool = True
    elastic_share: float = 0.0


@dataclass(frozen=True)
class Output:
    """What is written, counted in outer steps.

    every        between two VTK frames; 0: none
    pictures     steps of the last stage, from 1, to draw a picture of; any beyond its last are ignored
    checkpoint   between two checkpoints; 0: none
    """

    every: int = 5
    pictures: tuple[int, ...] = ()
    checkpoint: int = 10


@dataclass(frozen=True)
class Target:
    """An error that a scene wants to keep to, judged by a problem of the study that it resembles.

    like     name of that problem: column, manufactured, cantilever, platen or footing
    error    [-] that its cheapest settings may have had (`hybrid.scene.accuracy`)
    length   [m] of this scene that plays the part of that problem's: height of a column, wave length, depth of a
             beam, edge of a pressed cube, half the width of a footing
    """

    like: str
    error: float
    length: float


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything a run needs; `gravity` in [m/s²]. In a file `bodies` is [[body]] and `stages` [[stage]].

    accuracy   cells, steps and tolerances of a draft or of a reference instead of those given, or those that reached a
               Target, as accuracy = { like = "footing", error = 0.02, length = 1.0 } (`hybrid.scene.accuracy`)
    """

    name: str
    grid: Grid
    soil: Soil
    bodies: tuple[Body, ...] = field(default=(), metadata={"key": "body"})
    time: Time
    stages: tuple[Stage, ...] = field(metadata={"key": "stage"})
    gravity: Vector = (0.0, 0.0, -9.81)
    accuracy: Literal["draft", "standard", "reference"] | Target | None = None
    solver: Solver = Solver()
    output: Output = Output()
