"""A cantilever bent right down by a dead load at its end, in plane strain, against beams.

    wall |===========  L = 10 m, height H = 1 m, E = 12 MPa, ν = 0.2, load F = 100 kN per metre of width
         |       F |   50 quasi-static steps; E' = E/(1 - ν²), G = E/2(1 + ν)
                   v

With θ the turn of a section, s the initial length along the beam and forces in the section N = F sin θ, Q = F cos θ,

    x' = (1 + e) cos θ - g sin θ      d' = (1 + e) sin θ + g cos θ      θ' = κ      M' = -F x'      M(L) = 0

with the drop d. Elastica: e = g = 0, M = E'H³/12 κ: the tip drops 8.062 m, shortens 5.461 m. But F is large enough to
strain the fibres at the wall by ±20 %, where Hencky's law is not that of Hooke. `hencky_beam`: Q = 5/6 G H g and

    N = ∫ P ∂λ/∂e dZ,  M = ∫ P ∂λ/∂κ dZ,   P = E' ln λ/λ,   λ^(1+n) = (1 + e)^(1+n) - (1 + n) κ Z,   n = ν/(1 - ν)

the stretch λ of the fibre at initial height Z where fibres thicken and thin at no lateral stress: λ = 1 + e - κ z,
dz/dZ = λ^-n. It drops 8.240 m, shortens 5.511 m. The difference goes with (H/L)² at the same E'H³.

The load is shared by the last two columns of points, 3/2 and -1/2 of it, so that its line is the end face.

The study compares the tip with the beam of Hencky fibres. The beam is itself a model: the finest grids converge to a
position 0.4 % from it, so smaller errors are accidental. The residual has to increase before it falls; curves of
other methods are without a line search, which whole updates that make progress are not affected by. Without
the ghost penalty, which is on by default, no run is completed: domain corners that overlap only a small part of a cell
give its nodes hardly any stiffness.
"""

import functools
from dataclasses import dataclass
from time import process_time

import numpy as np
from scipy.integrate import solve_bvp

from hybrid.bench.timed_steps import newton_iterations, timed_steps
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import RunResult
from hybrid.study.precision.settings import PUBLISHED, SOILS, few, krylov_tolerances, newton_tolerances, transferable

LENGTH, YOUNG, POISSON, LOAD, DENSITY, STEPS = 10.0, 12e6, 0.2, 1e5, 1000.0, 50
# Sections rotate more than they strain: the residual rises before it falls.
LARGE_ROTATION = {"linear": "direct", "tolerance": 1e-7, "line_search": False}
HEIGHTS, WEIGHTS = np.polynomial.legendre.leggauss(12)


def young(height):
    """E [Pa] that gives a beam of `height` [m] the bending stiffness of that of 1 m."""
    return YOUNG / height**3


def solved(section):
    """(drop, shortening) [m] of the tip; section(N, M) -> e, κ and shear flexibility [1/N] make the beam."""
    def rates(s, u):
        out = np.empty_like(u)
        for i, (_, _, turn, moment) in enumerate(u.T):
            stretch, curvature, flexible = section(LOAD * np.sin(turn), moment)
            shear = flexible * LOAD * np.cos(turn)
            along = (1 + stretch) * np.cos(turn) - shear * np.sin(turn)
            out[:, i] = along, (1 + stretch) * np.sin(turn) + shear * np.cos(turn), curvature, -LOAD * along
        return out

    s = np.linspace(0.0, LENGTH, 41)
    guess = np.array([0.7 * s, 0.6 * s, 1.2 * s / LENGTH, 0.4 * LOAD * (LENGTH - s)])
    found = solve_bvp(rates, lambda a, b: np.array([a[0], a[1], a[2], b[3]]), s, guess, tol=1e-5)
    assert found.success
    return found.y[1, -1], LENGTH - found.y[0, -1]


def elastica():
    """(drop, shortening) [m] of a beam that only bends."""
    stiffness = YOUNG / (1 - POISSON**2) / 12
    return solved(lambda force, moment: (0.0, moment / stiffness, 0.0))


@functools.cache
def hencky_beam(height=1.0):
    """(drop, shortening) [m] of a beam of Hencky fibres that also stretches and shears."""
    modulus, n = young(height) / (1 - POISSON**2), POISSON / (1 - POISSON)
    Z, weight = 0.5 * height * HEIGHTS, 0.5 * height * WEIGHTS
    flexible = 2 * (1 + POISSON) / (5 / 6 * young(height) * height)

    def forces(e, k):
        stretch = ((1 + e) ** (1 + n) - (1 + n) * k * Z) ** (1 / (1 + n))
        share = weight * modulus * np.log(stretch) / stretch
        return np.array([share @ ((1 + e) / stretch) ** n, -share @ (Z * stretch**-n)])

    def section(force, moment):
        x, small = np.array([force / (modulus * height), moment / (modulus * height**3 / 12)]), 1e-7
        for _ in range(30):
            now = forces(*x)
            tangent = np.column_stack([forces(x[0] + small, x[1]) - now, forces(x[0], x[1] + small) - now]) / small
            step = np.linalg.solve(tangent, [force, moment] - now)
            x = x + step
            if np.abs(step).max() < 1e-9:
                return *x, flexible
        raise AssertionError(f"no strain for N = {force:g}, M = {moment:g}")

    return solved(section)


