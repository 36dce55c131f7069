"""Bodies pushed and pulled through clay, against plasticity."""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Soil, Time
from hybrid.study.random.fresh.problem import PUSHED, WEIGHTLESS, G, Problem, body, clay, force, scene, slice_


def strip(half=3.1, strength=37e3, size=0.4):
    """Half a strip footing, which ends inside a cell."""
    grid = Grid(Axis(start=0.0, end=30 * size, size=size), slice_(), Axis(start=-24 * size, end=2 * size, size=size),
                Faces(z_min="fixed"))
    foot = body("box.geo", {"length": 2 * half, "width": 1.0, "height": half, "size": 20 * half},
                position=(0.0, 0.5, 0.0), rest_on=0.0,
                velocity=(0.0, 0.0, -0.02 * half / 20), **PUSHED)
    soil = Soil(clay(strength), top=0.0, geostatic=False)
    return Problem("strip footing", scene("strip", grid, soil, [foot], Time(1.0, inertia=False), 20, WEIGHTLESS),
                   2 + np.pi, 2 + np.pi,
                   force(2, half * strength), 0.09)


def circle(radius=0.35, strength=62e3):
    """A quarter of a rough circular footing, three cells in its radius."""
    size = radius / 3
    side = Axis(start=0.0, end=12 * size, size=size)
    grid = Grid(side, side, Axis(start=-9 * size, end=size, size=size), Faces(z_min="fixed"))
    foot = body("cylinder.geo", {"radius": radius, "height": radius, "size": radius / 4}, rest_on=0.0, adhesion=1.0,
                velocity=(0.0, 0.0, -0.04 * radius / 20), **PUSHED)
    soil = Soil(clay(strength), top=0.0, geostatic=False)
    return Problem("circular footing, smooth to rough",
                   scene("circle", grid, soil, [foot], Time(1.0, inertia=False), 20, WEIGHTLESS), 5.69, 6.05,
                   force(2, np.pi / 4 * radius**2 * strength), 0.05)


def deep_cylinder(diameter=0.4, strength=12e3, adhesion=0.0, factor=9.14):
    """A pipe in the clay from the start, five diameters deep, moved sideways by 0.15 diameters."""
    d, size = diameter, diameter / 8
    x = Axis(start=-6 * d, end=6 * d, size=size, fine=(-1.25 * d, 1.25 * d), growth=1.3)
    z = Axis(start=-5 * d, end=5 * d, size=size, fine=(-1.25 * d, 1.25 * d), growth=1.3)
    pipe = body("cylinder.geo", {"radius": d / 2, "height": d, "size": d / 16}, position=(0.0, 0.5 * d, 0.0),
                rotation=(1.0, 0.0, 0.0, 90.0),
                velocity=(0.15 * d / 20, 0.0, 0.0), driven=("x",), held=("y", "z", "rx", "ry", "rz"), adhesion=adhesion)
    density = 20 * strength / (G * 5 * d)
    soil = Soil(clay(strength, density))
    return Problem(f"pipe deep in clay, sideways, α = {adhesion:g}",
                   scene("deep", Grid(x, slice_(d), z, Faces(z_min="fixed")), soil, [pipe],
                   Time(1.0, inertia=False), 20), factor, factor, force(0, d * d * strength), 0.08)


def half_buried(diameter=0.6, strength=3e3):
    """A smooth pipe pushed half its diameter into weightless clay from the surface: 4.97 (w/D)^0.23 of one in place
    (Aubeny, Shi & Murff 2005) to 5.3 (w/D)^0.25 with the clay that heaves (Merifield, White & Randolph 2009)."""
    d, size = diameter, diameter / 8
    grid = Grid(Axis(start=0.0, end=3 * d, size=size), slice_(d), Axis(start=-3 * d, end=d, size=size), Faces(z_min="fixed"))
    pipe = body("cylinder.geo", {"radius": d / 2, "height": d, "size": d / 16}, position=(0.0, 0.5 * d, 0.0),
                rotation=(1.0, 0.0, 0.0, 90.0),
                rest_on=0.0, velocity=(0.0, 0.0, -0.5 * d / 40), **PUSHED)
    low, high = 4.97 * 0.5**0.23, 5.3 * 0.5**0.25
    return Problem("pipe pushed half in", scene("laid", grid, Soil(clay(strength), top=0.0, geostatic=False), [pipe],
                   Time(1.0, inertia=False), 40, WEIGHTLESS), low, high, force(2, 0.5 * d * d * strength), 0.1)


