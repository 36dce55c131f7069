"""Dilation: plastic flow that swells more than its friction pays for makes energy out of nothing.

    | . . . |   column of sand, 4 m, between smooth walls, φ = 30°, c = 0, ν = 0.1, loaded by its own weight in 10
    | . . . |   quasi-static steps; small strains. It flows from the start, for σ_h = ν/(1-ν) σ_v is beyond the cone
    |_______|   D = τ : Δε_p = (k + (η̄ - η) p) Δγ  >= 0  for pressures p < 0 only up to η̄ = η, that is ψ = φ

Beyond ψ = φ the column still stands and settles as its law says, so nothing looks wrong. Exact: σ_zz = -ρ g (L - Z),
σ_xx from f = 0, and with both proportional to the depth, from ε_xx = 0,

    Δγ = -ε^e_xx / (s_xx/2√J2 + η̄/3)      ε_zz = ε^e_zz + Δγ (s_zz/2√J2 + η̄/3)      settlement -∫ ε_zz dZ

A scene with ψ > φ is refused. The law made of ψ as it is, without asking, is the plain method.
"""

import numpy as np

from hybrid.laws.drucker_prager import DruckerPrager, cone_constants
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen

TITLE = "dilation beyond friction"
PARAMETERS = ("dilation angle over friction angle",)
MEASURE, RIGHT, WRONG = "error of the settlement, or energy gained over the load's work", 0.02, 0.05
METHODS = {"whatever angles": {"law": "unchecked"}, "angles checked": {}}
DEFAULT = "angles checked"
SAYS = r"dilation_angle = \S+: must be at most friction_angle"
LENGTH, CELLS, DENSITY, GRAVITY, ANGLE, YOUNG, POISSON = 4.0, 16, 1600.0, 10.0, 30.0, 1e8, 0.1


def settings(quick=False):
    return [(share,) for share in ((0.5, 2.0) if quick else (0.0, 0.5, 0.9, 1.0, 1.1, 1.5, 2.0))]


def solve(share, law="drucker-prager"):
    """Seen of the column with ψ = share φ."""
    side, own = Axis(start=0.0, end=1.0, collapsed=True), law == "unchecked"
    angles = {"friction_angle": ANGLE, "dilation_angle": share * ANGLE, "cohesion": 0.0}
    material = Material(law="user", density=DENSITY) if own else Material(
        law=law, young=YOUNG, poisson=POISSON, density=DENSITY, **angles)
    simulation, records, _ = watched(Scene(
        name="column", soil=Soil(material, geostatic=False),
        grid=Grid(side, side, Axis(start=0.0, end=LENGTH, size=LENGTH / CELLS), Faces()),
        gravity=(0.0, 0.0, -GRAVITY), time=Time(1.0, inertia=False), solver=Solver(linear="direct"),
        stages=(Stage("load", 10, gravity=(0.0, 1.0)),), output=Output(every=0, checkpoint=0)), law=(
            lambda p, stress: DruckerPrager(np.full(len(p), YOUNG), POISSON, *angles.values())) if own else None)
    energy, points = records[-1].energies, simulation.state.points
    top = simulation.initial_position[:, 2].argmax()
    sunk = simulation.initial_position[top, 2] - points.position[top, 2]
    exact = settlement(share, simulation.initial_position[top, 2])
    work = energy["elastic"] + abs(energy["plastic"])
    return Seen(float(max(abs(sunk / exact - 1), -energy["plastic"] / work)))


def settlement(share, height):
    """How far [m] a point sinks that starts at `height`."""
    (eta, _), (eta_bar, _) = cone_constants(ANGLE, "compression"), cone_constants(share * ANGLE, "compression")
    across = (1 / np.sqrt(3) - eta / 3) / (1 / np.sqrt(3) + 2 * eta / 3)    # σ_xx/σ_zz of f = 0
    stress = -np.array([across, across, 1.0])
    deviator = stress - stress.mean()
    flow = deviator / (2 * np.sqrt(0.5 * deviator @ deviator)) + eta_bar / 3
    elastic = ((1 + POISSON) * stress - POISSON * stress.sum()) / YOUNG
    strain = elastic[2] - elastic[0] / flow[0] * flow[2]
    return -strain * DENSITY * GRAVITY * (LENGTH * height - 0.5 * height**2)
