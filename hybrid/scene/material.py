"""What a material may say: which values its law uses, what a layer of soil inherits, and what is wrong with either."""

import difflib
from dataclasses import fields
from typing import get_type_hints

from hybrid.scene import Material

PRESET = ("relative_density", "buoyant")
ELASTIC = ("young", "poisson", "reference_young", "stiffness_exponent")
FRICTION = ("friction_angle", "dilation_angle", "cohesion", "hardening", "residual_cohesion")
USES = {  # of each law, apart from its name and the density
    "hencky": (*PRESET, *ELASTIC),
    "drucker-prager": (*PRESET, *ELASTIC, *FRICTION, "cone"),
    "willam-warnke": (*PRESET, *ELASTIC, *FRICTION),
    "von-mises": (*ELASTIC, "strength", "strength_gradient", "hardening", "residual_strength", "cone"),
    "user": (),
}
NUMBERS = tuple(name for name, hint in get_type_hints(Material).items() if hint == float | None)
DEFAULTS = {f.name: f.default for f in fields(Material)}

LIMITS = {
    "relative_density": (lambda v: 0 < v <= 100, "in (0, 100] %", "38 is a loose sand"),
    "young": (lambda v: v > 0, "positive", "in Pa: 20e6 is 20 MPa"),
    "reference_young": (lambda v: v > 0, "positive", "in Pa: 20e6 is 20 MPa"),
    "stiffness_exponent": (lambda v: 0 <= v <= 1, "from 0 to 1", "0 is one stiffness at all depths"),
    "poisson": (lambda v: -1 < v < 0.5, "above -1 and below 0.5", "0.49 is nearly incompressible"),
    "density": (lambda v: v > 0, "positive", "in kg/m³: 1600 is a dry sand"),
    "friction_angle": (lambda v: 0 <= v < 90, "from 0 to below 90 degrees", "32.75 is a loose sand"),
    "dilation_angle": (lambda v: 0 <= v < 90, "from 0 to below 90 degrees", "0 keeps the volume"),
    "cohesion": (lambda v: v >= 0, "at least 0 Pa", "300 is nearly cohesionless"),
    "residual_cohesion": (lambda v: v >= 0, "at least 0 Pa", "0 leaves friction alone"),
    "strength": (lambda v: v >= 0, "at least 0 Pa", "20e3 is a soft clay"),
    "residual_strength": (lambda v: v > 0, "positive", "in Pa: the remoulded strength"),
}
FLOORS = {"residual_cohesion": "cohesion", "residual_strength": "strength"}


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


def span(layer, soil, grid):
    """(bottom, top) [m] of a layer, cut by nothing but the soil's own ends where it gives none."""
    lower = grid.z.start if soil.lower is None else soil.lower[2]
    upper = grid.z.end if soil.top is None else soil.top
    return (lower if layer.bottom is None else layer.bottom), (upper if layer.top is None else layer.top)


def material_faults(soil, grid):
    """Texts of what is wrong with soil.material and the layers; `grid` must have ends along z."""
    if not _covered(soil, grid):
        yield from _missing("soil.material", soil.material)
    yield from _values("soil.material", soil.material, soil.material)
    if soil.material.law == "user" and soil.geostatic and not soil.held and soil.k0 is None:
        yield "soil: missing k0 for law 'user'; give the ratio of horizontal to vertical stress, or geostatic = false"
    for i, layer in enumerate(soil.layers):
        yield from _place(i, soil, grid)
        yield from _layer_values(f"soil.layer.{i}", layer, soil.material)


def _place(i, soil, grid):
    """Faults of the range of layer i: it is empty, or shared with a layer before it."""
    key, (bottom, top) = f"soil.layer.{i}", span(soil.layers[i], soil, grid)
    if not bottom < top:
        yield f"{key}.bottom = {bottom:g}: must be below its top = {top:g}; both are z [m], upwards"
    for j, other in enumerate(soil.layers[:i]):
        low, high = span(other, soil, grid)
        if bottom < high and low < top:
            yield (f"{key}: must not overlap layer.{j}, z = {low:g} to {high:g} m, but goes from {bottom:g} to "
                   f"{top:g} m; move top or bottom")


