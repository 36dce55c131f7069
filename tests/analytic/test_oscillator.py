"""One degree of freedom, ü = -ω² u, with every scheme: amplification against theory, through a whole run, in soil.

Theory is Chung and Hulbert's own form of generalised alpha, which averages forces over the step,

    (1-αm) a_{n+1} + αm a_n + ω² [(1-αf) u_{n+1} + αf u_n] = 0

and has the same amplification. As ωΔt grows its three roots all go to -ρ∞. A body on a pull line has the frequency
√(k/m), a bar of soil between two held ends π c/L with c = √(E/ρ).
"""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.body import rigid
from hybrid.scene import Axis, Body, Faces, Grid, Material, Pull, Scene, Soil, Solver, Stage, Time
from hybrid.scheme import Scheme
from hybrid.setup.build import build
from hybrid.simulation import Simulation
from hybrid.soil.model import Soil as SoilModel

RADII = [0.0, 0.5, 0.8, 1.0]


def amplification(scheme, frequency, dt=1.0):
    """Matrix (3, 3) of one step on (u, v, a); the true acceleration is -ω² u."""
    columns = []
    for u, v, a in np.eye(3):
        constant = scheme.advance(0.0, v, -frequency**2 * u, a, dt)[1]
        increment = -(frequency**2 * u + constant) / (frequency**2 + scheme.mass_factor(dt))
        gain, second, algorithmic = scheme.advance(increment, v, -frequency**2 * u, a, dt)
        columns.append((u + increment, v + gain, second if algorithmic is None else algorithmic))
    return np.array(columns).T


def theory(scheme, frequency, dt=1.0):
    """The same of Chung and Hulbert: L z_{n+1} = R z_n for z = (u, v, a)."""
    s, w = scheme, frequency**2
    left = np.array([[(1 - s.alpha_f) * w, 0, 1 - s.alpha_m], [1, 0, -s.beta * dt**2], [0, 1, -s.gamma * dt]])
    right = np.array([[-s.alpha_f * w, 0, -s.alpha_m], [1, dt, (0.5 - s.beta) * dt**2], [0, 1, (1 - s.gamma) * dt]])
    return np.linalg.solve(left, right)


def radius(matrix):
    return np.abs(np.linalg.eigvals(matrix)).max()


@pytest.mark.parametrize("rho", RADII)
@pytest.mark.parametrize("frequency", [1e-2, 0.5, 3.0, 100.0])
def test_amplification_is_that_of_the_form_with_averaged_forces(rho, frequency):
    scheme = Scheme.generalised_alpha(rho)
    found, wanted = (np.poly(form(scheme, frequency)) for form in (amplification, theory))
    np.testing.assert_allclose(found, wanted, atol=1e-9)


@pytest.mark.parametrize("rho", RADII)
def test_high_frequencies_are_left_with_the_spectral_radius(rho):
    scheme = Scheme.generalised_alpha(rho)
    np.testing.assert_allclose(np.poly(amplification(scheme, 1e5)), np.poly([-rho] * 3), atol=1e-6)
    over_all = [radius(amplification(scheme, w)) for w in np.logspace(-2, 3, 60)]
    assert max(over_all) <= 1 + 1e-9 and over_all[0] > 1 - 1e-4       # stable, and low ones are left alone


def test_pairs_of_newmark_damp_as_known():
    """(1/4, 1/2) not at all, (0.5625, 1) to a third a step. The third root is 0: a_n is no history of its own."""
    for frequency in (0.1, 7.0, 1e4):
        roots = np.poly(amplification(Scheme.newmark(), frequency))
        assert roots[2:] == pytest.approx([1.0, 0.0], abs=1e-9)       # product of a conjugate pair
    np.testing.assert_allclose(np.poly(amplification(Scheme.newmark(0.5625, 1.0), 1e5)), np.poly([-1 / 3, -1 / 3, 0]),
                               atol=1e-6)


# ------------------------------------------------------------------ a body on a pull line