def plate_anchor(width=1.2, strength=9e3, across=12, thickness=1 / 3):
    """A strip plate deep in clay that stays attached, pulled up: 11.42 of a thin plate; thickness: in widths."""
    b, size = width, width / across
    grid = Grid(Axis(start=0.0, end=5 * b, size=size, fine=(0.0, b), growth=1.3), slice_(b),
                Axis(start=-5 * b, end=5 * b, size=size, fine=(-b, b), growth=1.3), Faces(z_min="fixed"))
    plate = body("box.geo", {"length": b, "width": b, "height": thickness * b, "size": 10 * b},
                 position=(0.0, 0.5 * b, 0.0), tension="full",
                 velocity=(0.0, 0.0, 0.1 * b / 20), **PUSHED)
    soil = Soil(clay(strength, 1700.0))

    def measure(run):
        weight = 1700.0 * G * b**3 * thickness / 2        # of the clay that the plate replaces, half of it
        return abs(-run.records[-1].bodies[0].contact_force[2] + weight) / (0.5 * b * b * strength)

    return Problem("plate anchor, deep, attached", scene("plate", grid, soil, [plate], Time(1.0, inertia=False), 20),
                   11.42, 11.42, measure, 0.15)


def ball(diameter=0.113, strength=15e3):
    """A quarter of a smooth ball in the clay from the start, three diameters deep, pushed down: 11 to 13."""
    d, size = diameter, diameter / 6
    side = Axis(start=0.0, end=2.5 * d, size=size, fine=(0.0, 0.7 * d), growth=1.4)
    z = Axis(start=-2.5 * d, end=3.0 * d, size=size, fine=(-0.9 * d, 0.7 * d), growth=1.4)
    probe = body("sphere.geo", {"radius": d / 2, "size": d / 12}, velocity=(0.0, 0.0, -0.2 * d / 16), **PUSHED)
    soil = Soil(clay(strength, 20 * strength / (G * 3 * d)))

    def measure(run):
        forces = [record.bodies[0].contact_force[2] for record in run.records]
        buoyancy = 20 * strength / (3 * d) * np.pi / 24 * d**3
        return (forces[-1] - buoyancy) / (np.pi / 16 * d**2 * strength)

    return Problem("ball penetrometer, deep, smooth", scene("ball", Grid(side, side, z, Faces(z_min="fixed")), soil, [probe],
                   Time(1.0, inertia=False), 16), 11.0, 13.0, measure, 0.1)

def square(half=0.9, strength=28e3, across=3):
    """A quarter of a rough square footing: finite elements have 5.95 (Gourvenec, Randolph & Kingsnorth 2006), bounds are
    5.52 and 6.22 (Salgado, Lyamin, Sloan & Yu 2004)."""
    size = half / across
    side = Axis(start=0.0, end=4 * half, size=size)
    grid = Grid(side, side, Axis(start=-3 * half, end=size, size=size), Faces(z_min="fixed"))
    foot = body("box.geo", {"length": 2 * half, "width": 2 * half, "height": half, "size": half / 2}, rest_on=0.0,
                adhesion=1.0,
                velocity=(0.0, 0.0, -0.04 * half / 16), **PUSHED)
    soil = Soil(clay(strength), top=0.0, geostatic=False)
    return Problem("square footing, rough",
                   scene("square", grid, soil, [foot], Time(1.0, inertia=False), 16, WEIGHTLESS), 5.52, 6.22,
                   force(2, half**2 * strength), 0.05)


def pin(diameter=0.8, strength=25e3):
    """A pile in plan: a horizontal slice of weightless clay that sticks to it, half of it, moved sideways: 11.94
    (Randolph & Houlsby 1984)."""
    d, size = diameter, diameter / 8
    x = Axis(start=-6 * d, end=6 * d, size=size, fine=(-1.25 * d, 1.25 * d), growth=1.3)
    y = Axis(start=0.0, end=6 * d, size=size, fine=(0.0, 1.25 * d), growth=1.3)
    pile = body("cylinder.geo", {"radius": d / 2, "height": d, "size": d / 16}, velocity=(0.1 * d / 20, 0.0, 0.0),
                adhesion=1.0, tension="full",
                driven=("x",), held=("y", "z", "rx", "ry", "rz"))
    soil = Soil(clay(strength), geostatic=False)
    return Problem("pile in plan, sideways, clay sticks",
                   scene("pin", Grid(x, y, slice_(d)), soil, [pile], Time(1.0, inertia=False), 20,
                   WEIGHTLESS), 11.94, 11.94, force(0, 0.5 * d * d * strength), 0.08)


