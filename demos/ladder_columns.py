"""First rungs of the ladder: columns under their own weight, in closed form by Lambert's W.

      z |  soil of length L between smooth walls, ν = 0: the area of a section stays,
        |
       ===      τ = E ln λ,  σ_zz = E ln λ / λ = -ρ g (L - Z)    ->    λ = W(s)/s,  s = ρ g (L - Z)/E

Gravity is turned on in equal quasi-static steps. Errors: Σ |σ_zz - exact| V / (ρ g L Σ V), and the height's over L.
"""

import time
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad
from scipy.special import lambertw

from hybrid.build import build
from hybrid.scene import Axis, Grid, Material, Output, Scene, Soil, Solver, Stage, Time


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


@dataclass(frozen=True)
class Settled:
    """Z, stress (n,) of the points; height [m]; errors [-] of stress and height; unknowns, seconds of the run."""

    Z: np.ndarray
    stress: np.ndarray
    height: float
    stress_error: float
    height_error: float
    unknowns: int
    seconds: float


def settle(column, cells, steps=None, basis="gimp", domain="stretch", full=False, **soil):
    """Settled column on `cells` cells; full: four cells of a three-dimensional grid at each height, else one axis."""
    size = column.length / cells
    side = Axis(start=0.0, end=2 * size, size=size, collapsed=not full)
    scene = Scene(
        name="column", grid=Grid(side, side, Axis(start=0.0, end=column.length, size=size)),
        soil=Soil(Material(law="hencky", young=column.young, poisson=0.0, density=column.density), geostatic=False,
                  basis=basis, domain=domain, **soil),
        gravity=(0.0, 0.0, -column.gravity), time=Time(step=1.0, inertia=False),
        stages=(Stage("load", steps or column.steps, gravity=(0.0, 1.0)),),
        solver=Solver(linear="direct", tolerance=1e-9, iterations=25), output=Output(every=0, checkpoint=0))
    simulation, begun = build(scene), time.perf_counter()
    for record in simulation.steps():
        assert record.increments == 1
    seconds = time.perf_counter() - begun
    points, constants = simulation.state.points, simulation.model.soil.constants
    Z, found = constants.position[:, 2], points.stress[:, 2, 2]
    top = np.argmax(points.position[:, 2])
    height = points.position[top, 2] + constants.half[top, 2] * points.deformation[top, 2, 2]
    wrong = np.abs(found + column.density * column.gravity * (column.length - Z))
    return Settled(Z, found, height, np.average(wrong, weights=constants.volume) / column.weight,
                   abs(height - column.height()) / column.length, len(simulation.evaluation.soil), seconds)


def rates(cells, errors):
    """Observed order of `errors` (list) in the cell size over all `cells`."""
    return -np.polyfit(np.log(cells), np.log(errors), 1)[0]