SCHEMES = {
    "newmark": ({"scheme": "newmark"}, 2),
    "dissipative": ({"beta": 0.5625, "gamma": 1.0}, 1),
    "alpha 0.8": ({"scheme": "generalised-alpha", "spectral_radius": 0.8}, 2),
    "alpha 0.5": ({"scheme": "generalised-alpha", "spectral_radius": 0.5}, 2),
    "energy-momentum": ({"scheme": "energy-momentum"}, 2),
}
STIFFNESS = 4e5


def hung(geometry, time, steps, speed=0.5, tolerance=1e-12):
    """A sphere, thrown towards the far end of an elastic line, along which alone it may move."""
    side = Axis(start=-0.4, end=0.4, size=0.4)
    return Scene(
        name="hung", grid=Grid(side, side, Axis(start=-10.4, end=-10.0, size=0.4)),
        soil=Soil(Material(law="hencky", young=1e6, poisson=0.3, density=1800.0), held=True),
        bodies=(Body(geometry=geometry / "sphere.geo", density=3000.0, parameters={"radius": 0.2, "size": 0.12},
                     velocity=(speed, 0.0, 0.0), held=("y", "z", "rx", "ry", "rz"),
                     pull=Pull((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), STIFFNESS, 5.0, (1.0, 0.0, 0.0), False)),),
        gravity=(0.0, 0.0, 0.0), time=time, stages=(Stage("swing", steps),), solver=Solver(tolerance=tolerance))


@pytest.fixture(scope="module")
def swing(geometry):
    """Function of Time, phase ω t of the end and steps: displacement [m], velocity [m/s], energy lost of the whole."""
    first = build(hung(geometry, Time(1.0), 1))      # meshed once
    frequency = np.sqrt(STIFFNESS / first.masses[0].mass)

    def run(phase, steps, speed=0.5, tolerance=1e-12, **time):
        described = hung(geometry, Time(phase / frequency / steps, **time), steps, speed, tolerance)
        simulation = Simulation(described, replace(first.model, scheme=Scheme.of(described.time),
                                                   solver=described.solver), first.state, [])
        simulation.state.bodies[0].velocity[0] = speed
        motion = [simulation.state.bodies[0]]
        for record in simulation.steps():
            assert record.rejections == 0
            motion.append(simulation.state.bodies[0])
        moved = np.array([(m.position[0], m.velocity[0]) for m in motion])
        whole = 0.5 * first.masses[0].mass * speed**2
        return (moved[:, 0] - moved[0, 0]) * frequency / speed, moved[:, 1] / speed, -record.energies["error"] / whole

    return run


def observed(run, options, counts=(20, 40)):
    """Orders of displacement and velocity after a third of a period."""
    error = [[abs(u[-1] - np.sin(2.2)), abs(v[-1] - np.cos(2.2))]
             for u, v, _ in (run(2.2, count, **options) for count in counts)]
    return np.log2(np.divide(*error))


@pytest.mark.parametrize("options, order", SCHEMES.values(), ids=SCHEMES)
def test_a_body_on_a_line_swings_with_the_order_of_the_scheme(swing, options, order):
    assert observed(swing, options) == pytest.approx([order, order], abs=0.15)


def test_a_body_on_a_line_swings_with_second_order_at_spectral_radius_0(swing):
    """Seen at shorter steps than with the others: the two leading terms of the displacement have opposite signs."""
    default = {"scheme": "generalised-alpha", "spectral_radius": 0.0}
    assert observed(swing, default, (160, 320)) == pytest.approx([2.0, 2.0], abs=0.15)


def test_an_order_is_lost_when_a_body_forgets_the_algorithmic_acceleration(swing, monkeypatch):
    accept = rigid.accept
    monkeypatch.setattr(rigid, "accept", lambda *step: replace(accept(*step), algorithmic=None))
    assert (observed(swing, SCHEMES["alpha 0.5"][0]) < 1.6).all()


@pytest.mark.parametrize("name, least, most", [
    ("newmark", -1e-10, 1e-10), ("energy-momentum", -1e-10, 1e-10), ("alpha 0.8", 1e-6, 1e-4),
    ("alpha 0.5", 1e-5, 1e-3), ("dissipative", 1e-2, 0.1)])
