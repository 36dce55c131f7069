"""Locking: linear cells cannot bend without changing their volume, so soil that keeps its volume will not bend.

    wall |==========   beam of 4 x 1 m under its weight, plane strain, small strains, 4 cells through its height;
         |             Poisson's ratio ν goes to 1/2

In plane strain a cell's linear functions have one mode of constant volume less than a cell has constraints, so without
a cure the sag goes to 0 as K/G = 2(1 + ν)/3(1 - 2ν) grows. F-bar takes the volume change from the mean of the cell.
Known: the mean sag with F-bar on 32 cells through the height, SAG times that of Timoshenko's beam,

    q/E (L⁴ (1 - ν²)/20 I + 4/5 (1 + ν) L²/H),    16 cells give the same to 0.1 %

which falls short by what the wall does to a beam that would thicken and thin there.
"""

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen

TITLE = "locking of a beam"
PARAMETERS = ("Poisson's ratio",)
MEASURE, RIGHT, WRONG = "error of the mean sag", 0.05, 0.25
METHODS = {"no F-bar": {}, "F-bar": {"fbar": True}}
DEFAULT = "no F-bar"
SAYS = r"poisson = \S+: .*limit 0\.45.*soil\.fbar"
LENGTH, YOUNG, WEIGHT = 4.0, 1e6, 9.81
SAG = {0.3: 0.9864, 0.4: 0.9713, 0.45: 0.9593, 0.47: 0.9534, 0.49: 0.9466, 0.499: 0.9432, 0.4999: 0.9429}


def settings(quick=False):
    return [(nu,) for nu in ((0.3, 0.4999) if quick else SAG)]


def solve(poisson, cells=4, **soil):
    """Seen of a beam of `cells` through its height."""
    sag, told = sagging(poisson, cells, **soil)
    return Seen(abs(sag / (SAG[poisson] * timoshenko(poisson)) - 1), tuple(t for t in told if "soil.fbar" in t))


def timoshenko(poisson):
    """Mean sag [m] of a beam that bends and shears."""
    bending, shear = LENGTH**4 * 12 / 20 * (1 - poisson**2), 0.8 * (1 + poisson) * LENGTH**2
    return WEIGHT / YOUNG * (bending + shear)


def sagging(poisson, cells, **soil):
    """Mean sag [m], and what the run told."""
    size = 1.0 / cells
    material = Material(law="hencky", young=YOUNG, poisson=poisson, density=1.0)
    simulation, _, told = watched(Scene(
        name="beam", soil=Soil(material, lower=(0.0, 0.0, 0.0), upper=(LENGTH, size, 1.0), geostatic=False, **soil),
        grid=Grid(Axis(start=0.0, end=LENGTH + 1.0, size=size), Axis(start=0.0, end=size, collapsed=True),
                  Axis(start=-1.0, end=2.0, size=size), Faces("fixed", "free", z_min="free")),
        gravity=(0.0, 0.0, -WEIGHT), time=Time(1.0, inertia=False), stages=(Stage("load", 1),),
        solver=Solver(linear="direct"), output=Output(every=0, checkpoint=0)))
    return 0.5 - float(simulation.state.points.position[:, 2].mean()), told
