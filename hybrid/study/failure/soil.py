"""Failure modes of the soil's laws, of its volume constraint, and of soil at rest."""

import functools
from math import radians, tan

import numpy as np

from hybrid.laws import Response, plastic_increment
from hybrid.laws.drucker_prager import DruckerPrager, cone_constants
from hybrid.scene import Axis, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.study.failure.mode import Mode
from hybrid.study.failure.outcome import Observation
from hybrid.study.failure.simulate import messages, simulate
from hybrid.study.precision.problems import footing
from hybrid.study.scenes import NO_OUTPUT, collapsed, loaded_by_weight

BEAM, BEAM_YOUNG, BEAM_WEIGHT = 4.0, 1e6, 9.81      # [m], [Pa], [N/m³]
SAG = {0.3: 0.9864, 0.4: 0.9713, 0.45: 0.9593, 0.47: 0.9534, 0.49: 0.9466, 0.499: 0.9432, 0.4999: 0.9429}


def locking(poisson, cells=4, **soil):
    """Locking: linear cells cannot bend without a change of volume, so nearly incompressible soil does not bend.

        wall |==========   beam of 4 x 1 m under its weight, plane strain, small strains, 4 cells through its height;
             |             Poisson's ratio ν approaches 1/2

    In plane strain the linear functions of a cell have one isochoric mode less than the cell has constraints, so
    without a remedy the sag tends to 0 as K/G = 2(1 + ν)/3(1 - 2ν) grows. F-bar takes the volume change from the mean
    of the cell. Over the cells, the error without F-bar is proportional to (K/G) (h/H)² while it is small, so that ten
    times the bulk modulus takes three times the cells along each axis; with F-bar it does not depend on ν. Reference:
    the mean sag with F-bar on 32 cells through the height, which is SAG times that of Timoshenko's beam,

        q/E (L⁴ (1 - ν²)/20 I + 4/5 (1 + ν) L²/H),    16 cells give the same to 0.1 %

    SAG is below 1 because the wall prevents the beam from changing its height there.
    """
    size = 1.0 / cells
    material = Material(law="hencky", young=BEAM_YOUNG, poisson=poisson, density=1.0)
    simulation, _, texts = simulate(Scene(
        name="beam", soil=Soil(material, lower=(0.0, 0.0, 0.0), upper=(BEAM, size, 1.0), geostatic=False, **soil),
        grid=Grid(Axis(start=0.0, end=BEAM + 1.0, size=size), collapsed(size), Axis(start=-1.0, end=2.0, size=size),
                  Faces("fixed", "free", z_min="free")),
        gravity=(0.0, 0.0, -BEAM_WEIGHT), time=Time(1.0, inertia=False), stages=(Stage("load", 1),),
        solver=Solver(linear="direct"), output=NO_OUTPUT))
    sag = 0.5 - float(simulation.state.points.position[:, 2].mean())
    return Observation(abs(sag / (SAG[poisson] * _timoshenko(poisson)) - 1), texts)


def _timoshenko(poisson):
    """Mean sag [m] of a beam that bends and shears."""
    bending, shear = BEAM**4 * 12 / 20 * (1 - poisson**2), 0.8 * (1 + poisson) * BEAM**2
    return BEAM_WEIGHT / BEAM_YOUNG * (bending + shear)


def flow_locking(cells, **soil):
    """Locking of plastic flow: flowing clay keeps its volume, whatever its Poisson's ratio.

              |  B/2 |
              |=====|________    smooth rigid strip footing on weightless clay in plane strain, half a model, φ = 0,
              |                  E = 10⁴ s_u, ν = 0.3, pressed down until the clay flows (the problem `footing`)
              |______________

    Fully developed flow of von Mises' law is isochoric, and linear cells have more constraints than modes for it: the
    load keeps rising with the settlement, more slowly on finer cells. Exact: Prandtl's F/(B s_u) = 2 + π.
    """
    clay = Material(law="von-mises", poisson=0.3, strength=footing.COHESION, density=1.0,
                    young=footing.STIFFNESS * footing.COHESION)
    exact = footing.prandtl(0)
    pressed = footing.press(0, cells, law=clay, steps=10, settlement=6 * exact / footing.STIFFNESS, depth=1.0,
                            width=2.0, **soil)
    return Observation(float(abs(pressed.factor[-1] / exact - 1)), pressed.notes)


