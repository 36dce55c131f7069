"""A smooth rigid strip footing on weightless soil in plane strain, pushed down until the soil flows: Prandtl's Nc.

          |  B/2 |
          |=====|________________   cohesion c, E = 10⁴ c; half a model, symmetric about x = 0
          |
          |______________________   Nc = F / (B c) = 5.14159, 14.8347, 30.1396 for φ = 0, 20°, 30°

Nc = (e^(π tanφ) tan²(45° + φ/2) - 1) cotφ, 2 + π for φ = 0, is that of Mohr-Coulomb's law; the cone matched in plane
strain with associated flow has the same (φ = 0: √J2 = c, von Mises). Contact acts at the corners of points' domains, s
apart; a footing whose edge is half way between two of them presses on exactly its own width. Soil that heaves beside it
just reaches into empty cells, which stops some runs unless a ghost penalty ties these to the others.
"""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hybrid.build import build
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time

BOX = Path(__file__).parents[1] / "geometry" / "box.geo"
COHESION, STIFFNESS, WIDTH = 1e3, 1e4, 2.0      # c [Pa], E/c, B [m]
CURES = {"F-bar": {"fbar": True}, "F-bar, ghost": {"fbar": True, "ghost": 0.0033}, "plain": {}}


def prandtl(angle):
    """Nc at a friction angle [degrees]."""
    tan = np.tan(np.radians(angle))
    return 2 + np.pi if angle == 0 else (np.exp(np.pi * tan) * np.tan(np.radians(45 + angle / 2)) ** 2 - 1) / tan


def material(angle):
    """Von Mises for φ = 0, else an associated cone; both matched in plane strain."""
    common = {"young": STIFFNESS * COHESION, "density": 1.0, "cone": "plane strain"}
    if angle == 0:
        return Material(law="von-mises", poisson=0.49, strength=COHESION, **common)
    return Material(law="drucker-prager", poisson=0.3, friction_angle=angle, dilation_angle=angle, cohesion=COHESION,
                    **common)


@dataclass(frozen=True)
class Press:
    """settlement / B and F / (B c) after each step; end of it all: positions, plastic strain of the points; unknowns;
    Newton iterations; seconds of the run."""

    settlement: np.ndarray
    factor: np.ndarray
    position: np.ndarray
    plastic: np.ndarray
    unknowns: int
    iterations: int
    seconds: float


def press(angle, across, depth=2.0, width=4.0, settlement=None, steps=20, law=None, body=(), faces=(), solver=(),
          **soil):
    """Press with `across` cells under half the footing in soil of `width` x `depth` footing widths, half a model.

    settlement: in widths; law: another Material; body, faces, solver, soil: more values of these tables.
    """
    size = 0.5 * WIDTH / (across + 0.25)
    settlement = settlement or 2.5 * prandtl(angle) / STIFFNESS
    columns, rows = (int(np.ceil(n * WIDTH / size)) for n in (width, depth))
    thickness = 0.5 * size      # points are cubes
    grid = Grid(Axis(nodes=tuple(size * np.arange(columns + 1))), Axis(start=0.0, end=thickness, collapsed=True),
                Axis(nodes=tuple(size * np.arange(-rows, 2))), Faces(**{"z_min": "fixed", **dict(faces)}))
    footing = Body(
        name="footing", geometry=BOX, density=1000.0,
        parameters={"length": WIDTH, "width": 3 * thickness, "height": 0.5 * WIDTH, "size": 10 * WIDTH},
        position=(0.0, 0.5 * thickness, 0.0), rest_on=0.0, driven=("z",), held=("x", "y", "rx", "ry", "rz"),
        velocity=(0.0, 0.0, -settlement * WIDTH / steps), **{"penalty": 100.0, **dict(body)})
    scene = Scene(
        name="footing", grid=grid, soil=Soil(law or material(angle), geostatic=False, top=0.0, **soil),
        bodies=(footing,), gravity=(0.0, 0.0, 0.0), time=Time(step=1.0, inertia=False), stages=(Stage("press", steps),),
        solver=Solver(**{"linear": "direct", "tolerance": 1e-5, "iterations": 25, **dict(solver)}),
        output=Output(every=0, checkpoint=0))
    simulation, begun, rows = build(scene), time.perf_counter(), []
    for record in simulation.steps():
        rows.append((record.bodies[0].contact_force[2], record.iterations))
    seconds = time.perf_counter() - begun
    force, iterations = np.array(rows).T
    points = simulation.state.points
    return Press(settlement * np.arange(1, steps + 1) / steps, force / (0.5 * WIDTH * thickness * COHESION),
                 points.position, points.plastic_strain, len(simulation.evaluation.soil),
                 int(iterations.sum()), seconds)
