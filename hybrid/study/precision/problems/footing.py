"""A smooth rigid strip footing on weightless soil in plane strain, pushed down until the soil flows: Prandtl's Nc.

          |  B/2 |
          |=====|________________   cohesion c, E = 10⁴ c; half a model, symmetric about x = 0
          |
          |______________________   Nc = F / (B c) = 5.14159, 14.8347, 30.1396 for φ = 0, 20°, 30°

Nc = (e^(π tanφ) tan²(45° + φ/2) - 1) cotφ, 2 + π for φ = 0, is that of Mohr-Coulomb's law; the cone matched in plane
strain with associated flow has the same (φ = 0: √J2 = c, von Mises). In `press` contact is at the corners of the points'
domains, where a footing that ends half-way between two corners presses on exactly its own width. Contact on faces
acts a little beyond the edges, up to the next nodes.
Soil that heaves beside it only just reaches into empty cells; some runs then stop unless a ghost penalty couples these
cells to their neighbours.

The study sets nothing. Its footing ends on a node, as that of a user would, and is up to a quarter of a cell wider in the
soil, by either contact. It runs φ = 20°; φ = 0 has an error of its own. At 20° the force still grows by 1.5 % over the last
tenth of the settlement, so errors below one or two per cent are accidental.
"""

from dataclasses import dataclass
from time import process_time

import numpy as np

from hybrid.bench.timed_steps import newton_iterations, timed_steps
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import RunResult
from hybrid.study.precision.settings import PUBLISHED, few, krylov_tolerances, newton_tolerances, transferable

ERRORS = {"Nc, φ = 20°": "|F / (B c) / Prandtl's Nc - 1|", "Nc, φ = 0": "|F / (B c) / Prandtl's Nc - 1|"}
COHESION, STIFFNESS, WIDTH = 1e3, 1e4, 2.0      # c [Pa], E/c, B [m]
PLAIN = {"fbar": False, "ghost": 0.0}       # soil without remedies
CURES = {"default": {}, "F-bar alone": {"fbar": True, "ghost": 0.0}, "plain": PLAIN}

CORNERS = {"contact": "corners", "penalty": 100.0}
PRESSING = {"linear": "direct", "tolerance": 1e-6}


def prandtl(angle):
    """Nc at a friction angle [degrees]."""
    tan = np.tan(np.radians(angle))
    return 2 + np.pi if angle == 0 else (np.exp(np.pi * tan) * np.tan(np.radians(45 + angle / 2)) ** 2 - 1) / tan


def material(angle):
    """Von Mises for φ = 0, else an associated cone; matched in plane strain, as scenes are."""
    common = {"young": STIFFNESS * COHESION, "density": 1.0}
    if angle == 0:
        return Material(law="von-mises", poisson=0.49, strength=COHESION, **common)
    return Material(law="drucker-prager", poisson=0.3, friction_angle=angle, dilation_angle=angle, cohesion=COHESION,
                    **common)


@dataclass(frozen=True)
class Press:
    """settlement / B and F / (B c) after each step; position (n, 3) and plastic strain (n,) of the points at the end;
    unknowns; Newton iterations; seconds of the run; notes of its steps."""

    settlement: np.ndarray
    factor: np.ndarray
    position: np.ndarray
    plastic: np.ndarray
    unknowns: int
    iterations: int
    seconds: float
    notes: tuple = ()


def nodes(size, end, growth=None):
    """From 0 to `end` [m] or a little farther, `size` [m] apart; with growth up to WIDTH only."""
    found = size * np.arange(int(np.ceil((WIDTH if growth else end) / size)) + 1)
    while growth and found[-1] < end:
        found = np.append(found, found[-1] + growth * (found[-1] - found[-2]))
    return found


