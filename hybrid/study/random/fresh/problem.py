"""What one problem consists of, and the few tables that all of them write alike."""

from collections.abc import Callable
from dataclasses import dataclass

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Material, Scene, Stage

PUSHED = {"driven": ("z",), "held": ("x", "y", "rx", "ry", "rz")}
WEIGHTLESS = (0.0, 0.0, 0.0)
G = 9.81


@dataclass(frozen=True)
class Problem:
    """title; the Scene; exact answer, from `low` to `high` (the same where it is one number); measure(Run): the answer
    found; allowed: largest deviation from that range [-], of `high`, or of 1 where it is 0."""

    title: str
    scene: Scene
    low: float
    high: float
    measure: Callable
    allowed: float


def body(file, values, **table):
    """Body of 1000 kg/m³ unless `table` has another density."""
    return Body(**{"geometry": GEOMETRY / file, "density": 1000.0, "parameters": values, "name": file[:-4]} | table)


def scene(name, grid, soil, bodies, time, steps, gravity=(0.0, 0.0, -G), **tables):
    """Scene of one stage."""
    return Scene(name=name, grid=grid, soil=soil, bodies=tuple(bodies), time=time, stages=(Stage("go", steps),),
                 gravity=gravity, **tables)


def clay(strength, density=1.0):
    """Undrained clay, E = 500 s_u."""
    return Material(law="von-mises", young=500 * strength, poisson=0.49, density=density, strength=strength)


def slice_(width=1.0):
    """The axis that plane strain leaves out."""
    return Axis(start=0.0, end=width, collapsed=True)


def force(axis, scale):
    """measure: size of the last contact force of the first body along an axis over `scale` [N]."""
    return lambda run: abs(run.records[-1].bodies[0].contact_force[axis]) / scale
