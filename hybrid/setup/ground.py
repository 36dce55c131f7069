"""What the soil consists of: values of each layer at its points, weight, stress at rest, and the law of all points.

    σ_zz = -(weight above) / area      σ_xx = σ_yy = K0 σ_zz      E = E_ref (K0 σ_v / 100 kPa)^m where asked for
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.laws.cone import joined
from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.laws.hencky import Hencky
from hybrid.laws.sand import sand, stiffness_from_stress
from hybrid.laws.user import adopt
from hybrid.laws.von_mises import VonMises
from hybrid.laws.willam_warnke import WillamWarnke
from hybrid.runtime.errors import SceneError
from hybrid.scene.material import NUMBERS, of_layer
from hybrid.soil.points import overburden


@dataclass(frozen=True)
class Stratum:
    """A layer, or what lies in none: law's name, parameters by name, K0, top [m] and ids (m,) of its points."""

    name: str
    law: str
    values: dict
    k0: float
    top: float
    points: np.ndarray


def build_ground(described, constants, top, gravity, own_law=None):
    """(PointConstants with the layers' masses, principal stress (n, 3) [Pa] at rest, law) of a scene's soil.

    constants: of points tiled below `top` [m]; gravity (3,) [m/s²]; own_law: function that makes a law of one's own.
    """
    if (described.material.law == "user") != (own_law is not None):
        raise SceneError("soil.material.law = 'user' and build(scene, law=...) or run(scene, law=...) belong together; "
                         f"but law = {described.material.law!r} and {own_law and 'one' or 'none'} is given")
    strata = find_strata(described, constants.position[:, 2], top)
    density, k0 = np.empty(len(constants)), np.empty(len(constants))
    for s in strata:
        density[s.points], k0[s.points] = s.values["density"], s.k0
    constants = replace(constants, mass=density * constants.volume)
    sideways = np.stack([k0, k0, np.ones_like(k0)], axis=1)
    vertical = overburden(constants, np.linalg.norm(gravity))
    stress = np.zeros((len(constants), 3))
    if described.geostatic and not described.held:
        if np.any(gravity[:2] != 0.0) or gravity[2] > 0.0:
            raise SceneError(f"soil.geostatic needs gravity along -z, but gravity = {gravity.tolist()}; set "
                             "soil.geostatic = false and turn gravity on by stage.gravity = [0.0, 1.0], or turn the "
                             "scene")
        stress = -vertical[:, None] * sideways
        constants = replace(constants, geostatic_gradient=(density * np.linalg.norm(gravity))[:, None] * sideways)
    if own_law is not None:
        law = adopt(own_law(constants, stress.copy()), len(constants))
    else:
        laws = [build_law(s, k0[s.points] * vertical[s.points], s.top - constants.position[s.points, 2])
                for s in strata]
        law = laws[0] if len(laws) == 1 else joined(laws, [s.points for s in strata])
    if stress.any():
        _refuse_yielding(law, stress, top - constants.position[:, 2])
    return constants, stress, law


def find_strata(described, height, top):
    """Strata of points at `height` (n,) [m]; soil.material has those in no layer. SceneError for an empty layer."""
    strata, free = [], np.ones(len(height), bool)
    for i, layer in enumerate(described.layers):
        upper, lower = top if layer.top is None else layer.top, -np.inf if layer.bottom is None else layer.bottom
        inside = (height < upper) & (height >= lower)
        if not inside.any():
            raise SceneError(f"soil.layer.{i} ({layer.name}) holds no point: z = {lower:g} to {upper:g} m is outside "
                             "the soil, or thinner than a point; move its ends or refine grid.z")
        free &= ~inside
        k0 = described.k0 if layer.k0 is None else layer.k0
        strata.append(_stratum(layer.name, of_layer(described.material, layer), k0, upper, inside))
    if free.any():
        strata.append(_stratum("soil", described.material, described.k0, top, free))
    return strata


def _stratum(name, material, k0, top, inside):
    values = material_values(material)
    k0 = coefficient_at_rest(material.law, values) if k0 is None else k0
    return Stratum(name, material.law, values, k0, top, np.flatnonzero(inside))


def material_values(material):
    """Material parameters by name: the preset of the relative density, overridden by what the scene gives."""
    values = sand(material.relative_density, material.buoyant) if material.relative_density is not None else {}
    given = {name: getattr(material, name) for name in NUMBERS if getattr(material, name) is not None}
    if "young" in given:
        values.pop("reference_young", None)
    return {**values, **given, "cone": material.cone}


def coefficient_at_rest(law, material):
    """K0 = 1 - sin φ of sand, ν/(1 - ν) of an elastic soil and of clay in total stress; of a user's law 1."""
    if "friction_angle" in material and law != "hencky":
        return 1 - np.sin(np.radians(material["friction_angle"]))
    return material["poisson"] / (1 - material["poisson"]) if law != "user" else 1.0


def build_law(stratum, horizontal_stress, depth):
    """Law of a stratum with one row of parameters per point; stiffness follows the initial stress when asked to.

    horizontal_stress: (m,) [Pa] compression positive; depth: (m,) [m] below the stratum's top.
    """
    m, young = stratum.values, stratum.values.get("young")
    if young is None:
        young = stiffness_from_stress(m["reference_young"], m["stiffness_exponent"], horizontal_stress)
    young = np.broadcast_to(np.asarray(young, float), depth.shape)
    if stratum.law == "hencky":
        return Hencky(young, m["poisson"])
    hardening = m.get("hardening", 0.0)
    if stratum.law == "von-mises":
        strength = m["strength"] + m.get("strength_gradient", 0.0) * depth
        if strength.min() <= 0:
            at = depth[np.argmin(strength)]
            raise SceneError(f"{stratum.name}: strength_gradient = {m['strength_gradient']:g} Pa/m leaves "
                             f"{strength.min():.3g} Pa at a depth of {at:.3g} m; it must leave a strength everywhere")
        return VonMises(young, m["poisson"], strength, m["cone"], hardening, m.get("residual_strength", 0.0))
    angles = m["friction_angle"], m["dilation_angle"], m["cohesion"]
    floor = m.get("residual_cohesion", 0.0)
    if stratum.law == "willam-warnke":
        return WillamWarnke(young, m["poisson"], *angles, hardening, floor)
    return DruckerPrager(young, m["poisson"], *angles, m["cone"], hardening, floor)


def _refuse_yielding(law, stress, depth):
    """SceneError where the stress at rest is not one that the law can carry."""
    response = law.respond(law.strain(stress), np.zeros(len(stress)))
    miss = np.abs(response.stress - stress).max(axis=1) - 1e-9 * np.abs(stress).max()
    p = int(np.argmax(miss))
    if miss[p] > 0:
        shown = ", ".join(f"{value / 1e3:.4g}" for value in stress[p])
        raise SceneError(f"soil.geostatic: the stress at rest at a depth of {depth[p]:.3g} m, ({shown}) kPa along x, y "
                         "and z, is more than the law can carry; bring k0 nearer to 1 or raise the strength")
