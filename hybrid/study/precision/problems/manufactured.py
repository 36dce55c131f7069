"""Manufactured solutions of Hencky's law: a standing wave in a column, and a swirl in a cube between rollers.

    wave    u_z = A sin(kZ) cos(ωt),   k = 2π/L, ω = k √(E/ρ), ν = 0             both ends held
            u_z = A cos(kZ) cos(ωt) + V t                                        free ends, drifts over the grid
    swirl   u_x = A sin(kX) cos(kY) cos(kZ) cos(ωt),  u_y, u_z likewise,         shear without traction on the faces;
            A_x + A_y + A_z = 0,  k = π/L, ω² = 3 k² G/ρ, ν = 0.3                keeps the volume to first order

Body force: ρ b = ρ ü - Div P with P = τ F^-T and τ = Λ tr(ln V) I + 2 G ln V. In the column P = E ln λ / λ, so

    Div P = E (1 - ln λ)/λ² u''

Errors are root mean squares over the points: of displacement relative to A, of stress relative to E k A. They are taken
after 0.6 periods: after a whole period a wave with a phase error ε would have an error of ε² only.
"""

from dataclasses import dataclass
from time import process_time

import numpy as np

from hybrid.bench.timed_steps import newton_iterations, timed_steps
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.soil.domains import updated_half
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import RunResult
from hybrid.study.precision.settings import (
    PUBLISHED,
    SCHEMES,
    SOILS,
    few,
    krylov_tolerances,
    newton_tolerances,
    transferable,
)

YOUNG, DENSITY, LENGTH = 1e5, 1000.0, 1.0
DIFFERENCE = 1e-5 * LENGTH
TIGHT = {"linear": "direct", "tolerance": 1e-9}   # leaves the error of the discretisation only


def kirchhoff(F, poisson):
    """τ (n, 3, 3) [Pa] of F (n, 3, 3)."""
    squares, directions = np.linalg.eigh(F @ F.transpose(0, 2, 1))
    strain, shear = 0.5 * np.log(squares), YOUNG / 2 / (1 + poisson)
    principal = 2 * shear * (strain + poisson / (1 - 2 * poisson) * strain.sum(axis=1, keepdims=True))
    return np.einsum("nia,na,nja->nij", directions, principal, directions)


class Solution:
    """Base of waves and swirls, which define axes (3,) bool, amplitude, wave, frequency, poisson, drift and `shape`."""

    drift = 0.0
    span = 0.6      # periods that a run lasts

    @property
    def duration(self):
        """[s] of a run."""
        return self.span * 2 * np.pi / self.frequency

    def motion(self, t, X):
        """Displacement, velocity, acceleration (n, 3) at time t [s] of initial positions X (n, 3)."""
        shape, angle = self.shape(X)[0], self.frequency * t
        along = np.array([0.0, 0.0, self.drift])
        return (shape * np.cos(angle) + along * t, -self.frequency * shape * np.sin(angle) + along,
                -self.frequency**2 * shape * np.cos(angle))

    def deformation(self, t, X):
        """F (n, 3, 3)."""
        return np.eye(3) + self.shape(X)[1] * np.cos(self.frequency * t)

    def stress(self, t, X):
        """Cauchy's (n, 3, 3) [Pa]."""
        F = self.deformation(t, X)
        return kirchhoff(F, self.poisson) / np.linalg.det(F)[:, None, None]

    def divergence(self, t, X):
        """Div P (n, 3) [N/m³] by central differences."""
        total = np.zeros_like(X)
        for axis in np.flatnonzero(self.axes):
            for sign in (-1, 1):
                F = self.deformation(t, X + sign * DIFFERENCE * np.eye(3)[axis])
                P = kirchhoff(F, self.poisson) @ np.linalg.inv(F).transpose(0, 2, 1)
                total += sign * P[:, :, axis] / (2 * DIFFERENCE)
        return total

    def force(self, t, X):
        """Body force b (n, 3) [m/s²]."""
        return self.motion(t, X)[2] - self.divergence(t, X) / DENSITY


