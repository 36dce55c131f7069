"""Numbers of a scene that are allowed and look wrong: each gives a note with the number and what it usually means.

None of them changes what runs. ODD lists single values; the functions below it compare several. Where a body lies needs
its mesh: `hybrid.monitors.limits.place`.
"""

from dataclasses import dataclass, replace
from math import hypot, inf, pi

from hybrid.scene.soil import FRICTIONAL, as_clay, ends, materials, of_layer, span
from hybrid.scene.table import shown

KILOPASCAL = "Pa expected; is this a number of kPa?"
TONS = "kg/m³ expected; is this a number of t/m³, 1.8 for 1800?"
WEIGHT = "kg/m³ expected; is this a unit weight in kN/m³, 18 for 1835?"
MILLIMETRES = "SI units expected; is this a number of millimetres?"


@dataclass(frozen=True)
class Odd:
    """Values of a key that look wrong: those between `above` and `below`; meaning: what they usually are."""

    key: str
    above: float
    below: float
    unit: str
    meaning: str
    laws: tuple = ()    # of the soil to which it applies; () all

    def note(self, path, value):
        """[The note about a value], [] where it looks right or there is none."""
        if isinstance(value, dict):
            return [note for name, item in value.items()
                    for note in replace(self, key=f"{self.key}.{name}").note(path, item)]
        if value is None or not self.above < value < self.below:
            return []
        return [f"{path}.{self.key} = {shown(value)}{f' {self.unit}' if self.unit else ''} looks wrong: {self.meaning}"]


GENTLE = 20.0           # [Pa/m]: normally consolidated clays have 1000 to 2000
WEAK = 100.0, 0.01      # tension [Pa] and share of the soil's strength, below both of which it looks like kPa
SOIL = (
    Odd("relative_density", 0, 1.0001, "%", "per cent expected; is this a share, 0.38 for 38 %?"),
    Odd("friction_angle", 0, 1.6, "deg", "degrees expected; is this an angle in radians, 0.57 for 32.7 degrees?",
        FRICTIONAL),
    Odd("friction_angle", 60, inf, "deg", "soils have 20 to 50 degrees", FRICTIONAL),
    Odd("poisson", -inf, 0.0, "", "soils have 0.1 to 0.5"),
    Odd("young", 0, 2e5, "Pa", KILOPASCAL, FRICTIONAL),
    Odd("reference_young", 0, 2e5, "Pa", KILOPASCAL),
    Odd("young", 1e13, inf, "Pa", "steel has 2.1e11 Pa"),
    Odd("cohesion", 0, 50, "Pa", KILOPASCAL, FRICTIONAL),
    Odd("strength", 0, 100, "Pa", KILOPASCAL),
    Odd("strength_gradient", 0, GENTLE, "Pa/m", "Pa/m expected; is this a number of kPa/m, 1500 for 1.5?"),
    Odd("density", 0, 5, "kg/m³", TONS),
    Odd("density", 5, 30, "kg/m³", WEIGHT),
    Odd("density", 3e4, inf, "kg/m³", "a soil has 1000 to 2500 kg/m³"),
)
BODY = (
    Odd("density", 0, 30, "kg/m³", "kg/m³ expected; is this a number of t/m³, 7.85 for steel?"),
    Odd("density", 3e4, inf, "kg/m³", "the heaviest metals have 22 000 kg/m³"),
    Odd("friction", 1, inf, "", "a coefficient expected, 0.45 of steel on sand; is this an angle?"),
    Odd("tangential", 100, inf, "", "a ratio of 1 to 3 is usual; contact as stiff as this hardly converges"),
)
FASTEST = 200.0         # [m/s]
STRONGEST = 3000.0      # [m/s²] of gravity: 300 g, as in a centrifuge
LONGEST = 2000.0        # [m] of an axis
FALLS = 10.0            # lengths of the grid
THICKEST = 0.5          # [m] of a wire, or of the bars of a chain
RIGIDITY = 20.0, 2e4    # E / s_u of clays
HEAVY = 2.0             # weight over Young's modulus
SLENDER = 20.0          # of cells


def sense_notes(scene):
    """Texts about a Scene all of whose keys are decided."""
    heavy = any(scene.gravity)
    if not scene.soil.held:
        yield from _soil(scene, heavy)
    for i, body in enumerate(scene.bodies):
        yield from _body(f"body.{i}", body, heavy or scene.time.inertia)
        yield from _tension(f"body.{i}", body, scene.soil)
        yield from _drive(f"body.{i}", body, scene.stages)
    size = hypot(*scene.gravity)
    if size > STRONGEST:
        yield f"gravity = {shown(scene.gravity)} m/s² looks wrong: 9.81 m/s² expected; is this a number of mm/s²?"
    if scene.gravity[2] > 0:
        yield f"gravity = {shown(scene.gravity)} m/s² looks wrong: it acts upwards; z points up, [0, 0, -9.81] is usual"
    yield from _grid(scene.grid)
    yield from _steps(scene)


def _soil(scene, heavy):
    """Values of soil.material, and of layers those that they give themselves."""
    soil = scene.soil
    low, high = ends(soil, scene.grid)
    tables = [("soil.material", soil.material, None, _weight(soil.material, low, high, scene.gravity))]
    for i, layer in enumerate(soil.layers):
        whole = of_layer(soil.material, layer)
        weight = _weight(whole, *span(layer, soil, scene.grid), scene.gravity)
        tables.append((f"soil.layer.{i}.material", whole, layer.material, weight))
    for path, material, own, weight in tables:
        for odd in SOIL:
            used = (heavy or odd.key != "density") and (not odd.laws or material.law in odd.laws)
            if used and (own is None or odd.key in own):
                yield from odd.note(path, getattr(material, odd.key))
        yield from _stiffness(path, material, weight)
        if own is None or material.law != soil.material.law or "cohesion" in own:
            yield from _apex(path, material, heavy or scene.time.inertia)


