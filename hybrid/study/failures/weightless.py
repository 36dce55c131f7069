"""Hardly any weight: a residual relative to the forces acting cannot fall below the round-off of the stiffness.

    | . . . |   block of 1 x 1 x 2 m between rollers, K = 8.3 MPa, ν = 0.3, under a share of gravity, in 2 quasi-static
    | . . . |   steps from no stress at all
    |_______|

F = 1 + strain knows a strain to 2e-16, stress to K 2e-16 = 2e-9 Pa, and forces over faces of h² to 5e-10 N. A weight of
20 kN and a tolerance of 1e-6 leave room for 7 powers of ten. With less weight the tolerance asks for more than numbers
can hold, and has to be looser. Without any, all forces vanish, and nothing may be divided by them. Exact: the mean of
σ_zz is -ρ g L/2 by equilibrium alone.
"""

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen

TITLE = "hardly any weight"
PARAMETERS = ("share of gravity",)
MEASURE, RIGHT, WRONG = "error of the mean stress over the largest", 0.01, 0.1
METHODS = {"tolerance of 1e-9": {"tolerance": 1e-9}, "tolerance of 1e-6": {}, "tolerance of 1e-3": {"tolerance": 1e-3}}
DEFAULT = "tolerance of 1e-6"
SAYS = r"round-off of its stiffness, limit .*looser solver\.tolerance"
SIZE, HEIGHT, DENSITY, GRAVITY = 0.5, 2.0, 1000.0, 10.0


def settings(quick=False):
    return [(share,) for share in ((1.0, 1e-9, 0.0) if quick else (1.0, 1e-3, 1e-6, 1e-8, 1e-9, 1e-10, 0.0))]


def solve(share, **solver):
    """Seen of a block under that share of gravity."""
    side = Axis(start=0.0, end=1.0, size=SIZE)
    material = Material(law="hencky", young=1e7, poisson=0.3, density=DENSITY)
    simulation, _, _ = watched(Scene(
        name="block", soil=Soil(material, geostatic=False, top=HEIGHT), gravity=(0.0, 0.0, -share * GRAVITY),
        grid=Grid(side, side, Axis(start=0.0, end=HEIGHT + SIZE, size=SIZE), Faces()), time=Time(1.0, inertia=False),
        stages=(Stage("load", 2, gravity=(0.0, 1.0)),), solver=Solver(**solver), output=Output(every=0, checkpoint=0)))
    stress, weight = simulation.state.points.stress[:, 2, 2].mean(), share * DENSITY * GRAVITY * HEIGHT
    return Seen(float(abs(stress + weight / 2) / weight if share else abs(stress)))
