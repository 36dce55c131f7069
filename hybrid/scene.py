"""What is modelled: one frozen dataclass per table of a scene file. SI units, angles in degrees, z upwards.

A scene file (TOML) and these classes map one to one: the tables are [grid.x], [grid.y], [grid.z],
[grid.faces], [soil], [soil.material], [[soil.layer]], [soil.layer.material], [[body]], [body.parameters], [body.pull],
[time], [[stage]], [solver] and [output].
Reading and checking is done in `hybrid.scene_file`; nothing here computes.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

Vector = tuple[float, float, float]
Condition = Literal["free", "roller", "fixed"]
Freedom = Literal["x", "y", "z", "rx", "ry", "rz"]
Law = Literal["drucker-prager", "hencky", "user", "von-mises", "willam-warnke"]


@dataclass(frozen=True)
class Axis:
    """One axis of the background grid: uniform, graded around `fine`, given by `nodes`, or collapsed.

    start, end   [m] extent; taken from `nodes` when those are given
    size         [m] the cells are equal and no larger than this; inside `fine` when that is given
    fine         [m] (low, high): cells of `size` in between, growing away from it
    growth       [-] largest ratio of neighbouring cells outside `fine`, in (1, 2]
    collapsed    one constant basis function and no displacement along this axis; end - start is the thickness
    nodes        [m] increasing coordinates of all nodes, instead of `size`
    around       [m] (below, above): cells of `size` from this far below to this far above the box of the body that
                 grid.follow names, and wherever it goes; they double away from it as `growth` allows
    window       [m] (below, above): soil farther than this from that box is left out; upwards, along z, nothing is
    doublings    [-] of the cells at most, with `around`; windows end at multiples of the widest cells
    """

    start: float | None = None
    end: float | None = None
    size: float | None = None
    fine: tuple[float, float] | None = None
    growth: float = 1.3
    collapsed: bool = False
    nodes: tuple[float, ...] | None = None
    around: tuple[float, float] | None = None
    window: tuple[float, float] | None = None
    doublings: int = 3

    @property
    def travels(self):
        """Whether the nodes go with a body."""
        return self.around is not None or self.window is not None

    def __post_init__(self):
        if self.nodes is not None and len(self.nodes):
            for name, node in (("start", self.nodes[0]), ("end", self.nodes[-1])):
                if getattr(self, name) is None:
                    object.__setattr__(self, name, node)


@dataclass(frozen=True)
class Faces:
    """What holds the soil at the six faces of the grid: nothing, its normal displacement, or all of it."""

    x_min: Condition = "roller"
    x_max: Condition = "roller"
    y_min: Condition = "roller"
    y_max: Condition = "roller"
    z_min: Condition = "roller"
    z_max: Condition = "free"


@dataclass(frozen=True)
class Grid:
    """The background grid: the tensor product of three axes.

    follow   name of the body that the axes with `around` or `window` go with; None: the first one
    behind   soil that a window leaves behind stays as it was and is solved again should the body return, or is removed
    """

    x: Axis
    y: Axis
    z: Axis
    faces: Faces = Faces()
    follow: str | None = None
    behind: Literal["freeze", "remove"] = "freeze"

    @property
    def travels(self):
        return any(axis.travels for axis in (self.x, self.y, self.z))


@dataclass(frozen=True)
class Material:
    """The soil's law. `relative_density` sets every value left out; a value given here replaces the preset.

    A value that the law does not use is refused; `hybrid.material.USES` lists them.

    law                  hencky: elastic. drucker-prager: circular cone. willam-warnke: section on both meridians of
                         Mohr-Coulomb. von-mises: undrained clay. user: given to `build` or `run` from Python
    relative_density     [%] of the sand whose correlations give the preset
    young                [Pa] one constant Young's modulus
    poisson              [-]
    density              [kg/m³] bulk
    friction_angle       [deg]
    dilation_angle       [deg] of plastic flow, at most the friction angle; equal: associated on a circular cone
    cohesion             [Pa]
    strength             [Pa] undrained shear strength s_u of von-mises, at the top of the soil or the layer
    strength_gradient    [Pa/m] growth of s_u with the depth below that
    hardening            [Pa] change of cohesion or s_u per equivalent plastic strain; negative: softening
    residual_cohesion    [Pa] where softening of the cohesion ends
    residual_strength    [Pa] where softening of s_u ends
    cone                 Mohr-Coulomb meridian or state that a circular cone is matched to; of von-mises: the state in
                         which it is as strong as Tresca's law
    reference_young      [Pa] E_ref in E = E_ref (K0 σ_v / 100 kPa)^m, instead of `young`
    stiffness_exponent   [-] m above
    buoyant              the preset's density is that of submerged sand
    """

    law: Law = "drucker-prager"
    relative_density: float | None = None
    young: float | None = None
    poisson: float | None = None
    density: float | None = None
    friction_angle: float | None = None
    dilation_angle: float | None = None
    cohesion: float | None = None
    strength: float | None = None
    strength_gradient: float | None = None
    hardening: float | None = None
    residual_cohesion: float | None = None
    residual_strength: float | None = None
    cone: Literal["compression", "extension", "plane strain"] = "compression"
    reference_young: float | None = None
    stiffness_exponent: float | None = None
    buoyant: bool = False


@dataclass(frozen=True)
class Layer:
    """A range of heights with values of its own. What it does not give, and soil in no layer, is soil.material's.

    A point belongs to the layer that its centre lies in, so layers should end on lines of the grid.

    name          for the model sheet
    top, bottom   [m] z of its ends; None: those of the soil
    law           None: that of soil.material
    material      values of soil.material that are different here, by name; relative_density replaces all of them
    k0            [-] ratio of horizontal to vertical initial stress; None: soil.k0, or from the layer's material
    """

    name: str
    top: float | None = None
    bottom: float | None = None
    law: Law | None = None
    material: dict[str, float] = field(default_factory=dict)
    k0: float | None = None


@dataclass(frozen=True)
class Soil:
    """The deformable body: a box of material points.

    top               [m] z of the surface; None: upper end of the grid
    lower, upper      [m] corners of the box of soil; None: the whole grid up to `top`
    points_per_axis   [-] material points per cell along each axis, one number or three
    held              all displacements of the soil are zero
    basis             generalised interpolation (gimp) or standard material point (mpm)
    domain            how point domains deform: with the second moments of the deformed domain, with the stretch, not at
                      all, or with the diagonal of F
    fbar              points take the volume change of the cells around them, so that nearly incompressible or
                      plastic soil does not lock
    ghost             [-] factor on Young's modulus of the penalty that ties cells hardly filled to their neighbours;
                      0: none, 0.033 is usual
    transfer          how points take up the motion of the nodes: the nodes' velocity with its gradient (affine); the
                      nodes' increments of velocity; or these blended with a share of the nodes' velocity itself
    blend             [-] that share a step, of transfer = "blended"; None: 0.05
    stray             points that leave the grid, or that nothing carries in a quasi-static scene: stop the run, stay
                      where they are and take no part any more, or vanish
    geostatic         start in equilibrium under gravity
    k0                [-] ratio of horizontal to vertical initial stress; None: from the material
    layers            what is different in ranges of z
    """

    material: Material
    top: float | None = None
    lower: Vector | None = None
    upper: Vector | None = None
    points_per_axis: int | tuple[int, int, int] = 2
    held: bool = False
    basis: Literal["gimp", "mpm"] = "gimp"
    domain: Literal["moments", "stretch", "none", "diagonal"] = "moments"
    fbar: bool = False
    ghost: float = 0.0
    transfer: Literal["affine", "increments", "blended"] = "affine"
    blend: float | None = None
    stray: Literal["stop", "freeze", "remove"] = "stop"
    geostatic: bool = True
    k0: float | None = None
    layers: tuple[Layer, ...] = field(default=(), metadata={"key": "layer"})


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
    line_search        shorten a Newton update that does not halve the residual, where that lowers it further
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


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything a run needs; `gravity` in [m/s²]. In a file `bodies` is [[body]] and `stages` [[stage]]."""

    name: str
    grid: Grid
    soil: Soil
    bodies: tuple[Body, ...] = field(default=(), metadata={"key": "body"})
    time: Time
    stages: tuple[Stage, ...] = field(metadata={"key": "stage"})
    gravity: Vector = (0.0, 0.0, -9.81)
    solver: Solver = Solver()
    output: Output = Output()
