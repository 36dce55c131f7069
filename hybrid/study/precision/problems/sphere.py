"""A sphere rolls or slides down a rough slope for a second: contact alone, the soil of the slope being held.

    slides, tan θ > 3.5 μ:   d = ½ g t² (sin θ - μ cos θ)     ω = 5 μ g cos θ t / (2 r)
    rolls:                   d = 5/14 g t² sin θ              ω = 5/7 g sin θ t / r

θ = 45°, r = 0.25 m (Fig. 2a of Bird et al., UKACM 2024); the scene is demos/rolling_sphere.toml. A run is four rides: μ
= 0.2 slides and μ = 0.4 rolls, each from two starts half a spacing of corners apart: on the lattice of corners of the
published method the result depends by some per cent on where a ride starts. Errors are root mean squares over the
rides, times and iterations are sums.
"""

from dataclasses import dataclass, replace
from time import process_time

import numpy as np

from hybrid.bench.timed_steps import newton_iterations, sizes, timed_steps
from hybrid.runtime.data import DEMOS
from hybrid.scene.file import load_scene
from hybrid.setup.build import build
from hybrid.simulation import Simulation
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import RunResult
from hybrid.study.precision.settings import PUBLISHED

GRAVITY, RADIUS, SLOPE = 9.81, 0.25, np.pi / 4
SPACING = 0.125     # [m] of the corners
MU, STARTS = (0.2, 0.4), (0.0, 0.5)     # starts in spacings
# A penalty that balances overlap and bouncing on corners, which grows as s⁻³ with finer ones, and damping.
CORNERS, PENALTY = ["method=published", "time.beta=0.5625", "time.gamma=1.0"], 20.0


def law(mu, time, radius=RADIUS):
    """Distance [m] and spin [rad/s] of a smooth sphere from rest."""
    down, across = GRAVITY * np.sin(SLOPE), GRAVITY * np.cos(SLOPE)
    if np.tan(SLOPE) > 3.5 * mu:
        return 0.5 * (down - mu * across) * time**2, 2.5 * mu * across * time / radius
    return 5 / 14 * down * time**2, 5 / 7 * down * time / radius


def missed(mu, time, distance, spin):
    """Relative errors [-] of distance and spin at a time; of the spin relative to that of rolling if the exact one is
    0."""
    exact, rolling = law(mu, time), law(1.0, time)
    return distance / exact[0] - 1, (spin - exact[1]) / (exact[1] or rolling[1])


def overrides(mu, refinement=1):
    """Changes to rolling_sphere.toml: friction, and the lengths that are divided by the refinement."""
    n, fine = refinement, [f"body.0.friction={mu}"]
    if n > 1:
        fine += [f"grid.{axis}.size={0.25 / n}" for axis in "xyz"]
        fine += [f"grid.z.start={-0.25 / n}", "grid.x.end=4.5", "grid.y.start=2.25", "grid.y.end=2.75"]
        fine += [f"body.0.position=[0.6, {2.5 + 0.0625 / n}, 0.0]"]
        fine += [f"body.0.parameters.size={0.05 / n}", "body.0.parameters.growth=0.5"]  # coarser inside
    return fine


def corners(refinement=1):
    """Changes to rolling_sphere.toml: the published method."""
    return [*CORNERS, f"body.0.penalty={PENALTY * refinement**3}"]


def curves(quick):
    """Refinements of spacing, facets and penalty together, and other parameters at one of them."""
    if quick:
        return {"default": _refined((1, 2)), PUBLISHED: _corners((1, 2))}
    return {
        "default": _refined((1, 2, 4)),
        PUBLISHED: _corners((1, 2, 4)),
        "facets": _facets((0.1, 0.035)),
        "Newmark": _refined((1, 2), time={"scheme": "newmark"}),
        "energy-momentum": _refined((1, 2), time={"scheme": "energy-momentum"}),
        "Newton tolerance": [(f"{t:g}", {"changes": [f"solver.tolerance={t}"]}) for t in (1e-2, 1e-4)],
        "time step": _lasting((0.04, 0.02, 0.005)),
        "time step, half spacing": _lasting((0.04, 0.02), refinement=2),
        "penalty factor": _stiff((20.0, 100.0, 400.0)),
        "published method, penalty": _stiff((5.0, 40.0), CORNERS)}


