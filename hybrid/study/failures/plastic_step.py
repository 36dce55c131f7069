"""Load steps too long for plastic flow: not found, or found and wrong.

    z |_______        bank of clay, 2 x 2 m, on a rough floor, smooth wall at its left, E = 100 s_u; its weight
      |       |       ρ g L = 5 s_u is turned on in 1 to 50 quasi-static steps. Its edge sinks by 0.1 m and its
      |_______|__ x   foot comes 0.13 m out; steeper and higher than 3.8 s_u it stands by its shape and by locking

A return mapping follows the direction of flow at the end of an increment, and points keep the basis of its begin.
Newton's method may find no state at all, which halving the increment cures; or one that is converged and 31 % short,
which no residual tells. The largest growth of a point's plastic strain in an increment does. Known: the mean
displacement along x in 100 steps, within 1 % of that in 5 to 50 (with the same cells, which lock).
"""

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen

TITLE = "load steps and plastic flow"
PARAMETERS = ("steps in which a bank's weight comes",)
MEASURE, RIGHT, WRONG = "error of the displacement", 0.05, 0.25
METHODS = {"increments as given": {"smallest": 1.0}, "halved if need be": {}, "ten increments a step": {"share": 10}}
DEFAULT = "halved if need be"
SAYS = r"plastic strain of a point, limit .*stage\.steps|smaller time\.step"
LENGTH, CELLS, DENSITY, GRAVITY, RATIO, EXACT = 2.0, 8, 1800.0, 10.0, 5.0, 0.0403


def settings(quick=False):
    return [(steps,) for steps in ((5, 1) if quick else (50, 20, 10, 5, 2, 1))]


def solve(steps, share=1, smallest=None):
    """Seen of a bank loaded in `share` times `steps` steps."""
    size, strength = LENGTH / CELLS, DENSITY * GRAVITY * LENGTH / RATIO
    clay = Material(law="von-mises", young=100 * strength, poisson=0.45, density=DENSITY, strength=strength,
                    cone="plane strain")
    simulation, _, told = watched(Scene(
        name="bank", soil=Soil(clay, geostatic=False, lower=(0.0, 0.0, 0.0), upper=(LENGTH, 1.0, LENGTH)),
        grid=Grid(Axis(start=0.0, end=2 * LENGTH, size=size), Axis(start=0.0, end=1.0, collapsed=True),
                  Axis(start=0.0, end=LENGTH + size, size=size), Faces("roller", "free", z_min="fixed")),
        gravity=(0.0, 0.0, -GRAVITY), time=Time(1.0, inertia=False, smallest=smallest),
        stages=(Stage("load", share * steps, gravity=(0.0, 1.0)),), output=Output(every=0, checkpoint=0)))
    found = (simulation.state.points.position - simulation.initial_position)[:, 0].mean()
    return Seen(float(abs(found / EXACT - 1)), tuple(t for t in told if "plastic strain" in t))
