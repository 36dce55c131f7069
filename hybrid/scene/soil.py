"""The soil of a scene: the box of material points, its material and layers; values of each law and of each layer."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Literal, get_type_hints

from hybrid.scene.table import key, table

Law = Literal["drucker-prager", "hencky", "mohr-coulomb", "user", "von-mises", "willam-warnke"]
# other words for them
LAW_WORDS = {
    **dict.fromkeys(("clay", "undrained", "tresca", "mises", "von mises", "vonmises", "von_mises", "j2"), "von-mises"),
    **dict.fromkeys(("sand", "mohr coulomb", "mohrcoulomb", "mohr_coulomb", "mc", "coulomb", "frictional"), "mohr-coulomb"),
    **dict.fromkeys(("drucker prager", "druckerprager", "drucker_prager", "dp"), "drucker-prager"),
    **dict.fromkeys(("elastic", "linear", "linear-elastic", "hooke", "neo-hookean", "hyperelastic"), "hencky"),
    **dict.fromkeys(("willam warnke", "willam_warnke", "matsuoka-nakai", "lade-duncan"), "willam-warnke"),
}


@table
class Material:
    """The soil's law and its values. `relative_density` sets every value left out; a given value replaces the preset.

    A value that the law does not use is refused.
    """

    law: Law | None = key("hencky: elastic; drucker-prager: circular cone; mohr-coulomb: pyramid with its edges rounded "
                          "off; willam-warnke: arc through both meridians of Mohr-Coulomb; von-mises: undrained clay; user: "
                          "given to `build` or `run` from Python",
                          default=None, also=("model", "type"), words=LAW_WORDS)
    relative_density: float | None = key("relative density of the sand whose correlations give the preset", "%",
                                         default=None, above=0, at_most=100, remedy="38 is a loose sand",
                                         also=("dr", "d_r", "id"))
    young: float | None = key("constant Young's modulus", "Pa", default=None, above=0, remedy="20e6 is 20 MPa",
                              also=("e", "youngs_modulus", "young_modulus", "elastic_modulus", "modulus", "stiffness"))
    poisson: float | None = key("Poisson's ratio", "-", default=None, above=-1, below=0.5,
                                remedy="0.49 is nearly incompressible", also=("nu", "poissons_ratio", "poisson_ratio"))
    density: float | None = key("bulk density", "kg/m³", default=None, above=0, remedy="1600 is a dry sand",
                                also=("rho", "unit_weight", "gamma", "mass_density"))
    friction_angle: float | None = key("friction angle φ", "deg", default=None, at_least=0, below=90,
                                       remedy="32.75 is a loose sand", also=("phi", "friction"))
    dilation_angle: float | None = key("dilation angle ψ, at most φ; ψ = φ: associated flow on a circular cone", "deg",
                                       default=None, at_least=0, below=90, remedy="0 keeps the volume",
                                       also=("psi", "dilation", "dilatancy", "dilatancy_angle"))
    cohesion: float | None = key("cohesion", "Pa", default=None, at_least=0, remedy="300 is nearly cohesionless",
                                 also=("c",))
    strength: float | None = key("undrained shear strength s_u of von-mises, at the top of the soil or the layer", "Pa",
                                 default=None, at_least=0, remedy="20e3 is a soft clay",
                                 also=("su", "s_u", "cu", "c_u", "undrained_strength", "shear_strength",
                                       "undrained_shear_strength"))
    strength_gradient: float | None = key("increase of s_u with the depth below the ground at the place, or below the "
                                          "top of the layer", "Pa/m", default=None)
    hardening: float | None = key("change of cohesion or s_u per equivalent plastic strain; negative: softening", "Pa",
                                  default=None)
    residual_cohesion: float | None = key("cohesion at which softening ends", "Pa", default=None, at_least=0,
                                          remedy="0 leaves friction alone")
    residual_strength: float | None = key("s_u at which softening ends", "Pa", default=None, above=0,
                                          remedy="give the remoulded strength")
    cone: Literal["compression", "extension", "plane strain"] | None = key(
        "Mohr-Coulomb meridian or state that a circular cone is matched to; of von-mises: the state in which it is as "
        "strong as Tresca's law", default=None)
    reference_young: float | None = key("E_ref in E = E_ref (K0 σ_v / 100 kPa)^m, instead of `young`", "Pa",
                                        default=None, above=0, remedy="20e6 is 20 MPa")
    stiffness_exponent: float | None = key("m in that equation of `reference_young`", "-", default=None,
                                           at_least=0, at_most=1, remedy="0 is one stiffness at all depths")
    buoyant: bool = key("the preset's density is that of submerged sand", default=False)


@table
class Layer:
    """A range of heights with values of its own. Values left out, and soil in no layer, are those of soil.material.

    A point belongs to the layer that its centre lies in, so layers should end on lines of the grid.
    """

    name: str = key("label on the model sheet")
    top: float | None = key("z of its upper end; left out: that of the soil", "m", default=None)
    bottom: float | None = key("z of its lower end; left out: that of the soil", "m", default=None)
    law: Law | None = key("law of the layer; left out: that of soil.material", default=None, words=LAW_WORDS)
    material: dict[str, float | bool | str] = key(      # words too, for what is said about a law among them
        "values of soil.material that are different here, by name; relative_density replaces all of them",
        default_factory=dict)
    k0: float | None = key(
        "ratio of horizontal to vertical initial stress; left out: soil.k0, or from the layer's material", "-",
        default=None, above=0, remedy="leave it out for soil.k0 or the material's own")


@table
class Soil:
    """The deformable body: a box of material points."""

    material: Material = key("law and values of the soil in no layer")
    top: float | None = key("z of the surface; left out: upper end of the grid", "m", default=None)
    ground: tuple[tuple[float, float], ...] | Path | None = key(
        "surface that is not level, at most as high as `top`: a profile along x as a list of [x, z], straight in between "
        "and level beyond its ends, or the path of a CSV file with columns x, z, or x, y, z of a grid of heights", "m",
        default=None)
    lower: tuple[float, float, float] | None = key("lower corner of the box of soil; left out: that of the grid", "m",
                                                   default=None)
    upper: tuple[float, float, float] | None = key("upper corner of that box; left out: that of the grid, up to `top`",
                                                   "m", default=None)
    points_per_axis: int | tuple[int, int, int] = key(
        "material points per cell along each axis, one number or three", "-", default=2, at_least=1, at_most=10,
        remedy="2 is usual and makes 8 points per cell")
    held: bool = key("all displacements of the soil are zero", default=False)
    basis: Literal["gimp", "mpm"] = key("generalised interpolation (gimp) or standard material point (mpm)",
                                        default="gimp")
    domain: Literal["moments", "none"] = key(
        "how point domains deform: by the second moments of the deformed domain, or not at all", default="moments")
    fbar: bool | None = key("points take the volume change of the cells around them, so that nearly incompressible or "
                            "plastic soil does not lock; left out: by the law and Poisson's ratio", default=None)
    ghost: float | None = key(
        "factor on Young's modulus in the penalty that ties cells with little soil to their fullest neighbours; 0: none; "
        "left out: 0.3, or 0.03 in soil that yields around bodies in space; in clay with inertia and without bodies "
        "1.5 s_u / E at most, if its steps follow a fall", "-",
        default=None, at_least=0, at_most=1,
        remedy="leave it out; 0 switches it off")
    transfer: Literal["affine", "increments"] = key(
        "how points take the motion of the nodes: their velocity with its gradient (affine), or their increments of "
        "velocity; without inertia always increments", default="affine")
    stray: Literal["stop", "freeze", "remove"] = key(
        "points that leave the grid, or that no node carries in a quasi-static scene: stop the run, keep them where "
        "they are and leave them out of all sums (freeze), or remove them", default="stop")
    geostatic: bool = key("start in equilibrium under gravity", default=True)
    k0: float | None = key("ratio of horizontal to vertical initial stress; left out: from the material", "-",
                           default=None, above=0, remedy="leave it out for the material's own")
    layers: tuple[Layer, ...] = key("ranges of z with other values", default=(), name="layer")


# ------------------------------------------------------------------ values of laws and layers

PRESET = ("relative_density", "buoyant")
ELASTIC = ("young", "poisson", "reference_young", "stiffness_exponent")
FRICTION = ("friction_angle", "dilation_angle", "cohesion", "hardening", "residual_cohesion")
USES = {  # values that each law uses, apart from its name and the density
    "hencky": (*PRESET, *ELASTIC),
    "drucker-prager": (*PRESET, *ELASTIC, *FRICTION, "cone"),
    "mohr-coulomb": (*PRESET, *ELASTIC, *FRICTION),
    "willam-warnke": (*PRESET, *ELASTIC, *FRICTION),
    "von-mises": (*ELASTIC, "strength", "strength_gradient", "hardening", "residual_strength", "cone"),
    "user": (),
}
# values that a law has no default for, without a relative density; `young` or, with `reference_young`,
# `stiffness_exponent` too
NEEDS = {
    "hencky": ("poisson", "density"),
    "drucker-prager": ("poisson", "density", "friction_angle", "dilation_angle", "cohesion"),
    "mohr-coulomb": ("poisson", "density", "friction_angle", "dilation_angle", "cohesion"),
    "willam-warnke": ("poisson", "density", "friction_angle", "dilation_angle", "cohesion"),
    "von-mises": ("poisson", "density", "strength"),
    "user": ("density",),
}
FRICTIONAL = {"drucker-prager", "mohr-coulomb", "willam-warnke"}
NUMBERS = tuple(name for name, hint in get_type_hints(Material).items() if hint == float | None)
OF_LAYERS = (*NUMBERS, "buoyant")       # what a layer may have of its own: sand is dry above a water table, buoyant below
KEYS = {f.name: f for f in fields(Material)}


def of_layer(material, layer):
    """Material of a layer: soil.material with the layer's law and values in place of its own.

    A stiffness replaces the other kind of stiffness, and a relative density every value of soil.material.
    """
    law, own = layer.law or material.law, layer.material
    inherited = {"density", *USES[law]}
    if "relative_density" in own:
        inherited.difference_update(NUMBERS)
    if "young" in own:
        inherited -= {"reference_young", "stiffness_exponent"}
    if "reference_young" in own:
        inherited.discard("young")
    return Material(**{**{name: getattr(material, name) for name in inherited}, **own, "law": law})


def laws(soil):
    """Names of the laws of the soil and its layers."""
    return {soil.material.law, *(layer.law for layer in soil.layers if layer.law)}


def materials(soil):
    """Material of the soil and those of its layers."""
    return [soil.material, *(of_layer(soil.material, layer) for layer in soil.layers)]


def is_clay(law, friction_angle):
    """Whether no pressure changes the strength of soil of a `law`."""
    return law == "von-mises" or law in FRICTIONAL and friction_angle == 0.0


def clay_layers(soil):
    """[bool] whether the soil and each of its layers, checked or not, is clay."""
    of_soil = soil.material.friction_angle
    return [is_clay(soil.material.law, of_soil)] + [
        is_clay(layer.law or soil.material.law, layer.material.get(
            "friction_angle", None if "relative_density" in layer.material else of_soil)) for layer in soil.layers]


def as_clay(material):
    """A Material that is clay with the keys of von Mises' law, any other one as it is: Mohr-Coulomb's pyramid is Tresca's
    prism where φ = 0, of the same strength in plane strain; the other laws with friction are von Mises' cone."""
    if not is_clay(material.law, material.friction_angle) or material.law == "von-mises":
        return material
    cone = {"mohr-coulomb": "plane strain", "willam-warnke": "compression"}.get(material.law, material.cone)
    return replace(material, law="von-mises", strength=material.cohesion, residual_strength=material.residual_cohesion,
                   cone=cone, friction_angle=None, dilation_angle=None, cohesion=None, residual_cohesion=None)


def ends(soil, grid):
    """(bottom, top) [m] of the soil, before what `soil.ground` takes away; an end left out is that of the grid."""
    bottom = grid.z.start if soil.lower is None else soil.lower[2]
    if soil.top is not None:
        return bottom, soil.top
    return bottom, grid.z.end if soil.upper is None else soil.upper[2]


def within(layer, bottom, top):
    """(bottom, top) [m] of a layer of soil from `bottom` to `top` [m], as given; an end left out is that of the soil."""
    return (bottom if layer.bottom is None else layer.bottom), (top if layer.top is None else layer.top)


def span(layer, soil, grid):
    """The same of the soil of a scene."""
    return within(layer, *ends(soil, grid))
