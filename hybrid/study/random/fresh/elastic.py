"""Elastic soil against closed forms."""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Material, Soil, Time
from hybrid.study.random.fresh.problem import PUSHED, WEIGHTLESS, G, Problem, body, force, scene, slice_


def oedometer(height=2.3, squeeze=0.12, young=8e6, poisson=0.3):
    """A platen on a column between smooth walls: A M ln(H/h) H/h, M the constrained modulus (Hencky's law)."""
    size = height / 9
    grid = Grid(Axis(start=0.0, end=2 * size, size=size), slice_(0.7), Axis(start=0.0, end=height + size, size=size),
                Faces(z_min="fixed"))
    platen = body("box.geo", {"length": 6 * size, "width": 0.7, "height": size, "size": 20.0},
                  position=(size, 0.35, 0.0), rest_on=height,
                  velocity=(0.0, 0.0, -squeeze * height / 10), **PUSHED)
    soil = Soil(Material(law="hencky", young=young, poisson=poisson, density=1700.0), top=height, geostatic=False)
    modulus = young * (1 - poisson) / (1 + poisson) / (1 - 2 * poisson)
    exact = modulus * np.log(1 / (1 - squeeze)) / (1 - squeeze)
    return Problem("platen on a column, stress over exact",
                   scene("oedometer", grid, soil, [platen], Time(1.0, inertia=False), 10, WEIGHTLESS),
                   1.0, 1.0, force(2, exact * 2 * size * 0.7), 0.01)


def hertz(radius=1.7, young=4e6, patch=0.15):
    """A quarter of a sphere on an elastic half space; cells of a third of the patch, a block 40 patches wide."""
    a = patch * radius
    side = Axis(start=0.0, end=40 * a, size=a / 3, fine=(0.0, 2 * a), growth=1.4)
    down = Axis(start=-40 * a, end=0.0, size=a / 3, fine=(-2 * a, 0.0), growth=1.4)
    grid = Grid(side, side, down, Faces(z_min="fixed", x_max="free", y_max="free"))
    probe = body("sphere.geo", {"radius": radius, "size": a / 5, "growth": 0.8}, rest_on=0.0,
                 velocity=(0.0, 0.0, -patch**2 * radius / 4), **PUSHED)
    soil = Soil(Material(law="hencky", young=young, poisson=0.3, density=1700.0), geostatic=False)
    exact = 4 / 3 * young / (1 - 0.3**2) * np.sqrt(radius * (patch**2 * radius) ** 3)
    return Problem("sphere on elastic soil, force over Hertz's",
                   scene("hertz", grid, soil, [probe], Time(1.0, inertia=False), 4, WEIGHTLESS),
                   1.0, 1.0, force(2, exact / 4), 0.09)


def heave(height=6.0, young=60e6):
    """A column whose weight acts at once: the surface swings to twice its static settlement, after 2 H / c."""
    size, density, steps = height / 24, 1900.0, 60
    grid = Grid(*(slice_(size),) * 2, Axis(start=0.0, end=height, size=size), Faces(z_min="fixed"))
    soil = Soil(Material(law="hencky", young=young, poisson=0.0, density=density), geostatic=False)
    time = 2 * height / np.sqrt(young / density)
    exact = density * G * height**2 / young

    def measure(run):
        first, last = run.simulation.initial_position, run.simulation.state.points
        top = np.argmax(first[:, 2])
        return float(first[top, 2] - last.position[top, 2])

    return Problem("column whose weight acts at once, greatest settlement [m]",
                   scene("heave", grid, soil, [], Time(time / steps), steps),
                   exact, exact, measure, 0.05)
