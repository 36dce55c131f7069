"""Columns under their own weight, in closed form by Lambert's W; the study runs the one of 50 m and 10 kPa.

      z |  soil of length L between smooth walls, ν = 0: the area of a section stays,
        |
       ===      τ = E ln λ,  σ_zz = E ln λ / λ = -ρ g (L - Z)    ->    λ = W(s)/s,  s = ρ g (L - Z)/E

Gravity is turned on in equal quasi-static steps. Errors: Σ |σ_zz - exact| V / (ρ g L Σ V), and the height's over L.

AMPLE 1.1 (Coombs, Augarde, AMPLE: a material point learning environment, 2020) is measured on the same column in plane
strain, one cell wide, with the same error. Its seconds are CPU time of the whole run in GNU Octave, on another machine.
Its unknowns are the vertical displacements of two columns of nodes; rollers hold all others. Kratos's MPM application,
standard points, is run as well if it is given. With ν = 0 the cross-section keeps its area, so σ_zz does not depend on
the law: Kratos is also run with a neo-Hookean law, τ = E/2 (λ² - 1), under which the column becomes shorter.
"""

from dataclasses import dataclass
from time import process_time

import numpy as np
from scipy.integrate import quad
from scipy.special import lambertw

from hybrid.bench.peer import ask
from hybrid.bench.timed_steps import newton_iterations, timed_steps
from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import Record, RunResult
from hybrid.study.precision.settings import PUBLISHED, SOILS, few, krylov_tolerances, newton_tolerances, transferable


@dataclass(frozen=True)
class Column:
    """length [m], young [Pa], density [kg/m³], gravity [m/s²], steps it is loaded in."""

    length: float
    young: float
    density: float
    gravity: float
    steps: int

    @property
    def weight(self):
        """Pressure at the bottom [Pa]."""
        return self.density * self.gravity * self.length

    def stretch(self, Z):
        """λ at initial heights Z [m]."""
        s = np.maximum(self.density * self.gravity * (self.length - np.asarray(Z, float)) / self.young, 1e-300)
        return (lambertw(s) / s).real

    def height(self):
        """Exact, deformed [m]."""
        return quad(self.stretch, 0.0, self.length, epsabs=1e-13, epsrel=1e-13)[0]


SELF_WEIGHT = Column(0.8, 283.0, 50.0, 9.81, 50)
STIFF = Column(50.0, 1e6, 80.0, 10.0, 20)
SOFT = Column(50.0, 1e4, 80.0, 10.0, 40)
TIGHT = {"linear": "direct", "tolerance": 1e-9}   # leaves the error of the discretisation only


@dataclass(frozen=True)
class Settled:
    """Z, stress (n,) of the points; height [m]; errors [-] of stress and height; increments, Newton iterations,
    unknowns, seconds of the run."""

    Z: np.ndarray
    stress: np.ndarray
    height: float
    stress_error: float
    height_error: float
    increments: int
    iterations: int
    unknowns: int
    seconds: float


def settle(column, cells, steps=None, full=False, solver=TIGHT, method="default", **soil):
    """Settled column on `cells` cells; full: four cells of a three-dimensional grid at each height, else one axis.

    solver, soil: values of these tables; method: "default" or "published".
    """
    size = column.length / cells
    side = Axis(start=0.0, end=2 * size, size=size, collapsed=not full)
    scene = Scene(
        name="column", grid=Grid(side, side, Axis(start=0.0, end=column.length, size=size)),
        soil=Soil(Material(law="hencky", young=column.young, poisson=0.0, density=column.density), geostatic=False, **soil),
        gravity=(0.0, 0.0, -column.gravity), time=Time(step=1.0, inertia=False),
        stages=(Stage("load", steps or column.steps, gravity=(0.0, 1.0)),),
        method=method, solver=Solver(**solver), output=Output(every=0, checkpoint=0))
    simulation = build(scene)
    records, seconds = timed_steps(simulation, clock=process_time)
    points, constants = simulation.state.points, simulation.model.soil.constants
    Z, found = constants.position[:, 2], points.stress[:, 2, 2]
    top = np.argmax(points.position[:, 2])
    height = points.position[top, 2] + constants.half_width[top, 2] * points.deformation[top, 2, 2]
    wrong = np.abs(found + column.density * column.gravity * (column.length - Z))
    return Settled(Z, found, height, np.average(wrong, weights=constants.volume) / column.weight,
                   abs(height - column.height()) / column.length, sum(r.increments for r in records),
                   newton_iterations(records), len(simulation.evaluation.soil), sum(seconds))


