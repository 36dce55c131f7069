"""A pulse of small strain runs along a bar, is reflected by the free end and by the wall, and should return unchanged.

    wall |-----/\\------------- free      c = √(E/ρ), ν = 0;  u = A exp(-(Z - z0 - ct)²/2w²)
    z = 0     z0 ->               L      Riemann: v = -c u'

The free end reflects it upright, the wall upside down: after 2L/c it is its own negative. Speed: place of the
maximum before the first end is reached. Energy: kinetic of the points and elastic.
"""

import time
from dataclasses import dataclass

import numpy as np

from hybrid.scene import Axis, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.step.energy import energies

YOUNG, DENSITY, LENGTH = 1e5, 1000.0, 1.0
SPEED = np.sqrt(YOUNG / DENSITY)
START, WIDTH, AMPLITUDE = 0.32, 0.08, 1e-6      # z0, w, A [m]
WAY = 0.4                                      # [m] over which the speed is taken
SCHEMES = {
    "Newmark (1/4, 1/2)": {"scheme": "newmark"},
    "Newmark (0.5625, 1)": {"beta": 0.5625, "gamma": 1.0},
    "generalised α, ρ∞ = 0.8": {"scheme": "generalised-alpha", "spectral_radius": 0.8},
    "generalised α, ρ∞ = 0": {"scheme": "generalised-alpha", "spectral_radius": 0.0},
}


def pulse(Z):
    """Displacement [m] at the start and its first two derivatives."""
    s = (Z - START) / WIDTH
    u = AMPLITUDE * np.exp(-0.5 * s**2)
    return u, -s / WIDTH * u, (s**2 - 1) / WIDTH**2 * u


@dataclass(frozen=True)
class Ride:
    """times [s]; Z (n,), displacement (times, n) of a line of points; energy (times,) relative to the start; unknowns;
    seconds of the run."""

    times: np.ndarray
    Z: np.ndarray
    displacement: np.ndarray
    energy: np.ndarray
    unknowns: int
    seconds: float

    def speed(self):
        """Of the maximum over WAY, relative to c."""
        n = np.argmin(np.abs(self.times - WAY / SPEED))
        u = self.displacement[n]
        top = np.argmax(u)
        bend = np.polyfit(self.Z[top - 2:top + 3] - self.Z[top], u[top - 2:top + 3], 2)
        place = self.Z[top] - bend[1] / (2 * bend[0])
        return (place - START) / self.times[n] / SPEED

    def missed(self):
        """Root mean square of the displacement that is wrong at the end, relative to that of the pulse."""
        turned = round(self.times[-1] * SPEED / LENGTH) // 2
        wanted = (-1) ** turned * pulse(self.Z)[0]
        return np.sqrt(np.mean((self.displacement[-1] - wanted) ** 2) / np.mean(wanted**2))


def ride(cells, passes=2, courant=0.5, scheme=(), full=False, **soil):
    """Ride of the pulse over the bar `passes` times (even) in steps of `courant` h/c; full: a bar in three dimensions,
    two cells wide."""
    size = LENGTH / cells
    side = Axis(start=0.0, end=2 * size, size=size, collapsed=not full)
    steps = round(passes * cells / courant)
    scene = Scene(
        name="bar", grid=Grid(side, side, Axis(start=0.0, end=LENGTH + size, size=size)),
        soil=Soil(Material(law="hencky", young=YOUNG, poisson=0.0, density=DENSITY), geostatic=False, top=LENGTH,
                  **soil),
        gravity=(0.0, 0.0, 0.0), time=Time(step=courant * size / SPEED, **dict(scheme)), stages=(Stage("ride", steps),),
        solver=Solver(linear="direct", tolerance=1e-8), output=Output(every=0, checkpoint=0))
    simulation = build(scene)
    Z, points = simulation.model.soil.constants.position[:, 2], simulation.state.points
    u, slope, bend = pulse(Z)
    points.position[:, 2] += u
    points.velocity[:, 2], points.acceleration[:, 2] = -SPEED * slope, SPEED**2 * bend
    points.deformation[:, 2, 2], points.b_elastic[:, 2, 2] = 1 + slope, (1 + slope) ** 2
    points.stress[:, 2, 2] = YOUNG * np.log1p(slope) / (1 + slope)
    line = np.flatnonzero(np.all(points.position[:, :2] == points.position[0, :2], axis=1))
    first = energies(simulation.model, simulation.state)
    energy = [first["kinetic"] + first["elastic"]]
    begun, rows = time.perf_counter(), [points.position[line, 2] - Z[line]]
    for record in simulation.steps():
        points = simulation.state.points
        rows.append(points.position[line, 2] - Z[line])
        energy.append(record.energies["kinetic"] + record.energies["elastic"])
    return Ride(np.arange(steps + 1) * scene.time.step, Z[line], np.array(rows), np.array(energy) / energy[0],
                len(simulation.evaluation.soil), time.perf_counter() - begun)