def press(angle, across, depth=2.0, width=4.0, settlement=None, steps=20, law=None, body=(), faces=(),
          solver=PRESSING, growth=None, beyond=0.25, method="default", **soil):
    """Press with `across` cells under half the footing in soil of `width` x `depth` footing widths, half a model.

    settlement: in widths; law: another Material; body, faces, soil: more values of these tables; solver: those of this
    one; growth: of cells farther than a width from the middle of the footing, None: all are equal; beyond: cells from
    the last node under the footing to its edge; method: "default" or "published".
    """
    size = 0.5 * WIDTH / (across + beyond)
    settlement = settlement or 2.5 * prandtl(angle) / STIFFNESS
    along, down = (nodes(size, n * WIDTH, growth) for n in (width, depth))
    thickness = 0.5 * size      # points are cubes
    grid = Grid(Axis(nodes=tuple(along)), Axis(start=0.0, end=thickness, collapsed=True),
                Axis(nodes=(*-down[::-1], size)), Faces(**{"z_min": "fixed", **dict(faces)}))
    footing = Body(
        name="footing", geometry=GEOMETRY / "box.geo", density=1000.0,
        parameters={"length": WIDTH, "width": 3 * thickness, "height": 0.5 * WIDTH, "size": 10 * WIDTH},
        position=(0.0, 0.5 * thickness, 0.0), rest_on=0.0, driven=("z",), held=("x", "y", "rx", "ry", "rz"),
        velocity=(0.0, 0.0, -settlement * WIDTH / steps), **{**CORNERS, **dict(body)})
    scene = Scene(
        name="footing", grid=grid, soil=Soil(law or material(angle), geostatic=False, top=0.0, **soil),
        bodies=(footing,), gravity=(0.0, 0.0, 0.0), time=Time(step=1.0, inertia=False), stages=(Stage("press", steps),),
        method=method, solver=Solver(**solver), output=Output(every=0, checkpoint=0))
    simulation = build(scene)
    records, seconds = timed_steps(simulation, clock=process_time)
    force = np.array([record.bodies[0].contact_force[2] for record in records])
    points = simulation.state.points
    return Press(settlement * np.arange(1, steps + 1) / steps, force / (0.5 * WIDTH * thickness * COHESION),
                 points.position, points.plastic_strain, len(simulation.evaluation.soil),
                 newton_iterations(records), sum(seconds), tuple(note for record in records for note in record.notes))


ACROSS, FIXED = (2, 4), 2     # with a single cell errors cancel by chance
PENALTY = 50.0      # [1/m]
PAPER = {"method": "published", "body": {"penalty": PENALTY}}


def curves(quick=False):
    """{curve: [(setting, values of `solve`), ...]}."""
    def over(across=ACROSS, **values):
        return [(f"h = {0.5 * WIDTH / n:.2g} m", {"across": n, **values}) for n in across]

    direct = {"linear": "direct"}
    all_curves = {
        "default": over((*ACROSS, 8)),
        PUBLISHED: over(**PAPER),
        "neither F-bar nor ghost": over(soil=PLAIN),
        "no ghost penalty": over(soil={"ghost": 0.0}),
        "graded grid": over(growth=1.3),
        "direct solver": over(solver=direct),
        "penalty": [(f"p_f = {p:g} /m", {"across": FIXED, "body": {"penalty": float(p)}}) for p in (50, 1000)],
        "load steps": [(f"{k} steps", {"across": FIXED, "steps": k}) for k in (5, 10, 40)],
        "Newton tolerance": newton_tolerances(across=FIXED),
        "Krylov tolerance": krylov_tolerances(across=FIXED),
        "default, φ = 0": over(angle=0),
        "published method, φ = 0": over(angle=0, **PAPER),
        "neither F-bar nor ghost, φ = 0": over(angle=0, soil=PLAIN),
        "direct solver, φ = 0": over(angle=0, solver=direct),
    }
    return few(all_curves, {"neither F-bar nor ghost": 2, "default": 2}) if quick else all_curves


def transfer(values):
    """Settings that a scene can take over from a run on equal cells in the default number of steps, else None; also
    None for contact springs softer than PENALTY, which reduce an excessive force and so hide some of the error."""
    body = dict(values.get("body", {}))
    found = transferable(values, values["across"], "across")
    if found is None or body.get("penalty", PENALTY) < PENALTY:
        return None
    if "penalty" in body:
        body["penalty"] *= 0.5 * WIDTH
    return {**found, "body": body}


def solve(across, angle=20, steps=20, growth=None, soil=None, solver=None, body=None, method="default"):
    """RunResult of the footing at a friction angle [degrees], 0 or 20; soil, solver, body: values of these tables that
    differ from the defaults."""
    found = press(angle, across, steps=steps, growth=growth, solver=solver or {}, beyond=0.0, method=method,
                  body={"contact": None, "penalty": None, **(body or {})}, **(soil or {}))
    errors = {**dict.fromkeys(ERRORS, float("nan")),
              f"Nc, φ = {angle}" + "°" * (angle > 0): float(abs(found.factor[-1] / prandtl(angle) - 1))}
    return RunResult(errors, found.iterations, found.unknowns, found.seconds)


PROBLEM = Problem(
    title="strip footing", errors=ERRORS,
    shown=(PUBLISHED, "neither F-bar nor ghost", "no ghost penalty", "direct solver", "Newton tolerance"),
    chosen=("graded grid", "load steps"), curves=curves, solve=solve, length="half of the width", transferable=transfer,
    certain=0.015)
