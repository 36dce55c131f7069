"""Small cuts: a corner of soil just reaches into a cell, and its nodes have next to no stiffness.

    z |        ____________    block of 2 m, plane strain, fixed below, ν = 0.3, leaning under gravity (0.3 g, -g)
      |       /          /     that is turned on in 5 quasi-static steps; its edges lie a share s in the cells
      |______/__________/__ x

A node whose functions reach a corner of length s h alone carries s⁴ of the mass and stiffness of a full one, in plane
strain: its displacement is anyone's guess, and Newton's method stalls on it. Where the block starts does not tell, for
it goes on through the cells as it leans: each setting takes three places, and the worst of them. The ghost penalty ties
such cells to their neighbours. Known: the mean displacement along x on a grid four times as fine (64 cells, 20 steps,
ghost = 0.0033), no more than 0.5 % from that of 32 cells.
"""

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.study.outcome import Seen

TITLE = "small cuts"
PARAMETERS = ("weight of a leaning block over its modulus, ρ g L / E",)
MEASURE, RIGHT, WRONG = "error of the displacement, worst of three places in the grid", 0.05, 0.25
METHODS = {"no penalty": {}, "ghost = 0.033": {"ghost": 0.033}}
DEFAULT = "no penalty"
SAYS = r"carries \S+ of the mass of a full one, limit .*set soil\.ghost"
LENGTH, DENSITY, GRAVITY, PLACES = 2.0, 1000.0, 10.0, (0.6, 0.45, 0.9)
EXACT = {0.01: 0.9092, 0.02: 0.9124, 0.05: 0.9237, 0.1: 0.9488, 0.2: 1.0389}     # mean displacement over the ratio [m]


def settings(quick=False):
    return [(ratio,) for ratio in ((0.02, 0.2) if quick else EXACT)]


def solve(ratio, **soil):
    """Seen of the block at all places."""
    return Seen(max(abs(lean(ratio, share, **soil) / EXACT[ratio] - 1) for share in PLACES))


def lean(ratio, share, cells=8, steps=5, solver=(), **soil):
    """Mean displacement [m] along x over the ratio, of a block moved by a share of a cell; raises StepError."""
    size = LENGTH / cells
    end = size * round(4.0 / size)
    material = Material(law="hencky", young=DENSITY * GRAVITY * LENGTH / ratio, poisson=0.3, density=DENSITY)
    scene = Scene(
        name="block", soil=Soil(material, geostatic=False, lower=(0.0, 0.0, 0.0), upper=(LENGTH, 1.0, LENGTH), **soil),
        grid=Grid(Axis(start=-size, end=end, size=size), Axis(start=0.0, end=1.0, collapsed=True),
                  Axis(start=0.0, end=LENGTH + size, size=size), Faces("free", "free", z_min="fixed")),
        gravity=(0.3 * GRAVITY, 0.0, -GRAVITY), time=Time(1.0, inertia=False), solver=Solver(**dict(solver)),
        stages=(Stage("load", steps, gravity=(0.0, 1.0)),), output=Output(every=0, checkpoint=0))
    simulation, start = moved(scene, share * size)
    for _ in simulation.steps():
        pass
    return float((simulation.state.points.position - start)[:, 0].mean()) / ratio


def moved(scene, way):
    """(Simulation whose soil starts `way` [m] farther along x, places (n, 3) where it starts)."""
    from hybrid.setup.build import build

    simulation = build(scene)
    simulation.state.points.position[:, 0] += way
    return simulation, simulation.state.points.position.copy()
