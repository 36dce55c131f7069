"""Tension: a cone of friction ends in an apex, and a return that only knows its flank lets soil hang on its tension.

    ____________   bed of sand, 4 m, held at its floor and sides, φ = 30°, ψ = 0, cohesion c, without stress at the
    |          |   start, and gravity upwards: it comes loose from the floor and flies
    |__________|   k = ξ c, tension at the apex p_t = k/η = c cotφ, but for the layer at the floor

With ψ = 0 the flank returns the trial stress at constant p, so a p beyond the apex stays as it is: sand that is elastic
in tension. Returned to the apex all directions flow, with no stiffness left there; inertia carries the points. Exact:
the upper half of the bed, where only p_t holds it back, rises by ½ (g - p_t/ρL) t², and no point carries more than p_t.
"""

from math import radians, tan

import numpy as np

from hybrid.laws import Response
from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen

TITLE = "sand without cohesion in tension"
PARAMETERS = ("cohesion over ρ g L",)
MEASURE, RIGHT, WRONG = "error of the rise, or tension beyond the apex over ρ g L", 0.05, 0.25
METHODS = {"flank of the cone alone": {"law": "flank"}, "cone and apex": {}, "Willam-Warnke": {"law": "willam-warnke"}}
DEFAULT = "cone and apex"
SAYS = "nothing fails that says so"
LENGTH, CELLS, DENSITY, GRAVITY, ANGLE, YOUNG, DURATION, STEPS = 4.0, 8, 1600.0, 10.0, 30.0, 1e7, 0.4, 20


def settings(quick=False):
    return [(share,) for share in ((0.01, 0.0) if quick else (1.0, 0.1, 0.01, 1e-4, 1e-6, 0.0))]


class Flank(DruckerPrager):
    """Drucker-Prager without dilation and without an apex: beyond it only the mean stress is left, and elastic."""

    def respond(self, strain, plastic_strain=None):
        response, (bulk, _, eta, _, strength) = super().respond(strain, plastic_strain), self.parameters.T[:5]
        volume = strain.sum(axis=1)
        beyond = (eta * bulk * volume > strength)[:, None]
        mean = np.repeat((bulk * volume)[:, None], 3, axis=1)
        return Response(np.where(beyond, mean, response.stress), np.where(beyond, mean / (3 * bulk[:, None]),
                        response.elastic), np.where(beyond[:, None], bulk[:, None, None], response.tangent))


def solve(share, law="drucker-prager"):
    """Seen of the bed with that cohesion."""
    weight, size = DENSITY * GRAVITY * LENGTH, LENGTH / CELLS
    tension = share * weight / tan(radians(ANGLE))
    own = law == "flank"
    values = {"young": YOUNG, "poisson": 0.25, "friction_angle": ANGLE, "dilation_angle": 0.0,
              "cohesion": share * weight}
    material = Material(law="user", density=DENSITY) if own else Material(law=law, density=DENSITY, **values)
    scene = Scene(
        name="bed", soil=Soil(material, geostatic=False, top=LENGTH), gravity=(0.0, 0.0, GRAVITY),
        grid=Grid(Axis(start=0.0, end=4 * size, size=size), Axis(start=0.0, end=size, collapsed=True),
                  Axis(start=0.0, end=LENGTH + 2.0, size=size), Faces()),
        time=Time(DURATION / STEPS), stages=(Stage("fly", STEPS),), output=Output(every=0, checkpoint=0))
    simulation, _, _ = watched(
        scene, law=(lambda p, stress: Flank(np.full(len(p), YOUNG), 0.25, ANGLE, 0.0, share * weight)) if own else None)
    points, start = simulation.state.points, simulation.initial_position
    rise = (points.position - start)[start[:, 2] > LENGTH / 2, 2].mean()
    free = 0.5 * max(GRAVITY - tension / (DENSITY * LENGTH), 0.0) * DURATION**2
    mean = np.trace(points.stress, axis1=1, axis2=2) / 3
    return Seen(float(max(abs(rise - free) / (0.5 * GRAVITY * DURATION**2), (mean.max() - tension) / weight)))
