"""The material and layers of a scene: values that the law needs, refuses or limits, and layers that overlap."""

from hybrid.scene.read import unknown
from hybrid.scene.soil import KEYS, NEEDS, OF_LAYERS, USES, Material, ends, laws, of_layer, span
from hybrid.scene.table import described, range_fault, shown

RESIDUALS = {"residual_cohesion": "cohesion", "residual_strength": "strength"}


def material_faults(soil, grid):
    """Texts of all faults of soil.material and the layers but ranges; `grid` must have ends along z."""
    if not _covered(soil, grid):
        yield from _missing("soil.material", soil.material)
    cone = ("cone",) if any("cone" in USES[law] for law in laws(soil)) else ()     # one for the soil and its layers
    yield from _values("soil.material", soil.material, soil.material, cone)
    if soil.material.law == "user" and soil.geostatic and not soil.held and soil.k0 is None:
        yield "soil: missing k0 for law 'user'; give the ratio of horizontal to vertical stress, or geostatic = false"
    if not soil.geostatic:
        yield from _without_stress(soil)
    for i, layer in enumerate(soil.layers):
        yield from _place(i, soil, grid)
        yield from _layer_values(f"soil.layer.{i}", layer, soil.material)


def _without_stress(soil):
    """Ratios of stresses that soil does not start with, where its stiffness does not follow them either."""
    parts = [("soil", soil.k0, soil.material)]
    parts += [(f"soil.layer.{i}", layer.k0, of_layer(soil.material, layer)) for i, layer in enumerate(soil.layers)]
    for key, k0, m in parts:
        if k0 is not None and m.reference_young is None and m.relative_density is None:
            yield (f"{key}.k0 = {k0:g}: must be left out with geostatic = false, with which soil starts without stress; or "
                   "set geostatic = true")


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
    if layer.law is not None and "user" in (layer.law, material.law):
        yield f"{key}.law = {layer.law!r}: must be left out: law = 'user' of soil.material is one law for all points"
        return
    wrong = [name for name, value in layer.material.items()
             if name not in OF_LAYERS or isinstance(value, str) or isinstance(value, bool) != (name == "buoyant")]
    for name in wrong:
        given = f"{key}.material.{name} = {layer.material[name]!r}"
        if name == "law":
            yield f"{given}: a layer has its law beside its material: write {key}.law"
        elif name in OF_LAYERS:
            yield f"{given}: expected {'true or false' if name == 'buoyant' else 'a number'}"
        else:
            yield unknown(Material, f"{key}.material.{name}", name, "a layer", OF_LAYERS)
    if not wrong:
        for name, value in layer.material.items():
            if described(KEYS[name]).range:
                yield from range_fault(value, described(KEYS[name]), f"{key}.material.{name}")
        whole = of_layer(material, layer)
        yield from _missing(f"{key}.material", whole)
        yield from _values(f"{key}.material", whole, Material(**layer.material, law=whole.law))


def _covered(soil, grid):
    """Whether layers leave no point to soil.material."""
    spans = sorted(span(layer, soil, grid) for layer in soil.layers)
    lower, upper = ends(soil, grid)
    for bottom, top in spans:
        if bottom > lower:
            return False
        lower = max(lower, top)
    return bool(spans) and lower >= upper


def _missing(key, m):
    """The values that the law needs and neither the preset nor the material gives."""
    if m.relative_density is not None:
        return
    elastic = () if m.law == "user" else ("young" if m.reference_young is None else "stiffness_exponent",)
    needed = (*NEEDS[m.law], *elastic)
    absent = [name for name in needed if getattr(m, name) is None]
    if absent:
        preset = ", or relative_density [%] for the sand preset" if "relative_density" in USES[m.law] else ""
        elastic_or_clay = "; law = 'hencky' is elastic soil, strength [Pa] that of undrained clay"
        others = elastic_or_clay if "friction_angle" in absent else ""
        them = "it" if len(absent) == 1 else "them"
        yield f"{key}: missing {', '.join(absent)} for law {m.law!r}; give {them}{preset}{others}"


def _values(key, m, given, also=()):
    """Values that contradict one another or, among those `given`, that neither the law nor a layer uses (`also`)."""
    used = ("law", "density", *USES[m.law], *also)
    for name, f in KEYS.items():
        value = getattr(given, name)
        submerged = name == "buoyant" and m.relative_density is None     # told below, with its remedy
        if value != f.default and name not in used and not submerged:
            others = ", ".join(USES[m.law]) or "the density alone"
            yield f"{key}.{name} = {shown(value)}: must be left out with law = {m.law!r}, which uses {others}"
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
    """A residual strength belongs to softening, and softening needs one."""
    for residual, start in RESIDUALS.items():
        low, high = getattr(m, residual), getattr(m, start)
        if residual not in USES[m.law]:
            continue
        if (m.hardening or 0) < 0 and low is None:
            yield (f"{key}: missing {residual} for hardening = {m.hardening:g}; "
                   "give the strength [Pa] at which softening ends")
        if (m.hardening or 0) >= 0 and getattr(given, residual) is not None:
            yield f"{key}.{residual} = {low:g}: must be left out without softening; give a negative hardening [Pa]"
        gradient = m.strength_gradient if start == "strength" else None
        if low is not None and high is not None and not gradient and low > high:
            yield f"{key}.{residual} = {low:g}: must be at most {start} = {high:g}; softening ends there"
