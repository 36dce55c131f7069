"""Stretch: soil that is drawn out by more than it has points in a cell parts between them.

    ////////    bar of 8 m, 16 cells, hung from its upper end by a weight that is turned on in 20 quasi-static steps;
      |  |      stretch s at the top, none at the bottom; nothing moves sideways
      |  |
      |__|      law  τ = E/2 (λ² - 1), so P = τ/λ = E/2 (λ - 1/λ) grows for ever: the bar itself never tears

Domains of n points a cell tile the bar until one is as wide as a cell, λ = n, and are cut off there, since wider ones
would reach nodes that the sparsity does not know. Points without domains may leave cells empty from λ = n on; domains
that do not follow leave gaps at once. Exact: Cauchy's stress is that of dead load, σ = ρ g (height above the lower end
at the start).
"""

import numpy as np

from hybrid.laws import Response
from hybrid.laws.hencky import Hencky
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen

TITLE = "soil drawn out"
PARAMETERS = ("largest stretch",)
MEASURE, RIGHT, WRONG = "error of the stress over the largest", 0.01, 0.05
METHODS = {"standard MPM": {"basis": "mpm", "domain": "none"}, "domains as at the start": {"domain": "none"},
           "1 point a cell": {"points": 1}, "domains that follow": {}, "3 points a cell": {"points": 3},
           "4 points a cell": {"points": 4}}
DEFAULT = "domains that follow"
SAYS = r"cells wide, limit .*soil\.points_per_axis|points_per_axis = .*limit 2|soil\.(basis|domain) = .*Set soil\."
LENGTH, CELLS, DENSITY, GRAVITY, STEPS = 8.0, 16, 1000.0, 10.0, 20


def settings(quick=False):
    return [(stretch,) for stretch in ((1.5, 5.0) if quick else (1.1, 1.5, 1.8, 2.5, 3.5, 5.0))]


class Rubber(Hencky):
    """τ = E/2 (λ² - 1) in every principal direction."""

    def respond(self, strain, plastic_strain=None):
        young, square = self.young[:, None], np.exp(2 * strain)
        tangent = young[:, None] * square[:, None] * np.eye(3)
        return Response(0.5 * young * (square - 1), strain, tangent)

    def energy(self, elastic):
        return np.sum(self.young[:, None] / 4 * (np.exp(2 * elastic) - 1 - 2 * elastic), axis=1)


def solve(stretch, points=2, **soil):
    """Seen of a bar of that largest stretch."""
    weight, size = DENSITY * GRAVITY * LENGTH, LENGTH / CELLS
    young = 2 * weight / (stretch - 1 / stretch)
    pull = weight / young * np.linspace(0.0, 1.0, 1000)
    drawn = LENGTH * np.mean(pull + np.sqrt(pull**2 + 1))
    side = Axis(start=0.0, end=1.0, collapsed=True)
    simulation, _, told = watched(Scene(
        name="bar", soil=Soil(Material(law="user", density=DENSITY), geostatic=False, lower=(0.0, 0.0, -LENGTH),
                              upper=(1.0, 1.0, 0.0), points_per_axis=(1, 1, points), **soil),
        grid=Grid(side, side, Axis(start=-size * (drawn // size + 3), end=0.0, size=size),
                  Faces(z_min="free", z_max="fixed")),
        gravity=(0.0, 0.0, -GRAVITY), time=Time(1.0, inertia=False), output=Output(every=0, checkpoint=0),
        stages=(Stage("hang", STEPS, gravity=(0.0, 1.0)),)), law=lambda p, stress: Rubber(np.full(len(p), young), 0.0))
    height, stress = simulation.initial_position[:, 2] + LENGTH, simulation.state.points.stress[:, 2, 2]
    wrong = np.abs(stress - DENSITY * GRAVITY * height) / weight
    return Seen(float(wrong.mean()), tuple(t for t in told if "soil." in t))