@dataclass(frozen=True)
class Wave(Solution):
    """amplitude [m]; drift [m/s] of the column, whose ends are free then."""

    amplitude: float = 0.05
    drift: float = 0.0
    poisson = 0.0
    axes = np.array([False, False, True])
    wave = 2 * np.pi / LENGTH
    frequency = wave * np.sqrt(YOUNG / DENSITY)

    def _along(self, Z):
        """Shape of u_z [m] and its first and second derivatives."""
        s, c, k = np.sin(self.wave * Z), np.cos(self.wave * Z), self.wave
        return self.amplitude * np.array((c, -k * s, -k**2 * c) if self.drift else (s, k * c, -k**2 * s))

    def shape(self, X):
        value, slope = np.zeros_like(X), np.zeros((len(X), 3, 3))
        value[:, 2], slope[:, 2, 2], _ = self._along(X[:, 2])
        return value, slope

    def divergence(self, t, X):
        _, slope, bend = self._along(X[:, 2]) * np.cos(self.frequency * t)
        out = np.zeros_like(X)
        out[:, 2] = YOUNG * (1 - np.log1p(slope)) / (1 + slope) ** 2 * bend
        return out


@dataclass(frozen=True)
class Swirl(Solution):
    """amplitude [m] of u_x; u_y and u_z go the other way with half of it each."""

    amplitude: float = 0.05
    poisson = 0.3
    axes = np.array([True, True, True])
    span = 0.3
    wave = np.pi / LENGTH
    frequency = wave * np.sqrt(3 * YOUNG / 2 / (1 + poisson) / DENSITY)

    def shape(self, X):
        s, c = np.sin(self.wave * X), np.cos(self.wave * X)
        value, slope = np.empty_like(X), np.empty((len(X), 3, 3))
        for i, share in enumerate((1.0, -0.5, -0.5)):
            factors = np.where(np.arange(3) == i, s, c)
            rates = np.where(np.arange(3) == i, c, -s) * self.wave
            value[:, i] = share * self.amplitude * factors.prod(axis=1)
            for j in range(3):
                others = np.where(np.arange(3) == j, rates, factors)
                slope[:, i, j] = share * self.amplitude * others.prod(axis=1)
        return value, slope


@dataclass(frozen=True)
class Vibration:
    """Displacement (n, 3) of the points at the end; errors [-] of displacement and stress; cell faces crossed per
    point; increments, Newton iterations, unknowns, seconds of the run."""

    moved: np.ndarray
    displacement: float
    stress: float
    crossed: float
    increments: int
    iterations: int
    unknowns: int
    seconds: float


def vibrate(solution, cells, steps, scheme=(), force=None, solver=TIGHT, method="default", **soil):
    """Vibration of a run in `steps` steps on cells of LENGTH / cells along the axes with motion.

    scheme, solver, soil: values of the tables; method: "default" or "published"; force: instead of the solution's, for
    tests with a wrong one.
    """
    size, free = LENGTH / cells, bool(solution.drift)
    below = np.ceil(2 * solution.amplitude / size) * size * free
    above = np.ceil((solution.drift * solution.duration + 2 * solution.amplitude) / size) * size * free
    axes = [Axis(start=0.0, end=LENGTH, size=size, collapsed=not moves) for moves in solution.axes]
    axes[2] = Axis(start=-below, end=LENGTH + above, size=size)
    ends = "free" if free else "roller"
    material = Material(law="hencky", young=YOUNG, poisson=solution.poisson, density=DENSITY)
    scene = Scene(
        name="manufactured", grid=Grid(*axes, Faces(z_min=ends, z_max=ends)),
        soil=Soil(material, geostatic=False, lower=(0.0, 0.0, 0.0), upper=(LENGTH,) * 3, **soil),
        gravity=(0.0, 0.0, 0.0), time=Time(step=solution.duration / steps, **dict(scheme)),
        stages=(Stage("vibrate", steps),), solver=Solver(**solver),
        method=method, output=Output(every=0, checkpoint=0))
    simulation = build(scene, body_force=force or solution.force)
    X = simulation.model.soil.constants.position
    start(simulation, solution, X)
    crossed, cells_of = 0, np.floor(simulation.state.points.position / size)

    def see_crossings(_):
        nonlocal crossed, cells_of
        before, cells_of = cells_of, np.floor(simulation.state.points.position / size)
        crossed += np.count_nonzero(cells_of != before)

    records, seconds = timed_steps(simulation, after=see_crossings, clock=process_time)
    points = simulation.state.points
    missed = (points.position - X - solution.motion(solution.duration, X)[0])[:, solution.axes] / solution.amplitude
    wrong = points.stress - solution.stress(solution.duration, X)
    wrong = wrong[:, solution.axes][:, :, solution.axes] / (YOUNG * solution.wave * solution.amplitude)
    return Vibration(points.position - X, np.sqrt(np.mean(missed**2)), np.sqrt(np.mean(wrong**2)), crossed / len(X),
                   sum(r.increments for r in records), newton_iterations(records), len(simulation.evaluation.soil),
                     sum(seconds))