def _apex(path, m, supported):
    """Sand that neither weight nor cohesion lets carry anything, so that without inertia nothing balances a body's force."""
    if not supported and m.law in FRICTIONAL and m.cohesion == 0.0:
        yield (f"{path}.cohesion = 0 Pa with gravity = [0, 0, 0] m/s² looks wrong: sand without pressure has no strength "
               "and no stiffness, so that no step has an equilibrium; give gravity = [0, 0, -9.81], or a cohesion")


def _tension(path, body, soil):
    """Tension beside the strength of the strongest clay of the soil."""
    strength = max(m.strength or 0.0 for m in materials(soil))
    if not soil.held and isinstance(body.tension, (int, float)) and 0.0 < body.tension < min(WEAK[0], WEAK[1] * strength):
        yield (f"{path}.tension = {body.tension:g} Pa beside strength = {strength:g} Pa looks wrong: {KILOPASCAL}")


def _drive(path, body, stages):
    """Drive of a body that starts at rest and that no stage moves."""
    moved = any(motion.body in (None, body.name) for stage in stages for motion in stage.motions)
    if body.driven and not any(body.velocity) and not any(body.spin) and not moved:
        yield (f"{path}.driven = {shown(body.driven)} with velocity = [0, 0, 0] and spin = [0, 0, 0] looks wrong: driven "
               "components keep the velocity of the start, so that the body stands still. Give body.velocity or "
               "stage.motion; what is to stand still is held (body.held)")


def _weight(material, low, high, gravity):
    """Stress [Pa] at the foot of soil between two heights [m] from its own weight."""
    return (material.density or 0.0) * abs(gravity[2]) * max(0.0, high - low)


def _stiffness(path, m, weight):
    """Young's modulus beside the weight of the soil and beside its strength."""
    if m.young is None:
        return
    if HEAVY * m.young < weight:
        yield (f"{path}.young = {m.young:g} Pa looks wrong: the weight of the soil, {weight:.3g} Pa at its foot, is "
               f"over {HEAVY:g} times as much; {KILOPASCAL}")
    strength, name = as_clay(m).strength, "strength" if m.law == "von-mises" else "cohesion"
    if strength and not RIGIDITY[0] <= m.young / strength <= RIGIDITY[1]:
        yield (f"{path}.young = {m.young:g} Pa over {name} = {strength:g} Pa is {m.young / strength:.3g}, which "
               "looks wrong: clays have 50 to 2000; is one of them a number of kPa?")


def _body(path, body, heavy):
    for odd in BODY:
        if heavy or odd.key != "density":
            yield from odd.note(path, getattr(body, odd.key))
    angle = abs(body.rotation[3]) if body.rotation else 0.0
    turns = angle / (pi / 12)
    if 0.5 < turns < 24.5 and abs(turns - round(turns)) < 0.01 and abs(angle - round(angle)) > 1e-9:
        yield (f"{path}.rotation = {shown(body.rotation)} looks wrong: an angle in degrees expected; is "
               f"{angle:g} in radians, {round(turns) * 15} degrees?")
    moving = [("velocity", body.velocity)] + ([("pull.velocity", body.pull.velocity)] if body.pull else [])
    for key, velocity in moving:
        if hypot(*velocity) > FASTEST:
            yield f"{path}.{key} = {shown(velocity)} m/s looks wrong: {MILLIMETRES[:-1]} a second?"
    if body.pull is not None and (body.pull.diameter or 0.0) > THICKEST:
        yield (f"{path}.pull.diameter = {body.pull.diameter:g} m looks wrong: {MILLIMETRES[:-1]}, 0.076 for 76? Chains "
               "have bars of up to 0.2 m")
    if body.pull is not None and body.pull.direction is not None and body.pull.tension_only:
        along = sum(a * b for a, b in zip(body.pull.direction, body.pull.velocity))
        if along < 0:
            yield (f"{path}.pull.direction = {shown(body.pull.direction)} looks wrong: it points away from where the "
                   f"velocity {shown(body.pull.velocity)} m/s leads, so that the line goes slack; it leads from the "
                   "body to the far end")


def _steps(scene):
    """Steps with inertia in which what falls leaves the grid many times over: contact is then searched everywhere."""
    longest = max(axis.end - axis.start for axis in scene.grid.axes)
    for s, stage in enumerate(scene.stages):
        step, fall = scene.step_of(stage), 0.5 * hypot(*scene.gravity) * scene.step_of(stage)**2
        if scene.time.inertia and fall > FALLS * longest:
            key = f"stage.{s}.step" if stage.step else "time.step"
            yield (f"{key} = {step:g} s looks wrong: what falls goes {fall:.3g} m in one step, and the grid is "
                   f"{longest:.3g} m long. Use hundredths of a second, or time.inertia = false if loads change slowly")
            return


def _grid(grid):
    for name in "xyz":
        axis = getattr(grid, name)
        if axis.end - axis.start > LONGEST and not axis.moves:
            yield f"grid.{name}, {axis.end - axis.start:g} m long, looks wrong: {MILLIMETRES}"
    sizes = {name: axis.smallest for name, axis in zip("xyz", grid.axes) if not axis.collapsed}
    small, large = min(sizes, key=sizes.get), max(sizes, key=sizes.get)
    if sizes[large] > SLENDER * sizes[small]:
        yield (f"grid.{large}.size = {sizes[large]:g} m beside grid.{small}.size = {sizes[small]:g} m looks wrong: "
               f"cells {sizes[large] / sizes[small]:.3g} times as long as they are wide resolve nothing along {large}, "
               "and the linear systems converge slowly")