def _layer_values(key, layer, material):
    if layer.k0 is not None and layer.k0 <= 0:
        yield f"{key}.k0 = {layer.k0:g}: must be positive; leave it out for soil.k0 or the material's own"
    if layer.law is not None and "user" in (layer.law, material.law):
        yield f"{key}.law = {layer.law!r}: must be left out: law = 'user' of soil.material is one law for all points"
        return
    unknown = [name for name in layer.material if name not in NUMBERS]
    for name in unknown:
        near = difflib.get_close_matches(name, NUMBERS, 1, 0.5)
        yield (f"unknown key '{key}.material.{name}'{f' (did you mean {near[0]!r}?)' if near else ''}; "
               f"valid: {', '.join(NUMBERS)}")
    if not unknown:
        whole = of_layer(material, layer)
        yield from _missing(f"{key}.material", whole)
        yield from _values(f"{key}.material", whole, Material(**layer.material, law=whole.law))


def _covered(soil, grid):
    """Whether layers leave no point to soil.material."""
    spans = sorted(span(layer, soil, grid) for layer in soil.layers)
    lower = grid.z.start if soil.lower is None else soil.lower[2]
    upper = grid.z.end if soil.top is None else soil.top
    for bottom, top in spans:
        if bottom > lower:
            return False
        lower = max(lower, top)
    return bool(spans) and lower >= upper


def _missing(key, m):
    """The values that the law needs and neither the preset nor the material gives."""
    if m.relative_density is not None:
        return
    elastic = "young" if m.reference_young is None else "stiffness_exponent"
    needed = {"user": ["density"], "hencky": ["poisson", "density", elastic],
              "von-mises": ["poisson", "density", "strength", elastic]}.get(
        m.law, ["poisson", "density", "friction_angle", "dilation_angle", "cohesion", elastic])
    absent = [name for name in needed if getattr(m, name) is None]
    if absent:
        preset = ", or relative_density [%] for the sand preset" if "relative_density" in USES[m.law] else ""
        yield f"{key}: missing {', '.join(absent)} for law {m.law!r}; give them{preset}"


def _values(key, m, given):
    """Values out of range, in contradiction, or, among those `given`, of no use to the law."""
    used = ("law", "density", *USES[m.law])
    for name, default in DEFAULTS.items():
        value = getattr(given, name)
        if value != default and name not in used:
            near = ", ".join(USES[m.law]) or "the density alone"
            yield f"{key}.{name} = {value}: must be left out with law = {m.law!r}, which uses {near}"
    for name, (holds, limit, remedy) in LIMITS.items():
        value = getattr(m, name)
        if value is not None and not holds(value):
            yield f"{key}.{name} = {value:.10g}: must be {limit}; {remedy}"
    if m.young is not None and m.reference_young is not None:
        yield f"{key}: young and reference_young exclude each other; keep young for one constant stiffness"
    elif m.young is not None and given.stiffness_exponent is not None:
        yield f"{key}: young and stiffness_exponent exclude each other; give reference_young, or leave out the exponent"
    if given.buoyant and m.relative_density is None:
        yield f"{key}.buoyant = true: must be left out without relative_density; give the buoyant density itself"
    yield from _strength(key, m)
    yield from _softening(key, m, given)


def _strength(key, m):
    if "friction_angle" in USES[m.law] and m.friction_angle is not None:
        if (m.dilation_angle or 0) > m.friction_angle:
            yield (f"{key}.dilation_angle = {m.dilation_angle:.10g}: must be at most friction_angle = "
                   f"{m.friction_angle:.10g}; equal angles are associated flow")
        if m.friction_angle == 0 and m.cohesion == 0:
            yield (f"{key}.cohesion = 0: must be positive when friction_angle = 0; "
                   "the soil has no strength otherwise")
        if m.friction_angle == 0 and m.residual_cohesion == 0:
            yield (f"{key}.residual_cohesion = 0: must be positive when friction_angle = 0; "
                   "use law = 'von-mises' for clay")
    if m.law == "von-mises" and m.strength == 0 and not (m.strength_gradient or 0) > 0:
        yield f"{key}.strength = 0: must be positive without a positive strength_gradient; 20e3 is a soft clay"


def _softening(key, m, given):
    """A floor belongs to softening, and softening needs one."""
    for floor, start in FLOORS.items():
        low, high = getattr(m, floor), getattr(m, start)
        if floor not in USES[m.law]:
            continue
        if (m.hardening or 0) < 0 and low is None:
            yield (f"{key}: missing {floor} for hardening = {m.hardening:g}; "
                   "give the strength [Pa] at which softening ends")
        if (m.hardening or 0) >= 0 and getattr(given, floor) is not None:
            yield f"{key}.{floor} = {low:g}: must be left out without softening; give a negative hardening [Pa]"
        gradient = m.strength_gradient if start == "strength" else None
        if low is not None and high is not None and not gradient and low > high:
            yield f"{key}.{floor} = {low:g}: must be at most {start} = {high:g}; it is where softening ends"