def test_what_the_balance_of_energy_misses_is_what_the_scheme_dissipates(swing, name, least, most):
    lost = swing(2.2, 80, **SCHEMES[name][0])[2]
    assert least < lost < most


@pytest.mark.parametrize("rho", [0.5, 0.8])
def test_a_stiff_line_swings_out_at_the_spectral_radius(swing, rho):
    """u_{n+3} + 3 ρ u_{n+2} + 3 ρ² u_{n+1} + ρ³ u_n = 0, as all three roots are -ρ far above 1/Δt."""
    steps = 9
    u, _, _ = swing(1e3 * steps, steps, 0.005, 1e-8, scheme="generalised-alpha", spectral_radius=rho)
    right, wrong = (np.abs(np.convolve(u, np.poly([-r] * 3))[4:-3]).max() for r in (rho, rho + 0.01))
    assert right < 1e-4 * np.abs(u).max() and right < 0.1 * wrong


# ------------------------------------------------------------------ a bar of soil

LENGTH, YOUNG, DENSITY, SPEED = 1.0, 1e6, 1000.0, 0.01
FREQUENCY = np.pi / LENGTH * np.sqrt(YOUNG / DENSITY)


def bar(cells, steps, phase, **time):
    """Amplitudes of displacement (times ω/V) and velocity (over V) of the first mode after ω t = `phase`."""
    side = Axis(start=0.0, end=LENGTH / cells, size=LENGTH / cells, collapsed=True)
    described = Scene(
        name="bar", grid=Grid(side, side, Axis(start=0.0, end=LENGTH, size=LENGTH / cells),
                              Faces(z_min="fixed", z_max="fixed")),
        soil=Soil(Material(law="hencky", young=YOUNG, poisson=0.0, density=DENSITY), geostatic=False),
        gravity=(0.0, 0.0, 0.0), time=Time(step=phase / FREQUENCY / steps, **time), stages=(Stage("swing", steps),),
        solver=Solver(tolerance=1e-9, linear="direct"))    # 1e-10 is what rounding of these small strains leaves
    simulation = build(described)
    z = simulation.initial_position[:, 2]
    mode = np.sin(np.pi * z / LENGTH)
    simulation.state.points.velocity[:, 2] = SPEED * mode
    for record in simulation.steps():
        assert record.rejections == 0
    points = simulation.state.points
    moved = np.array([(points.position[:, 2] - z) * FREQUENCY, points.velocity[:, 2]]) / SPEED
    return 2 * np.mean(moved * mode, axis=1)


def bar_order(options, counts=(20, 40, 80)):
    """Observed order of the step alone, from the change at each halving: that of the grid stays."""
    found = [bar(20, count, 1.25 * np.pi, **options) for count in counts]
    return np.log2(np.abs((found[0] - found[1]) / (found[1] - found[2])))


def test_the_bar_swings_as_it_should():
    assert bar(20, 40, 1.25 * np.pi, **SCHEMES["alpha 0.8"][0]) == pytest.approx([-np.sqrt(0.5)] * 2, abs=0.02)


@pytest.mark.parametrize("name", ["newmark", "alpha 0.8", "alpha 0.5"])
def test_soil_converges_with_second_order_in_the_step(name):
    """Down to what the projection of accelerations adds, Δt h²: the order is seen above that."""
    assert bar_order(SCHEMES[name][0]) == pytest.approx([2.0, 2.0], abs=0.25)


def test_an_order_is_lost_with_the_dissipative_pair():
    assert (bar_order(SCHEMES["dissipative"][0]) < 1.3).all()


def test_an_order_is_lost_when_points_forget_the_algorithmic_acceleration(monkeypatch):
    accept = SoilModel.accept
    monkeypatch.setattr(SoilModel, "accept", lambda self, *step: replace(accept(self, *step), algorithmic=None))
    assert (bar_order(SCHEMES["alpha 0.5"][0]) < 1.5).all()
