"""Keys that a scene leaves out and whose values follow from its physics: the one place where they are decided.

A rule is a function of the scene and of the table that the key is in. It returns the value and the reason, which the
model sheet shows (no reason: the value has no effect). A value that the scene gives is never changed. With method =
"published" the keys left out have the values of the published method instead.

`RULES` is in the order in which keys are decided: a rule may read the keys above its own, which are no longer None.
"""

from dataclasses import replace
from math import hypot, inf
from typing import NamedTuple

from hybrid.scene.schema import Body, Material, Soil, Time
from hybrid.scene.soil import USES, clay_layers, ends, laws, materials
from hybrid.scene.table import shown

STANDARD_GRAVITY = 9.81     # [m/s²] what sizes and stresses are judged by where a scene has none
SCHEME = "generalised-alpha"
POISSON = 0.4           # from which on elastic soil bends better with F-bar: DESIGN, "F-bar where volume is kept"
GHOST = 0.3             # factor on Young's modulus: DESIGN, "The ghost penalty leaves full cells alone"
GHOST_FLOW = 0.03       # the same in soil that flows along bodies in space
# Factor on s_u of clay without bodies and with inertia, where mass keeps cells with little soil in place as well, if soil
# falls by this share of a cell, g Δt², at most in a step
GHOST_STRENGTH, FALL = 1.5, 0.25
ROLLING, SLIDING = 3.0, 0.3     # ε_T / ε_N of a body that rolls, and of one that sticks at some points and slips at others


class Decision(NamedTuple):
    """A key in the notation of a scene file, the value it was given, and why."""

    key: str
    value: object
    reason: str

    def __str__(self):
        return f"{self.key} = {shown(self.value)}: {self.reason}"


def resolve(scene):
    """(Scene in which every key of `RULES` has a value, tuple of the Decisions that were taken for it)."""
    decisions = []
    scene = _without_level_ground(scene)
    for cls, name in RULES:
        scene = _decide(scene, cls, name, decisions)
    return scene, tuple(decision for decision in decisions if decision.reason)


def _without_level_ground(scene):
    """A Scene whose ground takes nothing away from the soil as one without."""
    ground, (_, top) = scene.soil.ground, ends(scene.soil, scene.grid)
    if ground is None:
        return scene
    from hybrid.scene.ground import heights     # late: it needs numpy

    if heights(ground)[2].min() < top:
        return scene
    return replace(scene, soil=replace(scene.soil, ground=None))


def _decide(scene, cls, name, decisions):
    """Scene with the key `name` of all tables of a class decided."""
    rule, published = RULES[cls, name]

    def decided(table, path):
        if getattr(table, name) is not None:
            return table
        value, reason = rule(scene, table)
        if value is None:       # nothing in the scene uses it
            return table
        if scene.method == "published" and published is not None:
            value, reason = published, reason and "the published method"
        decisions.append(Decision(f"{path}.{name}", value, reason))
        return replace(table, **{name: value})

    if cls is Material:
        return replace(scene, soil=replace(scene.soil, material=decided(scene.soil.material, "soil.material")))
    if cls is Body:
        return replace(scene, bodies=tuple(decided(body, f"body.{i}") for i, body in enumerate(scene.bodies)))
    table = cls.__name__.lower()
    return replace(scene, **{table: decided(getattr(scene, table), table)})


# ------------------------------------------------------------------ rules: (scene, table) -> (value, reason)


def _law(scene, material):
    undrained = material.strength is not None or material.strength_gradient is not None
    if undrained and all(value is None for value in (material.friction_angle, material.cohesion, material.relative_density)):
        return "von-mises", "its strength is undrained"
    if scene.method == "published" or material.cone is not None:
        return "drucker-prager", "the published method" if material.cone is None else "it has a cone"
    if any(_collapsed(scene)):
        return "drucker-prager", "the scene has one kind of stress state, in which a cone has Mohr-Coulomb's strength"
    if material.relative_density is not None:
        return ("willam-warnke",
                "sand has its friction angle in compression and in extension, and more where it shears in a plane")
    return "mohr-coulomb", "its friction angle is that in any stress state"


def _cone(scene, material):
    if not any("cone" in USES[law] for law in laws(scene.soil)):
        return None, "no law of the soil is a circular cone"
    if sum(_collapsed(scene)) == 1:
        return "plane strain", "the scene is in plane strain, where the cone has Mohr-Coulomb's or Tresca's strength"
    cones = [clay for m, clay in zip(materials(scene.soil), clay_layers(scene.soil)) if m.law == "drucker-prager"]
    if all(cones) and not any(_collapsed(scene)):
        return "plane strain", ("sheared in a plane clay has s_u, and nowhere more than Tresca's law; with s_u of "
                                "triaxial compression there, set compression: 1.15 times as strong")
    return "compression", "the strength in triaxial compression is that of Mohr-Coulomb or Tresca"