def lands(width=1.0, speed=3.0, strength=40e3, steps=100):
    """A steel strip footing, as high as wide, that hits weightless clay: (energy of motion)/(load - weight), load 5.14
    s_u per width, and 20 % more at a depth of half the width (Skempton 1951); as wide a range as the clay moved with it
    and its elastic strain leave."""
    size, step = width / 10, 0.002
    grid = Grid(Axis(start=-3 * width, end=3 * width, size=size), slice_(), Axis(start=-3 * width, end=width, size=size),
                Faces(z_min="fixed"))
    foot = body("box.geo", {"length": width, "width": 1.0, "height": width, "size": 20 * width},
                position=(0.0, 0.5, 0.0), rest_on=0.0,
                density=7850.0, velocity=(0.0, 0.0, -speed))
    soil = Soil(clay(strength, 1700.0), top=0.0)
    weight, energy = 7850.0 * width**2 * G, 0.5 * 7850.0 * width**2 * speed**2
    low, high = (energy / (factor * strength * width - weight) for factor in (1.15 * (2 + np.pi), 2 + np.pi))

    def measure(run):
        return -min(float(record.bodies[0].position[2])
                    for record in run.records) + float(run.simulation.initial_bodies[0].position[2])

    return Problem("steel block lands on clay at 3 m/s, depth [m]",
                   scene("lands", grid, soil, [foot], Time(step), steps), low, high, measure, 0.1)


def lies(density, exact, strength=6e3, width=1.5):
    """A light strip laid on clay of 1500 kg/m³: what it weighs is what carries it, after a second."""
    size, step = width / 10, 0.02
    grid = Grid(Axis(start=-3 * width, end=3 * width, size=size), slice_(),
                Axis(start=-2 * width, end=width / 2, size=size), Faces(z_min="fixed"))
    strip_ = body("box.geo", {"length": width, "width": 1.0, "height": width / 3, "size": 20 * width},
                  position=(0.0, 0.5, 0.0), rest_on=0.0,
                  density=density)
    soil = Soil(clay(strength, 1500.0), top=0.0)
    return Problem(f"block of {density:g} kg/m³ laid on clay, force over weight",
                   scene("lies", grid, soil, [strip_], Time(step), 50), exact, exact,
                   force(2, density * G * width**2 / 3), 0.05)


def buoyant(diameter=0.5, strength=4e3):
    """A pipe held in clay, three diameters deep: it is pushed up by the weight of the clay that it replaces."""
    d, size = diameter, diameter / 8
    grid = Grid(Axis(start=-4 * d, end=4 * d, size=size), slice_(d), Axis(start=-6 * d, end=0.0, size=size),
                Faces(z_min="fixed"))
    pipe = body("cylinder.geo", {"radius": d / 2, "height": d, "size": d / 16}, position=(0.0, 0.5 * d, -3 * d),
                rotation=(1.0, 0.0, 0.0, 90.0),
                held=("x", "y", "z", "rx", "ry", "rz"))
    soil = Soil(clay(strength, 1600.0), top=0.0)
    return Problem("pipe held deep in clay, buoyancy over exact",
                   scene("buoyant", grid, soil, [pipe], Time(1.0, inertia=False), 3), 1.0, 1.0,
                   force(2, 1600.0 * G * np.pi / 4 * d**3), 0.05)


def floats(density=300.0, strength=4e3, diameter=0.5):
    """The same pipe let go: (1600 - 300) g π d²/4 is a quarter of 9.14 s_u d, so it stays; way over its diameter."""
    problem = buoyant(diameter, strength)
    pipe = body("cylinder.geo", {"radius": diameter / 2, "height": diameter, "size": diameter / 16}, density=density,
                position=(0.0, 0.5 * diameter, -3 * diameter), rotation=(1.0, 0.0, 0.0, 90.0))
    one = problem.scene

    def measure(run):
        return float(run.simulation.state.bodies[0].position[2] - run.simulation.initial_bodies[0].position[2]) / diameter

    return Problem("light pipe let go deep in clay, way over its diameter",
                   scene("floats", one.grid, one.soil, [pipe], Time(0.02), 50), 0.0, 0.0,
                   measure, 0.01)
