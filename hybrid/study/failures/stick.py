"""Springs of stuck friction too soft: what rolls creeps.

A sphere rolls down a slope of 45° without slipping (`sphere`, μ = 1), over corners or, by the second pass, smoothly.

    d = 5/14 g t² sin θ        ω = 5/7 g sin θ t / r

A stuck point is a spring ε_T that starts unstretched where the surface is met and is let go where it is left, so the
sphere slides by a share of its way: a softer spring has to be stretched farther to carry the same friction.
"""

from hybrid.runtime.data import DEMOS
from hybrid.scene.file import load_scene
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.problems import sphere

TITLE = "springs of stuck friction too soft"
PARAMETERS = ("tangential over normal stiffness, ε_T / ε_N",)
MEASURE, RIGHT, WRONG = "error of the spin after 1 s", 0.03, 0.1
METHODS = {"first pass": {}, "second pass": {"changes": sphere.SAMPLES}}
DEFAULT = "first pass"
SAYS = r"tangential .* limit 0.3.*body\.tangential"


def settings(quick=False):
    return [(ratio,) for ratio in ((0.01,) if quick else (10.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.01, 0.001))]


def solve(ratio, changes=()):
    """Seen of a ride of a second."""
    scene = load_scene(DEMOS / "rolling_sphere.toml", [*sphere.overrides(1.0), *changes, f"body.0.tangential={ratio}"])
    simulation, _, told = watched(scene)
    start, end = simulation.initial_bodies[0], simulation.state.bodies[0]
    _, spin = sphere.missed(1.0, simulation.state.time, end.position[0] - start.position[0],
                            float((end.rotation @ end.spin)[1]))
    return Seen(abs(spin), tuple(text for text in told if "tangential" in text))