class Flank(DruckerPrager):
    """Drucker-Prager without dilation and without an apex: beyond it the deviatoric stress vanishes and the mean stress
    stays elastic."""

    def respond(self, strain, plastic_strain=None):
        response, (bulk, _, eta, _, strength) = super().respond(strain, plastic_strain), self.parameters.T[:5]
        volume = strain.sum(axis=1)
        beyond = (eta * bulk * volume > strength)[:, None]
        mean = np.repeat((bulk * volume)[:, None], 3, axis=1)
        return Response(np.where(beyond, mean, response.stress), np.where(beyond, mean / (3 * bulk[:, None]),
                        response.elastic), np.where(beyond[:, None], bulk[:, None, None], response.tangent))


def apex(share, law="drucker-prager"):
    """Tension: the friction cone ends in an apex; a return to its flank alone lets soil carry any tension.

        ____________   bed of sand, 4 m, held at its floor and sides, φ = 30°, ψ = 0, cohesion c, without stress at the
        |          |   start; gravity acts upwards, so that the bed separates from the floor and flies
        |__________|   k = ξ c; all but the layer at the floor can carry the tension of the apex, p_t = k/η = c cotφ

    With ψ = 0 the flank returns the trial stress at constant p, so a p beyond the apex is kept: sand that is elastic in
    tension. A return to the apex allows flow in all directions and leaves no stiffness; inertia carries the points.
    Exact: the upper half of the bed, held back by p_t alone, rises by ½ (g - p_t/ρL) t², and no point carries more than
    p_t.
    """
    length, density, gravity, angle, young, duration, steps = 4.0, 1600.0, 10.0, 30.0, 1e7, 0.4, 20
    weight, size = density * gravity * length, length / 8
    tension = share * weight / tan(radians(angle))
    own = law == "flank"
    values = {"young": young, "poisson": 0.25, "friction_angle": angle, "dilation_angle": 0.0,
              "cohesion": share * weight}
    material = Material(law="user", density=density) if own else Material(law=law, density=density, **values)
    scene = Scene(
        name="bed", soil=Soil(material, geostatic=False, top=length), gravity=(0.0, 0.0, gravity),
        grid=Grid(Axis(start=0.0, end=4 * size, size=size), collapsed(size),
                  Axis(start=0.0, end=length + 2.0, size=size), Faces()),
        time=Time(duration / steps, scheme="newmark"), stages=(Stage("fly", steps),), output=NO_OUTPUT)
    flank = (lambda p, stress: Flank(np.full(len(p), young), 0.25, angle, 0.0, share * weight)) if own else None
    simulation, _, texts = simulate(scene, law=flank)
    points, start = simulation.state.points, simulation.initial_position
    rise = (points.position - start)[start[:, 2] > length / 2, 2].mean()
    free = 0.5 * max(gravity - tension / (density * length), 0.0) * duration**2
    mean = np.trace(points.stress, axis1=1, axis2=2) / 3
    return Observation(
        float(max(abs(rise - free) / (0.5 * gravity * duration**2), (mean.max() - tension) / weight)), texts)


SAND = {"length": 4.0, "density": 1600.0, "gravity": 10.0, "angle": 30.0, "young": 1e8, "poisson": 0.1}


