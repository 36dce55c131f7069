"""Failure modes of the increments: time steps, load steps, impacts, and the tolerance of a step."""

from contextlib import ExitStack
from unittest import mock

import numpy as np

from hybrid.monitors import Monitors
from hybrid.scene import Axis, Faces, Grid, Material, Soil, Solver, Stage, Time
from hybrid.step import rejection
from hybrid.study.failure.mode import Mode, matching
from hybrid.study.failure.outcome import Observation
from hybrid.study.failure.simulate import simulate
from hybrid.study.precision.problems import tumbling
from hybrid.study.scenes import (
    SCHEMES,
    box,
    collapsed,
    driven,
    elastic,
    loaded_by_weight,
    plane,
    scene,
    soil_scene,
    steel,
)

ADAPTIVE = {"accuracy": 1e-3}       # values of the table [time]


def large_rotation_step(angle, **time):
    """Steps that rotate a body too far: rotation vectors are additive only while small, and ambiguous beyond half a
    turn.

    A box of 1 x 0.7 x 0.3 m tumbles freely about its intermediate axis, through ten radians of its spin W(0), |Θ|
    radians a step.

        J Ẇ + W × J W = 0      R' = R W̃          attitude integrated to round-off (`tumbling.reference`)

    A step loses a share of |Θ|³ of the attitude, of |Θ|² with the dissipative pair: after 10 rad that is 0.24 |Θ|² with
    Newmark's (1/4, 1/2), 1.0 |Θ|² with energy-momentum, 1.5 |Θ| with (0.5625, 1), measured. Beyond 2 rad the program
    halves the step, because log(R_nᵀ R) takes a rotation by |Θ| > π for one by 2π - |Θ| the other way. Smaller steps
    are all accepted; only `time.accuracy` estimates their error.
    """
    spin, total = np.array([0.3, 1.0, 0.3]), 10.0     # [rad/s], [rad]
    side, speed = Axis(start=-0.5, end=0.5, size=0.5), np.linalg.norm(spin)
    step, steps = angle / speed, round(total / angle)
    simulation, _, texts = simulate(scene(
        "rotation", Grid(side, side, Axis(start=-3.0, end=-2.0, size=0.5), Faces()), elastic(1e6),
        [box(1.0, 0.7, 0.3, spin=tuple(spin))], step, [Stage("fly", steps)], {"held": True}, time,
        {"tolerance": 1e-10}))
    top = tumbling.Top(simulation.masses[0].inertia, spin, np.eye(3), np.zeros(3), np.zeros(3))
    error, _ = tumbling.apart(simulation.state.bodies[0], tumbling.reference(top, steps * step))
    return Observation(error, texts)


SIDE, HEIGHT, STIFFNESS = 1.2, 0.5, 1e6      # of the bouncing box [m], [m]; p_f E [Pa/m]
MASS, BOUNCE_WRONG = 1000.0 * SIDE**2 * HEIGHT, 0.25
ENERGY = r"unaccounted (gain|loss) of .*limit.*time\.step|impact on held ground: .*limit.*time\.|adds .* m to the error of"


def bounce_step(ratio, **time):
    """Steps too long for contact: a contact that closes and opens within a step generates or loses energy.

    A box flies at 1 m/s to a held plane and bounces off it, m x'' = -k x while x < 0, in

        T_c = π √(m/k)        k = p_f E A        and leaves it with 1 m/s

    Schemes without damping evaluate the force at the ends of steps only. If T_c is much shorter than Δt, a box that
    reaches the plane after a share s of a step leaves with 3 - 4 s times its speed (s < 2/3): with up to nine times its
    energy, or hardly any. The largest error of three values of s counts. Energy-momentum is Newmark's scheme where
    nothing rotates. The dissipative pair only loses energy, 22 % of the speed with ten steps in T_c.
    """
    step = ratio * np.pi * np.sqrt(MASS / (STIFFNESS * SIDE**2))
    return _worst([_bounce(step, start, **time) for start in (0.1, 0.5, 0.9)])


def bounce_map(step, stiffness, **time):
    """Time step and penalty: the stiffer the contact, the shorter the step that resolves it.

    The bounce of `bounce_step`, whose contact time T_c = π √(m / (p_f E A)) is 70 ms at p_f E = 1 MPa/m, over time step
    and penalty: runs fail above the line Δt = T_c / 2. The larger error of two values of s counts.
    """
    return _worst([_bounce(step, start, stiffness, **time) for start in (0.5, 0.9)])


def _worst(observations):
    """Observation of the largest error; its messages are those of all failed runs, none if one of them was silent."""
    failed = [matching(ENERGY, o.messages) for o in observations if o.error > BOUNCE_WRONG]
    texts = tuple(dict.fromkeys(text for messages in failed for text in messages))
    return Observation(max(o.error for o in observations), texts if all(failed) else ())


