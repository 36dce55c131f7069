"""Bodies on held ground and on a hinge, against rigid-body dynamics."""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Joint, Material, Soil, Time
from hybrid.study.random.fresh.problem import G, Problem, body, scene


def ride(shape, slope, mu, heading, radius, cell, steps=60, step=0.01, start=(0.13, 0.07)):
    """Distance from rest on a slope, gravity turned; shape: "sphere", "cylinder" or "block"."""
    turn = np.radians(heading)
    along = np.array([np.cos(turn), np.sin(turn)])
    down, across = G * np.sin(np.radians(slope)), G * np.cos(np.radians(slope))
    k = {"sphere": 0.4, "cylinder": 0.5, "block": np.inf}[shape]
    slides = down > (1 + 1 / k) * mu * across
    rate = down - mu * across if slides else 0.0 if shape == "block" else down / (1 + k)
    exact = 0.5 * rate * (steps * step) ** 2
    ends = np.array([start, np.array(start) + exact * along])
    low, high = np.floor((ends.min(0) - 3 * radius) / cell) * cell, np.ceil((ends.max(0) + 3 * radius) / cell) * cell
    grid = Grid(*(Axis(start=float(a), end=float(b), size=cell) for a, b in zip(low, high)),
                Axis(start=-cell, end=0.0, size=cell))
    sizes = {"sphere": {"radius": radius, "size": radius / 5},
             "cylinder": {"radius": radius, "height": 1.5 * radius, "size": radius / 5},
             "block": {"length": 2 * radius, "width": 2 * radius, "height": radius, "size": 9.0}}[shape]
    file = {"sphere": "sphere.geo", "cylinder": "cylinder.geo", "block": "box.geo"}[shape]
    rotation = {"sphere": None, "cylinder": (*along, 0.0, 90.0), "block": (0.0, 0.0, 1.0, heading)}[shape]
    rider = body(file, sizes, density=2600.0, position=(*start, 0.0), rest_on=0.0, friction=mu,
                 rotation=None if rotation is None else tuple(map(float, rotation)))
    soil = Soil(Material(law="hencky", young=3e7, poisson=0.0, density=1800.0), held=True, geostatic=False)
    what = "slides" if slides else "sticks" if shape == "block" else "rolls"

    def measure(run):
        return float((run.simulation.state.bodies[0].position - run.simulation.initial_bodies[0].position)[:2] @ along)

    return Problem(f"{shape} on {slope}°, μ = {mu:g}, heading {heading}°, {what} [m]",
                   scene("ride", grid, soil, [rider], Time(step), steps,
                   (*(down * along), -across)), exact, exact, measure, 0.005 if exact else 1e-3)


def on_bank(shape, slope, mu, material, size=0.7, cell=0.25, steps=40, step=0.02):
    """Distance from rest down a bank that deforms, in plane strain; shape: "block" or "cylinder"."""
    turn, width, long, top = np.radians(slope), 0.5, 9.0, 4.0
    down, across = G * np.sin(turn), G * np.cos(turn)
    rate = down - mu * across if shape == "block" else down / 1.5
    file, sizes = {"block": ("box.geo", {"length": 2 * size, "width": width, "height": 0.6 * size, "size": 9.0}),
                   "cylinder": ("cylinder.geo", {"radius": size, "height": width, "size": size / 8})}[shape]
    rotation = {"block": (0.0, 1.0, 0.0, slope), "cylinder": (1.0, 0.0, 0.0, 90.0)}[shape]
    rider = body(file, sizes, density=2100.0, position=(2.63, 0.5 * width, 0.0), rotation=rotation, rest_on="ground",
                 friction=mu)
    end = top - (long - 1.5) * np.tan(turn)
    grid = Grid(Axis(start=0.0, end=long, size=cell), Axis(start=0.0, end=width, collapsed=True),
                Axis(start=0.0, end=6.5, size=cell), Faces(z_min="fixed"))
    soil = Soil(material, top=top, ground=((0.0, top), (1.5, top), (long, float(end))))
    exact = 0.5 * rate * (steps * step) ** 2

    def measure(run):
        return float(np.linalg.norm(run.simulation.state.bodies[0].position - run.simulation.initial_bodies[0].position))

    return Problem(f"{shape} on a bank of {slope}° that deforms ({material.law or 'sand'}), μ = {mu:g} [m]",
                   scene("bank", grid, soil, [rider], Time(step), steps), exact, exact, measure, 0.05)


def bounce(step=0.31, part=0.37):
    """Speed with which a box leaves held ground, in steps of `step` [s], longer than the contact, over that with which it
    came: at most 1; part: of a step until it arrives."""
    box_ = body("box.geo", {"length": 1.0, "width": 1.0, "height": 0.4, "size": 20.0}, density=1200.0,
                position=(0.0, 0.0, 0.0), rest_on=part * 2.0 * step, velocity=(0.0, 0.0, -2.0))
    side = Axis(start=-0.75, end=0.75, size=0.5)
    soil = Soil(Material(law="hencky", young=2e6, poisson=0.0, density=1800.0), held=True, geostatic=False)
    grid = Grid(side, side, Axis(start=-0.5, end=0.0, size=0.5))
    return Problem("box bounces off held ground in steps longer than the contact, speed after over before",
                   scene("bounce", grid, soil, [box_], Time(step), 12, (0.0, 0.0, 0.0)), 0.5, 1.0,
                   lambda run: float(run.simulation.state.bodies[0].velocity[2]) / 2.0, 0.01)


def pendulum(release=140.0):
    """A bar on a hinge, let go from 140 degrees: energy at the lowest place gives its spin, sqrt(2 m g l (1 - cos) / I)."""
    length, step, steps = 0.9, 0.0025, 640
    bar = body("box.geo", {"length": length, "width": 0.07, "height": 0.05, "size": 20.0}, density=7850.0,
               position=(0.0, 0.0, 2.0),
               rotation=(0.0, 1.0, 0.0, 90.0 - release), friction=0.0)
    pin = Joint("pin", "hinge", ("box",), point=(-length / 2, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    grid = Grid(*(Axis(start=-0.6, end=0.6, size=0.3),) * 2, Axis(start=-0.3, end=0.0, size=0.3))
    soil = Soil(Material(law="hencky", young=1e6, poisson=0.0, density=1800.0), held=True, geostatic=False)
    inertia = length**2 / 12 + 0.05**2 / 12 + length**2 / 4
    exact = np.sqrt(G * length * (1 - np.cos(np.radians(release))) / inertia)

    def measure(run):
        return max(float(np.linalg.norm(record.bodies[0].spin)) for record in run.records)

    return Problem("bar on a hinge from 140°, greatest spin [1/s]",
                   scene("pendulum", grid, soil, [bar], Time(step), steps, joints=(pin,)),
                   exact, exact, measure, 0.005)
