"""Steps too long for contact: a contact that comes and goes within a step makes or takes energy.

A box flies at 1 m/s to a held plane and bounces off it, m x'' = -k x while x < 0, in

    T_c = π √(m/k)        k = p_f E A        and leaves it with 1 m/s

Schemes without damping see the force at ends of steps only. Is T_c much less than Δt, a box that comes to the plane
after a share s of a step leaves with 3 - 4 s times its speed (s < 2/3): nine times its energy, or next to none. The
largest error of three s is taken. Energy-momentum is Newmark's scheme where nothing turns. The dissipative pair only
ever loses, 22 % of the speed with ten steps in T_c.
"""

import numpy as np

from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import SCHEMES, box, plane

TITLE = "steps too long for contact"
PARAMETERS = ("step over the time of contact, Δt / T_c",)
MEASURE, RIGHT, WRONG = "change of the speed by a bounce", 0.05, 0.25
METHODS = {"Newmark": {}, "generalised-alpha": SCHEMES["alpha"], "time.accuracy": {"accuracy": 1e-3}}
DEFAULT = "Newmark"
SAYS = r"unaccounted (gain|loss) of .*limit.*time\.step"
SIDE, HEIGHT, STIFFNESS = 1.2, 0.5, 1e6      # [m], [m], p_f E [Pa/m]
MASS, STARTS = 1000.0 * SIDE**2 * HEIGHT, (0.1, 0.5, 0.9)


def settings(quick=False):
    return [(ratio,) for ratio in ((0.3, 3.0) if quick else (0.03, 0.1, 0.2, 0.3, 0.5, 1.0, 3.0, 10.0))]


def solve(ratio, **time):
    """Seen of the worst of five bounces in steps of that ratio."""
    step = ratio * np.pi * np.sqrt(MASS / (STIFFNESS * SIDE**2))
    return worst([bounce(step, start, **time) for start in STARTS])


def worst(seen):
    """Seen of the largest error, and what was told if every one that failed told something."""
    failed = [found for found in seen if found.error > WRONG]
    told = dict.fromkeys(text for found in failed for text in found.told)
    return Seen(max(found.error for found in seen), tuple(told) if all(found.told for found in failed) else ())


def bounce(step, start, stiffness=STIFFNESS, **time):
    """Seen of a bounce that begins a share `start` of a step after the run."""
    contact = np.pi * np.sqrt(MASS / (stiffness * SIDE**2))
    body = box(SIDE, SIDE, HEIGHT, rest_on=start * step, velocity=(0.0, 0.0, -1.0), penalty=1.0)
    steps = int(1.5 * contact / step) + 6
    simulation, _, told = watched(plane(body, steps, step, stiffness=stiffness, time=time, cells=(4, 4)))
    speed = simulation.state.bodies[0].velocity[2]
    return Seen(abs(speed - 1.0), tuple(text for text in told if "energy balance" in text))
