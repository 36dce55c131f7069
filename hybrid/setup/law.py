"""The law of a soil layer: K0, stiffness that follows stress.

    E = E_ref (K0 σ_v / 100 kPa)^m      unless the scene gives one constant Young's modulus (FORMULATION (20))
"""

import numpy as np

from hybrid.laws.drucker_prager import DruckerPrager, cone_constants
from hybrid.laws.hencky import Hencky
from hybrid.laws.mohr_coulomb import MohrCoulomb
from hybrid.laws.sand import stiffness_from_stress
from hybrid.laws.von_mises import VonMises
from hybrid.laws.willam_warnke import WillamWarnke
from hybrid.runtime.errors import SceneError

MARGIN = 0.98       # of the slope of a cone that stress at rest may reach
SECTIONS = {"mohr-coulomb": MohrCoulomb, "willam-warnke": WillamWarnke}


def coefficient_at_rest(law, material):
    """K0 = 1 - sin φ of sand, or the lowest that its cone carries with a margin, (√3 - η)/(√3 + 2η), where that is larger:
    one matched in plane strain is weaker at rest; ν/(1 - ν) of an elastic soil and of clay in total stress; of a user's
    law 1."""
    if "friction_angle" in material and law != "hencky":
        k0 = 1 - np.sin(np.radians(material["friction_angle"]))
        if law != "drucker-prager":
            return k0
        slope = MARGIN * cone_constants(material["friction_angle"], material["dilation_angle"], material["cone"])[0]
        return max(k0, (np.sqrt(3) - slope) / (np.sqrt(3) + 2 * slope))
    return material["poisson"] / (1 - material["poisson"]) if law != "user" else 1.0


def build_law(stratum, horizontal_stress, depth):
    """Law of a stratum with one row of parameters per point; stiffness follows the initial stress when asked to.

    horizontal_stress: (m,) [Pa] compression positive; depth: (m,) [m] below the stratum's top.
    """
    m, young = stratum.values, stratum.values.get("young")
    if young is None:
        young = stiffness_from_stress(m["reference_young"], m["stiffness_exponent"], horizontal_stress)
        if len(young) and young.min() <= 0.0:
            raise SceneError(f"{stratum.name}: reference_young = {m['reference_young']:g} Pa follows the stress of the "
                             f"soil's weight and leaves E = {young.min():g} Pa; it must be above 0: give young, or gravity "
                             "along -z")
    young = np.broadcast_to(np.asarray(young, float), depth.shape)
    if stratum.law == "hencky":
        return Hencky(young, m["poisson"])
    hardening = m.get("hardening", 0.0)
    if stratum.law == "von-mises":
        strength = m["strength"] + m.get("strength_gradient", 0.0) * depth
        if strength.min(initial=np.inf) <= 0:
            at = depth[np.argmin(strength)]
            raise SceneError(f"{stratum.name}: strength_gradient = {m['strength_gradient']:g} Pa/m leaves "
                             f"{strength.min():.3g} Pa at a depth of {at:.3g} m; it must leave a strength everywhere")
        return VonMises(young, m["poisson"], strength, m["cone"], hardening, m.get("residual_strength", 0.0))
    angles = m["friction_angle"], m["dilation_angle"], m["cohesion"]
    floor = m.get("residual_cohesion", 0.0)
    if stratum.law in SECTIONS:
        return SECTIONS[stratum.law](young, m["poisson"], *angles, hardening, floor)
    return DruckerPrager(young, m["poisson"], *angles, m["cone"], hardening, floor)
