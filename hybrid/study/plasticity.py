"""Exact collapse loads of rigid, perfectly plastic clay, with nothing set but the physics.

    strip footing, smooth or rough, plane strain      F / (B s_u) = 2 + π = 5.142     (Prandtl)
    circular footing, smooth / rough                  F / (π R² s_u) = 5.69 / 6.05    (Cox, Eason & Hopkins)
    cylinder moved sideways, deep, smooth to rough    F / (D s_u) = 9.14 to 11.94     (Randolph & Houlsby)

Footings: weightless clay, E = 10⁴ s_u, ν = 0.49, pushed down in 20 quasi-static steps to 2.5 times the settlement that an
elastic soil of that stiffness would need for the collapse load. Models use their symmetry: a half of the strip, a
quarter of the circle. The clay has von Mises' law, as strong as Tresca's in plane strain. In axial symmetry it is at
most as strong as Tresca's (√J2 = s_u lies inside of the hexagon), so the exact load of the circle is 5.69 at most.

Between smooth and rough, with an adhesion α = sin Δ, the cylinder has π + 2Δ + 2 cosΔ + 4 (cos Δ/2 + sin Δ/2).

Cylinder: in place from the start, as in a user's scene (`hybrid.setup.in_place`). The clay at its axis bears 20 s_u, so
none opens.
"""

from dataclasses import dataclass

import numpy as np

from hybrid.bench.timed_steps import newton_iterations, sizes, timed_steps
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build

STRENGTH, STIFFNESS, POISSON, STEPS = 1e4, 1e4, 0.49, 20    # s_u [Pa], E / s_u
STRIP, SMOOTH, DEEP = 2 + np.pi, 5.69, 9.14


@dataclass(frozen=True)
class Pushed:
    """Result of a push: force over (area × s_u) after each step; unknowns; Newton iterations and halved increments;
    seconds; messages."""

    factor: np.ndarray
    unknowns: int
    iterations: int
    halvings: int
    seconds: float
    notes: tuple = ()


def clay(rigidity=STIFFNESS, density=1.0):
    """Undrained clay that is as strong as Tresca's in plane strain, √J2 = s_u; rigidity: E / s_u."""
    return Material(law="von-mises", young=rigidity * STRENGTH, poisson=POISSON, density=density, strength=STRENGTH,
                    cone="plane strain")


def graded(size, fine, end, growth=1.3):
    """Coordinates from 0 to `end` or a little farther: `size` apart up to `fine`, then growing."""
    found = (size * np.arange(np.ceil(fine / size - 1e-9) + 1)).tolist()
    while found[-1] < end:
        found.append(found[-1] + growth * (found[-1] - found[-2]))
    return found


def footing(shape, across, friction=0.0):
    """Scene of a footing of half-width or radius 1 m, with `across` cells in it; shape: "strip" or "circle"."""
    size, circle = 1.0 / across, shape == "circle"
    side = Axis(nodes=tuple(graded(size, 1.5, 5.0)))
    down = Axis(nodes=(*(-z for z in graded(size, 1.5, 4.0)[::-1]), size))
    depth = side if circle else Axis(start=0.0, end=0.5 * size, collapsed=True)
    file, parameters = ("cylinder.geo", {"radius": 1.0, "height": 0.5, "size": 0.25}) if circle else (
        "box.geo", {"length": 2.0, "width": size, "height": 0.5, "size": 0.5})
    settlement = 2.5 * (SMOOTH if circle else STRIP) / STIFFNESS * 2
    body = Body(GEOMETRY / file, 1000.0, name="footing", parameters=parameters, rest_on=0.0, friction=friction,
                position=(0.0, 0.0 if circle else 0.25 * size, 0.0), velocity=(0.0, 0.0, -settlement / STEPS),
                driven=("z",), held=("x", "y", "rx", "ry", "rz"))
    return Scene(name=f"{shape} footing", grid=Grid(side, depth, down, Faces(z_min="fixed")),
                 soil=Soil(clay(), top=0.0, geostatic=False),
                 bodies=(body,), gravity=(0.0, 0.0, 0.0), time=Time(1.0, inertia=False), stages=(Stage("push", STEPS),))


def push(shape, across, friction=0.0):
    """Pushed of a footing."""
    scene = footing(shape, across, friction)
    return pushed(scene, (0.0, 0.0, 1.0), np.pi / 4 if shape == "circle" else scene.grid.y.end)


def pushed(scene, direction, area):
    """Pushed of the body of a Scene; direction (3,): of the force; area [m²]: what it is over. Raises StepError if a step
    fails."""
    simulation = build(scene)
    records, seconds = timed_steps(simulation)
    force = np.array([record.bodies[0].contact_force for record in records]) @ direction
    return Pushed(force / (area * STRENGTH), sizes(simulation)["unknowns"], newton_iterations(records),
                  sum(record.rejections for record in records), sum(seconds),
                  tuple(dict.fromkeys(note for record in records for note in record.notes)))


# ------------------------------------------------------------------ cylinder moved sideways, deep in the clay

PRESSURE, COVER = 20.0, 5.0     # at the axis [s_u]; depth of the axis [diameters]


def deep_factor(adhesion):
    """Exact F / (D s_u) of a cylinder moved sideways deep in clay, with an adhesion α = sin Δ (Randolph & Houlsby 1984)."""
    turn = np.arcsin(adhesion)
    return np.pi + 2 * turn + 2 * np.cos(turn) + 4 * (np.cos(turn / 2) + np.sin(turn / 2))


def buried(across, friction=0.0, adhesion=None, way=0.1, rigidity=500.0, steps=40, around=6.0, fine=1.25):
    """Scene of a cylinder of 1 m diameter that lies in the soil with its axis at z = 0.

    across: cells in a diameter; rigidity: E / s_u; way [m], along x, in `steps`; around [m]: half-width of the soil.
    """
    size = 1.0 / across
    out = graded(size, fine, around)
    up = graded(size, fine, COVER)
    x = Axis(nodes=(*(-a for a in out[:0:-1]), *out))
    z = Axis(nodes=(*(-a for a in graded(size, fine, around)[:0:-1]), *up, up[-1] + (up[-1] - up[-2])))
    slice_ = Axis(start=0.0, end=0.5 * size, collapsed=True)
    density = PRESSURE * STRENGTH / (9.81 * up[-1])
    body = Body(GEOMETRY / "cylinder.geo", 1000.0, name="cylinder", rest_on=-0.5, rotation=(1.0, 0.0, 0.0, 90.0),
                parameters={"radius": 0.5, "height": 3 * size, "size": 0.05}, position=(0.0, 0.25 * size, 0.0),
                friction=friction, adhesion=adhesion, velocity=(way / steps, 0.0, 0.0), driven=("x",),
                held=("y", "z", "rx", "ry", "rz"))
    return Scene(name="buried", grid=Grid(x, slice_, z, Faces(z_min="fixed")),
                 soil=Soil(clay(rigidity, density), top=up[-1], k0=1.0), bodies=(body,), time=Time(1.0, inertia=False),
                 stages=(Stage("push", steps),))


def sideways(across, friction=0.0, adhesion=None, **values):
    """Pushed of the cylinder, force over (diameter × s_u)."""
    scene = buried(across, friction, adhesion, **values)
    return pushed(scene, (-1.0, 0.0, 0.0), scene.grid.y.end)