def start(simulation, solution, X):
    """Set the points to the exact motion and deformation at t = 0."""
    points, soil = simulation.state.points, simulation.model.soil
    u, points.velocity[:], points.acceleration[:] = solution.motion(0.0, X)
    points.position[:] = X + u
    F = solution.deformation(0.0, X)
    points.deformation[:], points.b_elastic[:] = F, F @ F.transpose(0, 2, 1)
    points.stress[:] = solution.stress(0.0, X)
    points.half_width[:] = updated_half(soil.domain, soil.constants.half_width, F, points.position, soil.grid.axes)


def in_time(solution, cells, counts, reference, scheme=(), **soil):
    """Errors of displacement (root mean square, relative to A) against a run of `reference` steps on the same grid."""
    exact = vibrate(solution, cells, reference, scheme, **soil).moved
    apart = [(vibrate(solution, cells, n, scheme, **soil).moved - exact)[:, solution.axes] for n in counts]
    return np.sqrt(np.mean(np.square(apart), axis=(1, 2))) / solution.amplitude


CELLS, FIXED, STEPS = (8, 16, 32, 64, 128, 256), 64, (16, 32, 64, 128, 256)


def curves(quick=False):
    """{curve: [(setting, values of `solve`), ...]}; two steps a cell unless a curve's label gives another number."""
    def over(cells=CELLS[:-1], ratio=2, **values):
        return [(f"h = {LENGTH / n:.3g} m", {"cells": n, "steps": round(ratio * n), **values}) for n in cells]

    def in_steps(**values):
        return [(f"Δt = {Wave().duration / k:.2g} s", {"cells": 2 * FIXED, "steps": k, **values}) for k in STEPS]

    all_curves = {
        "default": over(CELLS),
        PUBLISHED: over(method="published"),
        **{name: over(soil=soil) for name, soil in SOILS.items()},
        "increments transfer": over(soil={"transfer": "increments"}),
        "Δt four times as long": over(CELLS[1:], 1 / 2),
        **{name: in_steps(scheme=scheme) for name, scheme in SCHEMES.items()},
        "Newton tolerance": newton_tolerances(cells=FIXED, steps=2 * FIXED),
        "Krylov tolerance": krylov_tolerances(cells=FIXED, steps=2 * FIXED),
    }
    return few(all_curves, {"default": 3, "standard MPM": 3, "Newton tolerance": 1}) if quick else all_curves


def transfer(values):
    """Settings that a scene can take over from a run of Newmark's (1/4, 1/2) with two steps a cell, else None."""
    return transferable(values, values["cells"], "cells", "steps") if values["steps"] == 2 * values["cells"] else None


def solve(cells, steps, scheme=None, soil=None, solver=None, method="default"):
    """RunResult of the shaken wave; scheme, soil, solver: values of the tables that differ from the defaults."""
    found = vibrate(Wave(0.05), cells, steps, scheme or {}, solver=solver or {}, method=method,
                    **(soil or {}))
    return RunResult({"displacement": float(found.displacement), "stress": float(found.stress)}, found.iterations,
                 found.unknowns, found.seconds)


PROBLEM = Problem(
    title="Hencky manufactured solution",
    errors={"displacement": "root mean square of |u - exact| / A",
            "stress": "root mean square of |σ - exact| / (E k A)"},
    shown=(PUBLISHED, "standard MPM", "rigid domains", "increments transfer", "Newton tolerance"),
    chosen=("Δt four times as long", *SCHEMES), curves=curves, solve=solve, length="wave length", transferable=transfer)
