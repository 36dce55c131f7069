"""The ground of a scene: grid, soil and material, a frozen dataclass per table of its file (`hybrid.scene`)."""

from dataclasses import dataclass, field
from typing import Literal

Vector = tuple[float, float, float]
Condition = Literal["free", "roller", "fixed"]
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

    A value that the law does not use is refused; `hybrid.scene.material.USES` lists them.

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