def dilatancy(share, law="drucker-prager"):
    """Dilation: plastic flow that expands more than its friction can dissipate generates energy.

        | . . . |   column of sand, 4 m, between smooth walls, φ = 30°, c = 0, ν = 0.1, loaded by its own weight in 10
        | . . . |   quasi-static steps; small strains. It yields from the start: σ_h = ν/(1-ν) σ_v is outside the cone
        |_______|   D = τ : Δε_p = (k + (η̄ - η) p) Δγ  >= 0  for pressures p < 0 only up to η̄ = η, that is ψ = φ

    Beyond ψ = φ the column still stands and settles according to its law, so the error is not visible. Exact:
    σ_zz = -ρ g (L - Z), σ_xx from f = 0, and with both proportional to the depth, from ε_xx = 0,

        Δγ = -ε^e_xx / (s_xx/2√J2 + η̄/3)      ε_zz = ε^e_zz + Δγ (s_zz/2√J2 + η̄/3)      settlement -∫ ε_zz dZ

    A scene with ψ > φ is refused. The plain method makes the law from ψ without this check.
    """
    length, density, young, own = SAND["length"], SAND["density"], SAND["young"], law == "unchecked"
    angles = {"friction_angle": SAND["angle"], "dilation_angle": share * SAND["angle"], "cohesion": 0.0}
    material = Material(law="user", density=density) if own else Material(
        law=law, young=young, poisson=SAND["poisson"], density=density, **angles)
    grid = Grid(collapsed(), collapsed(), Axis(start=0.0, end=length, size=length / 16), Faces())
    unchecked = None
    if own:
        def unchecked(p, stress):
            return DruckerPrager(np.full(len(p), young), SAND["poisson"], *angles.values())
    simulation, records, texts = simulate(loaded_by_weight(
        "column", grid, Soil(material, geostatic=False), 10, -SAND["gravity"], solver=Solver(linear="direct")),
        law=unchecked)
    energy, points = records[-1].energies, simulation.state.points
    top = simulation.initial_position[:, 2].argmax()
    sunk = simulation.initial_position[top, 2] - points.position[top, 2]
    exact = _settlement(share, simulation.initial_position[top, 2])
    work = energy["elastic"] + abs(energy["plastic"])
    return Observation(float(max(abs(sunk / exact - 1), -energy["plastic"] / work)), texts)


def _settlement(share, height):
    """Exact settlement [m] of a point with this initial height [m]."""
    poisson = SAND["poisson"]
    eta, _, eta_bar = cone_constants(SAND["angle"], share * SAND["angle"], "compression")
    across = (1 / np.sqrt(3) - eta / 3) / (1 / np.sqrt(3) + 2 * eta / 3)    # σ_xx/σ_zz of f = 0
    stress = -np.array([across, across, 1.0])
    deviator = stress - stress.mean()
    flow = deviator / (2 * np.sqrt(0.5 * deviator @ deviator)) + eta_bar / 3
    elastic = ((1 + poisson) * stress - poisson * stress.sum()) / SAND["young"]
    strain = elastic[2] - elastic[0] / flow[0] * flow[2]
    return -strain * SAND["density"] * SAND["gravity"] * (SAND["length"] * height - 0.5 * height**2)