def _fbar(scene, soil):
    if soil.held:
        return False, "held soil does not deform"
    if soil.basis == "mpm":
        return False, "standard points take another volume change at once when they cross into a cell"
    flowing = _plastic_laws(soil)
    if flowing:
        return True, f"plastic flow hardly changes the volume and would lock (law = '{flowing[0]}')"
    poisson = max(soil.material.poisson or 0.0, *(layer.material.get("poisson", 0.0) for layer in soil.layers), 0.0)
    if poisson >= POISSON:
        return True, f"nearly incompressible soil would lock (poisson = {poisson:g}, limit {POISSON:g})"
    return False, "elastic soil that changes its volume bends better without"


def _ghost(scene, soil):
    if soil.held:
        return 0.0, "held soil does not deform"
    follow = "cells with little soil follow the fullest of their neighbours"
    flows_along = scene.bodies and _plastic_laws(soil) and not any(_collapsed(scene))
    factor, reason = (GHOST_FLOW, f"{follow}, loosely as soil flows along bodies") if flows_along else (GHOST, follow)
    if all(clay_layers(soil)) and not scene.bodies and _follows_flow(scene):
        loose = float(f"{GHOST_STRENGTH * _largest_strength(scene, soil):.2g}")
        if 0.0 < loose < factor:
            return loose, f"{follow}, by {GHOST_STRENGTH:g} s_u, as clay that runs out is not to be braked"
    return factor, reason


def _follows_flow(scene):
    """Whether inertia holds soil back: in a step it falls by FALL of a cell at most."""
    smallest = min((axis.smallest for axis in scene.grid.axes if not axis.collapsed), default=0.0)
    longest = max((scene.step_of(stage) for stage in scene.stages), default=scene.time.step)
    return scene.time.inertia and hypot(*scene.gravity) * longest**2 < FALL * smallest


def _largest_strength(scene, soil):
    """Largest s_u over Young's modulus [-] of clay, at its greatest depth."""
    bottom, top = ends(soil, scene.grid)
    found = materials(soil)
    return max(((m.strength or 0.0) + max(m.strength_gradient or 0.0, 0.0) * (top - bottom)) / (m.young or inf)
               for m in found)


def _collapsed(scene):
    return [axis.collapsed for axis in scene.grid.axes]


def _plastic_laws(soil):
    """Names of the laws of the soil and its layers that yield."""
    return sorted(laws(soil) - {"hencky"})


def _contact(scene, body):
    if scene.soil.basis == "mpm":
        return "corners", "points of the standard basis have no faces"
    return "faces", "contact does not depend on where the soil's points lie under a body"


def _tangential(scene, body):
    if body.contact == "corners":
        return 1.0, "as stiff as the normal springs"
    if body.adhesion:   # a pipe laid on clay: 450 iterations instead of 2000
        return SLIDING, "clay that sticks slips after much less than a hundredth of a cell, and needs fewer iterations"
    # a rolling body creeps by (T/N) (a/r) ε_N / (3 ε_T), a the half-width of its contact: 1 % of a steep ride with 1
    return ROLLING, "stiffer than the normal springs, so that a rolling body hardly creeps"


def _adhesion(scene, body):
    if scene.method == "published" or not body.friction or scene.soil.held or not any(clay_layers(scene.soil)):
        return None, ""
    # pressed by 20 s_u and without this limit, a rough cylinder in cells of an eighth of its width takes 14 % too much
    # with it
    return 1.0, "clay shears by itself before a body feels more than its strength"


def _scheme(scene, time):
    if time.beta is not None or time.gamma is not None:
        return "newmark", "beta and gamma are those of Newmark's scheme"
    if not time.inertia:
        return SCHEME, ""
    return SCHEME, "of second order; oscillations too fast for the step die out, and contact throws no body back"


RULES = {   # (class, key): (rule, value of the published method; None: that of the rule)
    (Material, "law"): (_law, None),
    (Material, "cone"): (_cone, "compression"),
    (Soil, "fbar"): (_fbar, False),
    (Soil, "ghost"): (_ghost, 0.0),
    (Body, "contact"): (_contact, "corners"),
    (Body, "adhesion"): (_adhesion, None),
    (Body, "tangential"): (_tangential, 1.0),
    (Time, "scheme"): (_scheme, "newmark"),
}