@dataclass(frozen=True)
class Bent:
    """drop, shortening [m] of the tip after each step; X, position (n, 3), stress (n, 3, 3) of the
    points at the end; Newton iterations; unknowns; seconds of the run."""

    drop: np.ndarray
    shortening: np.ndarray
    X: np.ndarray
    position: np.ndarray
    stress: np.ndarray
    iterations: int
    unknowns: int
    seconds: float


def bend(size, points_per_axis=2, height=1.0, steps=STEPS, full=False, solver=LARGE_ROTATION,
         method="default", **soil):
    """Bent cantilever on cells of `size` [m]; full: three-dimensional, two cells wide between rollers.

    solver, soil: values of these tables; method: "default" or "published".
    """
    width = 2 * size
    below = np.ceil(9.3 / size) * size
    grid = Grid(
        Axis(start=0.0, end=LENGTH + size, size=size), Axis(start=0.0, end=width, size=size, collapsed=not full),
        Axis(start=-below, end=height + size, size=size), Faces("fixed", "free", "roller", "roller", "free", "free"))
    material = Material(law="hencky", young=young(height), poisson=POISSON, density=DENSITY)
    scene = Scene(
        name="cantilever", grid=grid,
        soil=Soil(material, geostatic=False, lower=(0.0, 0.0, 0.0), upper=(LENGTH, width, height),
                  points_per_axis=points_per_axis, **soil),
        gravity=(0.0, 0.0, 0.0), time=Time(step=1.0, inertia=False), stages=(Stage("load", steps),),
        method=method, solver=Solver(**solver), output=Output(every=0, checkpoint=0))

    def force(t, X):
        columns, out = np.rint((LENGTH - X[:, 0]) * points_per_axis / size - 0.5), np.zeros_like(X)
        mass = DENSITY * width * height * size / points_per_axis      # of a column of points
        out[:, 2] = -LOAD * width * t / steps / mass * np.select([columns == 0, columns == 1], [1.5, -0.5], 0.0)
        return out

    simulation, tips = build(scene, body_force=force), []
    constants = simulation.model.soil.constants
    last = constants.position[:, 0] > LENGTH - size / points_per_axis

    def see_tip(_):
        points = simulation.state.points
        face = points.position[last] + points.deformation[last, :, 0] * constants.half_width[last, :1]
        tips.append(face.mean(axis=0) - (LENGTH, 0.0, 0.5 * height))

    records, seconds = timed_steps(simulation, after=see_tip, clock=process_time)
    tips, points = np.array(tips), simulation.state.points
    return Bent(-tips[:, 2], -tips[:, 0], constants.position, points.position, points.stress,
                newton_iterations(records), len(simulation.evaluation.soil), sum(seconds))


SIZES, FIXED = (1.0, 0.5, 0.25, 0.125), 0.25


def curves(quick=False):
    """{curve: [(setting, values of `solve`), ...]}."""
    def over(sizes=SIZES, **values):
        return [(f"h = {size:g} m", {"size": size, **values}) for size in sizes]

    def bending(sizes=SIZES, soil=(), solver=()):
        return over(sizes, soil=dict(soil), solver={"line_search": False, **dict(solver)})

    (_, fixed), = bending([FIXED])
    all_curves = {
        "default": over(),
        PUBLISHED: over(method="published"),
        "no line search": bending(),
        "standard MPM": bending(soil=SOILS["standard MPM"]),
        "3 points an axis": bending(soil=SOILS["3 points an axis"]),
        "F-bar": bending(soil={"fbar": True}),
        "direct solver": bending(solver={"linear": "direct"}),
        "ghost penalty": [(f"{g:g}", {**fixed, "soil": {"ghost": g}}) for g in (0.003, 0.03, 0.1, 1.0)],
        "load steps": [(f"{k} steps", {**fixed, "steps": k}) for k in (10, 20, 50, 100)],
        "Newton tolerance": newton_tolerances(size=FIXED),
        "Krylov tolerance": krylov_tolerances(size=FIXED),
    }
    return few(all_curves, {"default": 2, "no line search": 3, "standard MPM": 2}) if quick else all_curves


def transfer(values):
    """Settings that a scene can take over from a run in the default number of steps, else None."""
    return transferable(values, 1.0 / values["size"], "size")


def solve(size, steps=STEPS, soil=None, solver=None, method="default"):
    """RunResult of the cantilever 1 m high; soil, solver: values of these tables that differ from the defaults."""
    found = bend(size, steps=steps, solver=solver or {}, method=method, **(soil or {}))
    tip, exact = np.array([found.drop[-1], found.shortening[-1]]), np.array(hencky_beam())
    drop, shortening = np.abs(tip / exact - 1)
    return RunResult({"tip": float(np.linalg.norm(tip - exact) / np.linalg.norm(exact)), "drop": float(drop),
                  "shortening": float(shortening)}, found.iterations, found.unknowns, found.seconds)


PROBLEM = Problem(
    title="cantilever bent right down",
    errors={"tip": "distance of the tip from the exact one / exact displacement", "drop": "|drop / exact - 1|",
            "shortening": "|shortening / exact - 1|"},
    shown=(PUBLISHED, "standard MPM", "3 points an axis", "no line search", "Newton tolerance"), chosen=("load steps",),
    curves=curves, solve=solve, length="depth", transferable=transfer, certain=0.004)
