"""A cone of 60° pressed from the surface into clay or sand, with nothing set but the physics.

    deep, smooth    q / s_u = N (1.25 + I/2000) - 1.8 Δ,  N = 4/3 (1 + ln I),  I = G / s_u      (Teh & Houlsby 1991)
    deep, rough     2.2 more: + 2.4 on the face, - 0.2 on the shaft

9.7 for I = 100 and smooth. s_u is the strength of the law of von Mises in triaxial compression, as theirs; Δ = 0 without
weight. q is the force over the cross-section of the shaft. The model is a quarter; the radius is 1 m, the shaft is as
rough as the face. The force follows the position of the shoulder within a cell; `jitter` measures by how much.
"""

import numpy as np

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.study.plasticity import STRENGTH, graded, pushed

RIGIDITY, POISSON, ANGLE = 100.0, 0.49, 60.0    # G / s_u; opening of the cone [°]
PART = 0.1                                      # of a cell that a step pushes
GROWTH = 1.5                                    # of cells away from the cone
CLAY = Material(law="von-mises", young=2 * (1 + POISSON) * RIGIDITY * STRENGTH, poisson=POISSON, density=1.0,
                strength=STRENGTH, cone="compression")
SAND = Material(relative_density=38.0)


def scene(across, depth, material=CLAY, friction=0.0, around=10.0):
    """Scene of a cone with `across` cells in its radius whose tip is pushed to a `depth` [m]; around: [m] of soil beside and
    below it. Clay has no weight."""
    size, weightless = 1.0 / across, material is CLAY
    steps = round(depth / (PART * size))
    side = Axis(nodes=tuple(graded(size, 1.3, around, GROWTH)))
    down, up = graded(size, depth + 1.0, depth + around, GROWTH), size * np.arange(1, np.ceil(0.7 * across) + 1)
    body = Body(GEOMETRY / "cone.geo", 1000.0, name="cone", rest_on=0.0, friction=friction,
                parameters={"radius": 1.0, "angle": ANGLE, "shaft": depth, "size": 0.2},
                velocity=(0.0, 0.0, -depth / steps), driven=("z",), held=("x", "y", "rx", "ry", "rz"))
    return Scene(name="cone", grid=Grid(side, side, Axis(nodes=(*(-z for z in down[::-1]), *up)), Faces(z_min="fixed")),
                 soil=Soil(material, top=0.0, geostatic=not weightless), bodies=(body,), time=Time(1.0, inertia=False),
                 gravity=(0.0, 0.0, 0.0 if weightless else -9.81), stages=(Stage("push", steps),))


def push(across, depth, **values):
    """(depth [m] of the tip after each step, Pushed over the cross-section of the shaft) of a cone, to a `depth`; values:
    as in `scene`."""
    found = pushed(scene(across, depth, **values), (0.0, 0.0, 1.0), np.pi / 4)
    return depth * np.arange(1, len(found.factor) + 1) / len(found.factor), found


def jitter(depth, factor):
    """(root mean square, peak to peak) of what a quadratic in the depth leaves of the factor, over its mean [-]."""
    left = factor - np.polyval(np.polyfit(depth, factor, 2), depth)
    return left.std() / factor.mean(), np.ptp(left) / factor.mean()