def rates(cells, errors):
    """Observed order of `errors` (list) in the cell size over all `cells`."""
    return -np.polyfit(np.log(cells), np.log(errors), 1)[0]


CELLS, FIXED = (4, 8, 16, 32, 64, 128, 256), 64


def size(cells):
    """Label of a number of cells."""
    return f"h = {SOFT.length / cells:.3g} m"


def curves(quick=False):
    """{curve: [(setting, values of `solve`), ...]}."""
    def over(cells=CELLS, **values):
        return [(size(n), {"cells": n, **values}) for n in cells]

    all_curves = {
        "default": over(),
        PUBLISHED: over(method="published"),
        **{name: over(soil=soil) for name, soil in SOILS.items()},
        "h and load steps": [(f"{size(n)}, {k} steps", {"cells": n, "steps": k})
                             for n, k in ((16, 10), (32, 20), (64, 40), (128, 80), (256, 160))],
        "load steps": [(f"{k} step" + "s" * (k > 1), {"cells": FIXED, "steps": k})
                       for k in (1, 2, 5, 10, 20, 40, 80, 160)],
        "Newton tolerance": newton_tolerances(cells=FIXED),
        "Krylov tolerance": krylov_tolerances(cells=FIXED),
    }
    return few(all_curves, {"default": 4, PUBLISHED: 4, "standard MPM": 3, "load steps": 2}) if quick else all_curves


def transfer(values):
    """Settings that a scene can take over from a run in the default number of steps, else None."""
    return transferable(values, values["cells"], "cells")


def solve(cells, steps=SOFT.steps, soil=None, solver=None, method="default"):
    """RunResult of the column of 50 m and 10 kPa; soil, solver: values of these tables that differ from the
    defaults."""
    found = settle(SOFT, cells, steps, **(soil or {}), solver=solver or {}, method=method)
    return RunResult({"stress": float(found.stress_error), "height": float(found.height_error)}, found.iterations,
                 found.unknowns, found.seconds)


AMPLE = {   # cells, error of stress, Newton iterations of 40 steps, CPU time [s]
    "AMPLE, GIMP": (
        (4, 0.041333252226, 165, 2.032), (8, 0.012940820605, 166, 4.059), (16, 0.0036589060221, 166, 8.105),
        (32, 0.0010487058112, 166, 15.346), (64, 0.00043572372449, 166, 31.41), (128, 0.00020276242984, 166, 65.12)),
    "AMPLE, standard MPM": (
        (4, 0.063252187793, 174, 2.065), (8, 0.097003529777, 189, 4.177), (16, 0.086696486473, 195, 8.452),
        (32, 0.080055981334, 200, 17.451), (64, 0.082886984732, 204, 37.33)),
}


def peers():
    """Records of AMPLE on the same column."""
    return [Record("column", curve, size(n), {"cells": n}, {"stress": error}, (seconds,), newton,
                   2 * int(np.ceil(n * SOFT.height() / SOFT.length)), source="AMPLE 1.1 (GNU Octave)")
            for curve, rows in AMPLE.items() for n, error, newton, seconds in rows]


def peer_curves(quick=False):
    """Curves of Kratos MPM, as `curves` returns them."""
    return {f"Kratos, standard MPM, {law}": [(size(n), {"cells": n, "law": law}) for n in CELLS[:2 if quick else 5]]
            for law in ("Hencky", "neo-Hooke")}


def peer_solve(python, cells, law):
    """RunResult of a run of Kratos. Raises StepError if one of its steps fails, HybridError if its script fails."""
    asked = {name: getattr(SOFT, name) for name in ("length", "young", "density", "gravity", "steps")}
    answer = ask(python, "kratos_column.py", {**asked, "cells": cells, "law": law, "tolerance": 1e-6}, 1)
    if answer["failed"]:
        raise StepError(answer["failed"])
    exact = -SOFT.density * SOFT.gravity * (SOFT.length - np.array(answer["heights"]))
    wrong = np.mean(np.abs(answer["stress"] - exact)) / SOFT.weight   # all points have the same volume
    return RunResult({"stress": float(wrong)}, sum(answer["newton"]), answer["unknowns"], sum(answer["seconds"]))


PROBLEM = Problem(
    title="self-weight column",
    errors={"stress": "Σ |σ - exact| V / (ρ g L Σ V)", "height": "|height - exact| / L"},
    shown=(PUBLISHED, "standard MPM", "rigid domains", "AMPLE, GIMP", "Kratos, standard MPM, neo-Hooke"),
    chosen=("h and load steps", "load steps"), curves=curves, solve=solve, length="height", transferable=transfer,
    peers=peers, peer_curves=peer_curves, peer_solve=peer_solve)
