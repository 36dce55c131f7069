"""Singular scenes: more ways to move than points that resist, or nothing that holds them.

    one cell     8 points in a cell of 0.5 m            all held    its nodes are all held: no unknowns
    on rollers   a pillar, free to slide                single row  4 cells high, 1 x 1 x 2 points each
    one point    in one cell, 8 nodes                   sparse      a pillar, 1 point a cell
    unheld       a cube that no face holds, heavy all the same

A point that sees its cell from the centre resists no hourglass, and soil without inertia that nothing holds has no
place to be. The stiffness is singular to round-off, so whether a factor of it exists is chance. Either the load is
carried, or it is said what is missing; nothing may crash or give numbers that mean nothing. ν = 0 and own weight, 2
quasi-static steps. Exact: the mean of σ_zz is -ρ g L/2 by equilibrium alone, where nodes are free; 0 where all are
held.
"""

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen

TITLE = "singular scenes"
PARAMETERS = ("scene",)
MEASURE, RIGHT, WRONG = "error of the mean stress, or largest slip over the height", 0.01, 0.05
METHODS = {"direct solver": {"linear": "direct"}, "Krylov method": {}}
DEFAULT = "Krylov method"
SAYS = r"points_per_axis = .*limit 2.*Set|nothing holds the soil along .*limit 1"
SIZE, DENSITY, GRAVITY = 0.5, 1000.0, 10.0
PILLAR = Faces("free", "free", "free", "free", "fixed")
SCENES = {  # cells along each axis, points a cell, faces
    "one cell": ((1, 1, 1), 2, Faces()),
    "all held": ((1, 1, 1), 2, Faces(*["fixed"] * 6)),
    "on rollers": ((2, 2, 4), 2, Faces("free", "free", "free", "free", "roller")),
    "single row": ((1, 1, 4), (1, 1, 2), Faces()),
    "one point": ((1, 1, 1), 1, Faces()),
    "sparse": ((2, 2, 4), 1, PILLAR),
    "unheld": ((2, 2, 2), 2, Faces(*["free"] * 6)),
}


def settings(quick=False):
    return [(name,) for name in (("one cell", "unheld") if quick else SCENES)]


def solve(name, linear="krylov"):
    """Seen of a scene of SCENES."""
    cells, points, faces = SCENES[name]
    axes = [Axis(start=0.0, end=n * SIZE, size=SIZE) for n in (*cells[:2], cells[2] + 1)]
    height, material = cells[2] * SIZE, Material(law="hencky", young=1e6, poisson=0.0, density=DENSITY)
    simulation, _, told = watched(Scene(
        name="singular", grid=Grid(*axes, faces), gravity=(0.0, 0.0, -GRAVITY), time=Time(1.0, inertia=False),
        soil=Soil(material, geostatic=False, top=height, points_per_axis=points), solver=Solver(linear=linear),
        stages=(Stage("load", 2, gravity=(0.0, 1.0)),), output=Output(every=0, checkpoint=0)))
    stress = simulation.state.points.stress[:, 2, 2].mean() / (DENSITY * GRAVITY * height / 2)
    slip = abs((simulation.state.points.position - simulation.initial_position)[:, :2]).max() / height
    error = max(abs(stress + (name != "all held")), slip)
    return Seen(float(error), tuple(text for text in told if "points_per_axis" in text or "holds the soil" in text))