CHOSEN = 1.0    # [m] size of the cells for which the softening is chosen
CEMENTED = {"friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 5.4e4, "residual_cohesion": 0.0}
SOFTENING = -5.4e4 / 0.035      # [Pa]


def softening(cells, scaled=False):
    """Softening: failure localises in one row of cells, so the dissipated energy is proportional to their size.

        ^ ^ ^ ^    bed of 8 m, cemented, ν = 0, cohesion c that is lost after a plastic strain of c/|H|; all of it moves
        |     |    upwards by 1 m/s when its floor stops, breaks off at the floor and flies on. One layer of cells
        |_____|    opens, by a width proportional to h, and the others unload

    Only a fracture energy G_f per unit area is a property of the soil. With w(H) = ∫ σ dλ of a point stretched with its
    sides held, G_f = h w(H): the softening H is chosen for cells of h0 = 1 m. For other cells it has to be H h/h0
    (crack band: Z. P. Bažant and B. H. Oh, Matériaux et Constructions 16 (1983) 155-177). Reference: the bed flies on
    at √(v² - 2 G_f/ρL), less what its waves keep.
    """
    length, density, speed, duration, steps = 8.0, 1000.0, 1.0, 0.15, 60
    size = length / cells
    material = Material(law="drucker-prager", young=1e9, poisson=0.0, density=density,
                        hardening=SOFTENING * (size / CHOSEN if scaled else 1.0), **CEMENTED)
    simulation = build(Scene(
        name="bed", soil=Soil(material, geostatic=False, top=length, fbar=False, ghost=0.0),
        gravity=(0.0, 0.0, 0.0),
        grid=Grid(collapsed(), collapsed(), Axis(start=0.0, end=2 * length, size=size), Faces(z_min="fixed")),
        time=Time(duration / steps), stages=(Stage("fly", steps),), output=NO_OUTPUT))
    simulation.state.points.velocity[:, 2] = speed
    records = list(simulation.steps())
    final = simulation.state.points.velocity[:, 2].mean()
    exact = np.sqrt(speed**2 - 2 * CHOSEN * _fracture_work() / (density * length))
    return Observation(float(abs(final / exact - 1)), messages(simulation, records))


@functools.cache
def _fracture_work():
    """w [J/m³] of a point stretched along one axis until its cohesion is lost."""
    law = DruckerPrager(np.array([1e9]), 0.0, CEMENTED["friction_angle"], CEMENTED["dilation_angle"],
                        CEMENTED["cohesion"], hardening=SOFTENING, residual_cohesion=0.0)
    elastic, history, work, last = np.zeros((1, 3)), np.zeros(1), 0.0, 1.0
    for stretch in np.exp(np.linspace(0.0, 0.3, 2001))[1:]:
        trial = elastic + [[0.0, 0.0, np.log(stretch / last)]]
        response = law.respond(trial, history)
        history, elastic = history + plastic_increment(trial, response.elastic), response.elastic
        work, last = work + response.stress[0, 2] / stretch * (stretch - last), stretch
    return work


def rest(steps, settle=0, **soil):
    """Soil at rest: it should stay where it is for any time, and return after a small disturbance.

        | . . . |   column of 2 m, 4 cells, E = 10 MPa, ν = 0.3, own weight, steps of 0.02 s of undamped Newmark; it
        | . . . |   starts with an upward velocity of 1 µm/s at the top, in proportion to the height
        |_______|

    Soil that starts without stress oscillates by its own sag for ever, because nothing damps it. With the stress of its
    weight it is at rest to round-off; without the disturbance no bit of it changes in 10 000 steps. With it, the
    surface leaves the cell faces on which it lay, and a new node above it carries hardly any mass: the stress of the
    uppermost point, ρ g h/4, is lost, once. The top moves by 1 % of the sag on 4 cells, by 0.1 % on 16, and by no more
    after 10 000 steps. Reference: half the range of the top after the start, over the sag ρ g L²/2M, M = E (1 - ν)/(1 +
    ν)(1 - 2ν), is 0 but for the disturbance.
    """
    length, density, gravity, young, poisson, speed = 2.0, 1800.0, 9.81, 1e7, 0.3, 1e-6
    size = length / 4
    material = Material(law="hencky", young=young, poisson=poisson, density=density)
    stages = [Stage("settle", settle, beta=0.5625, gamma=1.0)] * (settle > 0) + [Stage("rest", steps)]
    simulation = build(Scene(
        name="column", soil=Soil(material, top=length, **soil), time=Time(0.02), stages=tuple(stages),
        grid=Grid(collapsed(), collapsed(), Axis(start=0.0, end=length + size, size=size), Faces()),
        gravity=(0.0, 0.0, -gravity), output=NO_OUTPUT))
    height = simulation.initial_position[:, 2]
    simulation.state.points.velocity[:, 2] += speed * height / length
    records, tops = [], []
    for record in simulation.steps():
        records.append(record)
        if record.step >= settle:
            tops.append(simulation.state.points.position[height.argmax(), 2])
    stiffness = young * (1 - poisson) / (1 + poisson) / (1 - 2 * poisson)
    sag = density * gravity * length**2 / (2 * stiffness)
    return Observation(float(0.5 * np.ptp(tops) / sag), messages(simulation, records))


BEAM_LOCKING = {
    "title": "locking of a beam", "measure": "error of the mean sag", "right": 0.05, "wrong": 0.25,
    "methods": {"no F-bar": {"fbar": False}, "F-bar": {}}, "default": "F-bar",
    "message": r"poisson = \S+: .*limit 0\.4:.*soil\.fbar|iterations without progress", "solve": locking}

MODES = {
    "locking": Mode(parameters=("Poisson's ratio",), full=tuple(SAG), quick=(0.3, 0.4999), **BEAM_LOCKING),
    "locking_cells": Mode(
        parameters=("Poisson's ratio", "cells through the beam's height"),
        full=tuple((nu, cells) for nu in SAG for cells in (2, 4, 8, 16)), quick=((0.3, 4), (0.4999, 4)),
        **BEAM_LOCKING),
    "flow_locking": Mode(
        title="locking of plastic flow", parameters=("cells under half a footing",),
        measure="error of the load at collapse", right=0.05, wrong=0.25,
        methods={"no F-bar": {"fbar": False}, "F-bar": {}}, default="F-bar",
        message=r"von-mises.*limit .*soil\.fbar", full=(16, 8, 4, 2, 1), quick=(2, 1), solve=flow_locking),
    "apex": Mode(
        title="sand without cohesion in tension", parameters=("cohesion over ρ g L",),
        measure="error of the rise, or tension beyond the apex over ρ g L", right=0.05, wrong=0.25,
        methods={"flank of the cone alone": {"law": "flank"}, "cone and apex": {},
                 "Willam-Warnke": {"law": "willam-warnke"}}, default="cone and apex", message=None,
        full=(1.0, 0.1, 0.01, 1e-4, 1e-6, 0.0), quick=(0.01, 0.0), solve=apex),
    "dilatancy": Mode(
        title="dilation beyond friction", parameters=("dilation angle over friction angle",),
        measure="error of the settlement, or energy generated over the work of the load", right=0.02, wrong=0.05,
        methods={"angles not checked": {"law": "unchecked"}, "angles checked": {}}, default="angles checked",
        message=r"dilation_angle = \S+: must be at most friction_angle",
        full=(0.0, 0.5, 0.9, 1.0, 1.1, 1.5, 2.0), quick=(0.5, 2.0), solve=dilatancy),
    "softening": Mode(
        title="softening", parameters=("cells over the bed's depth; softening is chosen for 8",),
        measure="error of the speed after the break", right=0.05, wrong=0.25,
        methods={"softening as given": {}, "scaled with the cells": {"scaled": True}}, default="softening as given",
        message=r"hardening = -\S+ Pa.*limit 0.*in proportion",
        full=(8, 16, 32, 64), quick=(8, 32), solve=softening),
    "rest": Mode(
        title="soil at rest", parameters=("steps of 0.02 s",),
        measure="half the range of the top over the sag", right=0.05, wrong=0.25,
        methods={"no stress at the start": {"geostatic": False},
                 "no stress, damped before": {"geostatic": False, "settle": 100},
                 "geostatic stress": {}, "geostatic stress, increments": {"transfer": "increments"}},
        default="geostatic stress", message=r"initial imbalance: .*(damps|settle|soil\.geostatic)",
        full=(10, 100, 1000, 10000), quick=(10, 100), solve=rest),
}