def _refined(refinements, **values):
    return [(f"s = {SPACING / n:g} m", {"refinement": n, **values}) for n in refinements]


def _corners(refinements):
    return [(f"s = {SPACING / n:g} m", {"refinement": n, "changes": corners(n)}) for n in refinements]


def _facets(sizes):
    return [(f"facets {size:g} m", {"changes": [f"body.0.parameters.size={size}", "body.0.parameters.growth=0.5"]})
            for size in sizes]


def _lasting(steps, **values):
    return [(f"Δt = {step:g} s", {"time": {"step": step}, **values}) for step in steps]


def _stiff(penalties, changes=()):
    return [(f"p_f = {p:g} /m", {"changes": [*changes, f"body.0.penalty={p}"]}) for p in penalties]


@dataclass(frozen=True)
class Ride:
    """One second: time at its end [s], distance [m], spin [rad/s], Newton iterations and processor time of its steps [s]."""

    mu: float
    time: float
    distance: float
    spin: float
    newton: int
    seconds: float


def solve(**values):
    """RunResult of the four rides; `values` are those of `rides`. Raises StepError if a step fails."""
    size, taken = rides(**values)
    return RunResult(errors(taken), sum(ride.newton for ride in taken), size, sum(ride.seconds for ride in taken))


def errors(taken):
    """{error: root mean square over the Rides}."""
    each = [missed(ride.mu, ride.time, ride.distance, ride.spin) for ride in taken]
    return dict(zip(("distance", "spin"), np.sqrt(np.mean(np.square(each), axis=0)).tolist()))


def rides(refinement=1, time=None, changes=()):
    """(unknowns, Rides). time: values of the time table that differ; a scheme has its own β and γ; changes:
    overrides of the scene in addition to those of its refinement."""
    scene, time = load_scene(DEMOS / "rolling_sphere.toml", [*overrides(MU[0], refinement), *changes]), time or {}
    time = replace(scene.time, **{**({"beta": None, "gamma": None} if "scheme" in time else {}), **time})
    stage = replace(scene.stages[0], steps=round(1 / time.step))
    built = build(replace(scene, time=time, stages=(stage,)))
    return sizes(built)["unknowns"], [ride(built, mu, start * SPACING / refinement) for mu in MU for start in STARTS]


def ride(built, mu, shift):
    """Ride under the friction `mu` from a start shifted by `shift` [m] down the slope."""
    body, state = replace(built.model.bodies[0], friction=mu), built.state.bodies[0]
    start = state.position + (shift, 0.0, 0.0)
    simulation = Simulation(built.scene, replace(built.model, bodies=(body,)),
                            replace(built.state, bodies=[replace(state, position=start)]), built.meshes)
    records, seconds = timed_steps(simulation, clock=process_time)
    end = simulation.state.bodies[0]
    return Ride(mu, simulation.state.time, float(end.position[0] - start[0]), float((end.rotation @ end.spin)[1]),
                newton_iterations(records), sum(seconds))


PROBLEM = Problem(
    title="rolling sphere",
    errors={"distance": "|d/d_exact - 1| after 1 s, rms over μ = 0.2, 0.4 and two starts [-]",
            "spin": "|ω/ω_exact - 1| after 1 s, rms over μ = 0.2, 0.4 and two starts [-]"},
    shown=(PUBLISHED, "Newmark", "energy-momentum", "facets", "Newton tolerance"),
    chosen=("time step", "time step, half spacing"), curves=curves, solve=solve)
