"""A frictionless rigid platen squeezes an elastic cube by a quarter in quasi-static steps, ν = 0.

Soil and contact are springs in series. With the height l = 0.6 m + δ of the cube under a platen at 0.6 m,

    F = p_f E A δ = A E ln(L/l) L/l        A = 0.64 m², L = 0.8 m, E = 1 MPa

Without overlap, δ = 0, the ideal force is 245.49 kN; the force converges to it as the contact stiffness grows.
"""

from dataclasses import dataclass
from math import log
from time import process_time

from scipy.optimize import brentq

from hybrid.bench.timed_steps import newton_iterations, sizes, timed_steps
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import RunResult
from hybrid.study.precision.settings import PUBLISHED, transferable

YOUNG, LENGTH, PRESSED, AREA = 1e6, 0.8, 0.6, 0.64
IDEAL = AREA * YOUNG * log(LENGTH / PRESSED) * LENGTH / PRESSED
CORNERS, PENALTIES = {"method": "published", "penalty": 50.0}, (20.0, 50.0, 200.0, 1e3, 1e4, 1e5)


def in_series(penalty):
    """Force [N] and height [m] of soil and of contact springs in series."""
    def force(height):
        return AREA * YOUNG * log(LENGTH / height) * LENGTH / height
    height = brentq(lambda l: penalty * YOUNG * AREA * (l - PRESSED) - force(l), PRESSED, LENGTH, xtol=1e-14)
    return force(height), height


def curves(quick):
    """Cells; penalty factor; the published method; tolerances and load steps."""
    penalties, cells = ((50.0, 1e3), (0.4, 0.2)) if quick else (PENALTIES, (0.4, 0.2, 0.1))
    found = {"default": _fine(cells), "penalty": _stiff(penalties), PUBLISHED: _fine(cells, **CORNERS)}
    if quick:
        return found
    return found | {
        "direct solver": _fine(cells, solver={"linear": "direct"}),
        "Newton tolerance": [(f"{t:g}", {"solver": {"tolerance": t}})
                             for t in (1e-1, 1e-2, 1e-4, 1e-8)],
        "Krylov tolerance": [(f"{t:g}", {"solver": {"linear_tolerance": t}}) for t in (1e-1, 1e-2, 1e-6)],
        "load steps": _slow((5, 80))}


def _fine(cells, **values):
    return [(f"h = {cell:g} m", {"cell": cell, **values}) for cell in cells]


def _stiff(penalties, **values):
    return [(f"p_f = {p:g} /m", {"penalty": p, **values}) for p in penalties]


def _slow(counts, **values):
    return [(f"{steps} steps", {"steps": steps, **values}) for steps in counts]


def scene(penalty=None, cell=0.4, steps=20, solver=None, method="default", **body):
    """Scene of the press: `penalty` [1/m], None: derived, cells of `cell` [m]; solver, body: values of the solver
    and of the platen that differ from the defaults."""
    axis = Axis(start=0.0, end=LENGTH, size=cell)
    parameters = {"length": 1.2, "width": 1.2, "height": 0.4, "size": body.pop("size", 10.0)}
    platen = Body(GEOMETRY / "box.geo", 1000.0, parameters=parameters, position=(0.4, 0.4, 0.0), rest_on=LENGTH,
                  velocity=(0.0, 0.0, (PRESSED - LENGTH) / 20), driven=("z",), held=("x", "y", "rx", "ry", "rz"),
                  penalty=penalty, **body)
    material = Material(law="hencky", young=YOUNG, poisson=0.0, density=1000.0)
    return Scene(name="platen", method=method, grid=Grid(axis, axis, axis, Faces()), soil=Soil(material, geostatic=False),
                 bodies=(platen,), time=Time(20 / steps, inertia=False), stages=(Stage("press", steps),),
                 solver=Solver(**(solver or {})), gravity=(0.0, 0.0, 0.0), output=Output(every=0, checkpoint=0))


@dataclass(frozen=True)
class Pressed:
    """The platen after its last step: its Simulation and Records, the force [N] on it, the cube's height [m] and the
    processor time of the steps [s]."""

    simulation: object
    records: list
    force: float
    height: float
    seconds: float


def press(**values):
    """Pressed of a `scene` of these values. Raises StepError if a step fails."""
    simulation = build(scene(**values))
    records, seconds = timed_steps(simulation, clock=process_time)
    return Pressed(simulation, records, float(records[-1].bodies[0].contact_force[2]),
                   float(simulation.state.contacts[0].position[:, 2].max()), sum(seconds))


def transfer(values):
    """Settings that a scene can take over from a run in the default number of steps, else None."""
    found = transferable(values, LENGTH / values.get("cell", 0.4), "cell", "penalty")
    body = {"penalty": values["penalty"] * LENGTH} if "penalty" in values else {}
    return found and {**found, "body": body}


def solve(**values):
    """RunResult of a `press` of these values."""
    found = press(**values)
    springs = abs(found.force / in_series(found.simulation.model.bodies[0].penalty)[0] - 1)
    errors = {"force": abs(found.force / IDEAL - 1), "height": abs(found.height / PRESSED - 1), "springs": springs}
    return RunResult(errors, newton_iterations(found.records), sizes(found.simulation)["unknowns"], found.seconds)


PROBLEM = Problem(
    title="platen on a cube",
    errors={"force": "|F/F_ideal - 1| on the platen at its lowest, F_ideal without overlap [-]",
            "height": "|l/l_ideal - 1| of the cube [-]",
            "springs": "|F/F_p - 1|, F_p of soil and penalty springs in series [-]"},
    shown=(PUBLISHED, "penalty", "direct solver", "Newton tolerance", "Krylov tolerance"), chosen=("load steps",),
    curves=curves, solve=solve, length="edge of the cube", transferable=transfer)