def _bounce(step, start, stiffness=STIFFNESS, **time):
    """Observation of a bounce of a box that would reach the plane a share `start` of a step after the start."""
    contact = np.pi * np.sqrt(MASS / (stiffness * SIDE**2))
    body = box(SIDE, SIDE, HEIGHT, rest_on=start * step, velocity=(0.0, 0.0, -1.0), penalty=1.0)
    steps = int(1.5 * contact / step) + 20     # until what an impact has cost is known
    simulation, _, texts = simulate(plane(body, steps, step, stiffness=stiffness, time=time, cells=(4, 4)))
    return Observation(abs(simulation.state.bodies[0].velocity[2] - 1.0), texts)


LENGTH, CELL = 8.0, 0.25                # of the elastic column under impact [m]
YOUNG, DENSITY = 1e6, 1000.0            # [Pa], [kg/m³]
WAVE, SPEED = np.sqrt(YOUNG / DENSITY), 0.1     # of waves and of the impact [m/s]


def force_oscillation(courant, **time):
    """Oscillating forces: vibrations of the finest cells after an impact are not damped, and exceed the mean force.

    A plate reaches a column of 32 elastic cells at v = 0.1 m/s and continues at that speed. Until its wave is back,

        F = ρ c v A         c = √(E/ρ), the Courant number is c Δt / h

    The penalty spring and the first cell oscillate against each other and contact is lost in every period: F jumps
    between 0 and 2 to 4 times ρ c v A at any time step, while its mean is right. The error is the root mean square of F
    / (ρ c v A) - 1 over the last four fifths of 1.6 L/c, when a front that extends over some cells has passed.
    """
    plate = driven(1.0, 1.0, 0.5, velocity=(0.0, 0.0, -SPEED), position=(CELL / 2, CELL / 2, 0.0), rest_on=LENGTH)
    _, records, texts = simulate(_impact(plate, courant * CELL / WAVE, 1.6, time))
    force = np.array([record.bodies[0].contact_force[2] for record in records]) / (DENSITY * WAVE * SPEED * CELL**2)
    late = force[len(force) // 5:]
    return Observation(float(np.sqrt(np.mean((late - 1) ** 2))), texts)


def light_body(ratio, **time):
    """Bodies much lighter than the soil they hit: the nodes throw them back before a wave can stop them.

    A box of mass M falls at v = 0.1 m/s on a column of 32 elastic cells of height h. Until its wave is back,

        M v' = -ρ c A v         v(t) = v exp(-t/τ)         τ = M / (ρ c A)

    The nodes at the surface carry half a row of cells, ρ h A / 2, as one mass. A heavier body is stopped by many rows
    in turn; a lighter one meets a mass at rest and a contact spring, and is thrown back: at its initial speed in that
    model, at up to three times that speed if the step is longer than the contact (`bounce_step`).
    """
    body = box(1.0, 1.0, 0.5, density=ratio * DENSITY * CELL / 0.5, velocity=(0.0, 0.0, -SPEED),
               position=(CELL / 2, CELL / 2, 0.0), rest_on=LENGTH, held=("x", "y", "rx", "ry", "rz"))
    simulation, records, texts = simulate(_impact(body, 1.0 * CELL / WAVE, 1.5, time))
    exact = -SPEED * np.exp(-records[-1].time * WAVE / (ratio * CELL))
    return Observation(abs(simulation.state.bodies[0].velocity[2] - exact) / SPEED, texts)


def _impact(body, step, passages, time):
    """Scene of a body that hits an elastic column; passages: duration over the time L/c of a wave through it."""
    side, up = Axis(0.0, CELL, CELL, collapsed=True), Axis(0.0, LENGTH + 4 * CELL, CELL)
    return scene("impact", Grid(side, side, up, Faces(z_min="fixed")), elastic(YOUNG), [body], step,
                 [Stage("hit", int(passages * LENGTH / WAVE / step))], soil={"top": LENGTH}, time=time)


def tunnelling(way, checked=True, **body):
    """Tunnelling: an impact that covers more than the body's thickness in a step; Newton's method converges with the
    plate on the other side of the soil.

    A plate of 40 mm is thrown at elastic soil at 5 m/s, over corners s = 0.1 m apart, from 10 mm above it. Of the two
    equilibria at the end of a long step, the plate stopped by the soil and the plate beyond it, the second is closer to
    the first guess v Δt. Exact: all of the soil under the plate stays under it.

    The program checks the path of every contact point and halves a step in which one passes through a body
    (`hybrid.contact.tunnelling`). The speed of the plate after the impact is the subject of `bounce_step`.
    """
    speed, spacing, duration = 5.0, 0.1, 0.12
    step = way * spacing / speed
    plate = steel(0.5, 0.5, 0.04, size=0.25, rest_on=0.01, position=(0.4, 0.4, 0.0), velocity=(0.0, 0.0, -speed),
                  **body)
    plain = {"line_search": False, "tangent_tolerance": 0.0}
    solver = Solver(tolerance=1e-4, **({} if checked else plain))
    thrown = soil_scene([plate], z=(-0.8, 0.6), young=5e6, poisson=0.2, time=Time(step=step), solver=solver,
                        steps=max(2, round(duration / step)))
    with ExitStack() as unchecked:
        if not checked:     # a run in which a body has gone through the soil is stopped as well
            unchecked.enter_context(mock.patch.object(rejection, "tunnelled", lambda step, evaluation: 0))
            unchecked.enter_context(mock.patch.object(Monitors, "stop", lambda self, view: ""))
        simulation, _, texts = simulate(thrown)
    points, middle = simulation.state.points, simulation.state.bodies[0].position
    under = np.abs(simulation.initial_position[:, :2] - middle[:2]).max(axis=1) < 0.2
    return Observation(float(np.mean(points.position[under, 2] > middle[2])), texts)


def plastic_step(steps, share=1, smallest=None):
    """Load steps too long for plastic flow: they do not converge, or converge to a wrong state.

        z |_______        bank of clay, 2 x 2 m, on a rough floor, smooth wall at its left, E = 100 s_u; its weight
          |       |       ρ g L = 5 s_u grows in 1 to 50 quasi-static steps. Its edge sinks by 0.1 m and its foot
          |_______|__ x   moves out by 0.13 m; above 3.8 s_u its shape and locking keep it standing

    A return mapping takes the direction of flow at the end of an increment, and points keep the basis of its start.
    Newton's method may find no state at all, which halving the increment cures; or it converges to a displacement 31 %
    too small, which no residual shows. The largest growth of a point's plastic strain in an increment does. Reference:
    the mean displacement along x in 100 steps, within 1 % of that in 5 to 50 (with the same cells, which lock).
    """
    length, density, gravity = 2.0, 1800.0, 10.0
    size, strength = length / 8, density * gravity * length / 5.0
    clay = Material(law="von-mises", young=100 * strength, poisson=0.45, density=density, strength=strength)
    grid = Grid(Axis(start=0.0, end=2 * length, size=size), collapsed(), Axis(start=0.0, end=length + size, size=size),
                Faces("roller", "free", z_min="fixed"))
    soil = Soil(clay, geostatic=False, lower=(0.0, 0.0, 0.0), upper=(length, 1.0, length), fbar=False, ghost=0.0)
    simulation, _, texts = simulate(loaded_by_weight(
        "bank", grid, soil, share * steps, -gravity, time=Time(1.0, inertia=False, smallest=smallest)))
    displacement = (simulation.state.points.position - simulation.initial_position)[:, 0].mean()
    return Observation(float(abs(displacement / 0.0403 - 1)), texts)


def round_off(share, **solver):
    """Hardly any weight: the residual relative to the acting forces cannot fall below the round-off of the stiffness.

        | . . . |   block of 1 x 1 x 2 m between rollers, K = 8.3 MPa, ν = 0.3, under a share of gravity, in 2
        | . . . |   quasi-static steps, initially without stress
        |_______|

    F = 1 + strain resolves a strain to 2e-16, stress to K 2e-16 = 2e-9 Pa, and forces over faces of h² to 5e-10 N. A
    weight of 20 kN and a tolerance of 1e-6 leave a margin of 7 powers of ten. With less weight the tolerance is below
    round-off; the residual is accepted as it is while it is small beside the forces. Without any, all forces vanish, and
    nothing may be divided by them. Exact: the mean of σ_zz is -ρ g L/2 by equilibrium alone.
    """
    size, height, density, gravity = 0.5, 2.0, 1000.0, 10.0
    side = Axis(start=0.0, end=1.0, size=size)
    soil = Soil(Material(law="hencky", young=1e7, poisson=0.3, density=density), geostatic=False, top=height)
    grid = Grid(side, side, Axis(start=0.0, end=height + size, size=size), Faces())
    simulation, _, texts = simulate(loaded_by_weight("block", grid, soil, 2, -share * gravity, solver=Solver(**solver)))
    stress, weight = simulation.state.points.stress[:, 2, 2].mean(), share * density * gravity * height
    return Observation(float(abs(stress + weight / 2) / weight if share else abs(stress)), texts)


DISSIPATIVE, NEWMARK = {"Newmark (0.5625, 1)": SCHEMES["dissipative"]}, {"Newmark": SCHEMES["newmark"]}
CORNERS = {"contact": "corners", "penalty": 50.0}
ASYMPTOTIC = "generalised-alpha, ρ∞ = 0"   # the default of a scene
FLIGHT = "generalised-alpha, ρ∞ = 0.5"     # the same of bodies in flight
BOUNCE = {"measure": "change of the speed by a bounce", "right": 0.05, "wrong": BOUNCE_WRONG, "default": ASYMPTOTIC,
          "message": ENERGY}

MODES = {
    "large_rotation_step": Mode(
        title="steps of large rotations", parameters=("rotation in a step [rad]",),
        measure="angle to the exact attitude after a rotation by 10 rad [rad]", right=0.015, wrong=0.05,
        methods={**DISSIPATIVE, "energy-momentum": SCHEMES["energy-momentum"], **NEWMARK,
                 ASYMPTOTIC: {"spectral_radius": 0.0}, FLIGHT: {}, "time.accuracy": ADAPTIVE},
        default=FLIGHT, message=r"rotates by .* rad a step.*limit.*time\.accuracy",
        full=(0.03, 0.1, 0.3, 0.5, 1.0, 3.0), quick=(1.0,), solve=large_rotation_step),
    "bounce_step": Mode(
        title="steps too long for contact", parameters=("step over the time of contact, Δt / T_c",),
        methods={**NEWMARK, ASYMPTOTIC: {}, "time.accuracy": ADAPTIVE},
        full=(0.03, 0.1, 0.2, 0.3, 0.5, 1.0, 3.0, 10.0), quick=(0.3, 10.0), solve=bounce_step, **BOUNCE),
    "bounce_map": Mode(
        title="step and penalty", parameters=("step Δt [s]", "penalty p_f E [Pa/m]"),
        methods={**NEWMARK, ASYMPTOTIC: {}, "time.accuracy": ADAPTIVE},
        full=tuple((step, stiffness) for stiffness in (1e6, 1e7, 1e8, 1e9)
                   for step in (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)),
        quick=((0.01, 1e6), (0.1, 1e8)), solve=bounce_map, **BOUNCE),
    "force_oscillation": Mode(
        title="force that oscillates after an impact", parameters=("Courant number",),
        measure="root mean square error of the force", right=0.1, wrong=0.25,
        methods={**NEWMARK, "generalised-alpha, ρ∞ = 0.8": SCHEMES["alpha"], ASYMPTOTIC: {}, **DISSIPATIVE},
        default=ASYMPTOTIC, message=r"oscillates: .*limit.*time\.scheme",
        full=(0.25, 0.5, 1.0, 2.0, 4.0), quick=(2.0,), solve=force_oscillation),
    "light_body": Mode(
        title="bodies lighter than the soil", parameters=("mass of a body over a row of cells under it, M / ρ h A",),
        measure="error of the speed after 1.5 L / c over v", right=0.05, wrong=0.25,
        methods={**NEWMARK, ASYMPTOTIC: {}, **DISSIPATIVE}, default=ASYMPTOTIC,
        message=r"rows? of cells under it, limit 1\.5.*size",
        full=(1e5, 1e3, 100.0, 10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01), quick=(0.03,), solve=light_body),
    "tunnelling": Mode(
        title="fast impacts", parameters=("way in a step over the spacing of corners, v Δt / s",),
        measure="share of the soil under a plate that passed through it", right=0.01, wrong=0.05,
        methods={"path not checked": {"checked": False}, "corners (published)": CORNERS, "faces": {}},
        default="faces", message=r"passed through a body.*time\.step",
        full=(0.1, 0.25, 0.5, 1.0, 1.5, 2.5, 5.0, 10.0, 20.0), quick=(5.0,), solve=tunnelling),
    "plastic_step": Mode(
        title="load steps and plastic flow", parameters=("steps in which the weight of a bank is applied",),
        measure="error of the displacement", right=0.05, wrong=0.25,
        methods={"increments as given": {"smallest": 1.0}, "halved on failure": {},
                 "ten increments a step": {"share": 10}}, default="halved on failure",
        message=r"plastic strain of a point, limit .*stage\.steps|smaller time\.step",
        full=(50, 20, 10, 5, 2, 1), quick=(5, 1), solve=plastic_step),
    "round_off": Mode(
        title="hardly any weight", parameters=("share of gravity",),
        measure="error of the mean stress over the largest", right=0.01, wrong=0.1,
        methods={"tolerance of 1e-9": {"tolerance": 1e-9}, "tolerance of 1e-6": {"tolerance": 1e-6},
                 "tolerance of 1e-4": {}, "tolerance of 1e-3": {"tolerance": 1e-3}}, default="tolerance of 1e-4",
        message=r"round-off of its stiffness, limit .*looser solver\.tolerance",
        full=(1.0, 1e-3, 1e-6, 1e-9, 1e-10, 1e-12, 0.0), quick=(1.0, 1e-9, 1e-12, 0.0), solve=round_off),
}
