"""Rides, pipes and plates beside the families of this study, each run with nothing set but the physics.

    .venv/bin/python demos/random/table.py              all rows
    .venv/bin/python demos/random/table.py pipe plate   some of them

A row is printed as soon as it is done; README.md beside this file has the results.
"""

import sys

import numpy as np

from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import HybridError
from hybrid.scene import Axis, Body, Faces, Grid, Scene, Soil, Stage, Time
from hybrid.study import plasticity
from hybrid.study.failure.simulate import simulate
from hybrid.study.random import clay, rides, runner, tumbling


def ride_errors(shape, cases):
    """Text of the ranges of the errors of rides, given their values."""
    records = [runner.run_problem(rides.FAMILIES[shape], {**values, "shape": shape}) for values in cases]
    done = [r for r in records if r.kind != "failed"]
    parts = [(name, [100 * r.errors[name] for r in done]) for name in rides.AIMS]
    return ", ".join(f"{name} {min(v):+.2f} to {max(v):+.2f} %" for name, v in parts if v) + (
        f", {len(records) - len(done)} of {len(records)} failed")


def starts(slope, frictions, number):
    """Values of rides from random starts in random directions, on ground of 10 MPa."""
    generator = np.random.default_rng(1)
    return [{**rides.draw(generator), "young": 1e7, "slope": slope, "mu": mu} for mu in frictions for _ in range(number)]


def sphere():
    """Sphere of 0.25 m on a slope of 30°, μ = 0.1 and 0.3, 8 starts each."""
    return ride_errors("sphere", starts(30.0, (0.1, 0.3), 8))


def nine():
    """Nine random rides of sphere and cylinder, 10 to 65°, μ 0 to 1, E = 10 MPa."""
    generator = np.random.default_rng(9)
    cases = [{**rides.draw(generator), "young": 1e7, "slope": generator.uniform(10.0, 65.0)} for _ in range(9)]
    return "sphere: " + ride_errors("sphere", cases[:5]) + "; cylinder: " + ride_errors("cylinder", cases[5:])


def cylinder():
    """Cylinder on a slope of 60°, μ = 0.1 to 1, 2 starts each."""
    return ride_errors("cylinder", starts(60.0, (0.1, 0.3, 0.6, 1.0), 2))


def pipe():
    """A pipe of 1 m diameter and 1 500 kg/m³, as long as its slice, set down on clay of 10 kPa."""
    sunk = []
    for length in (1.0, 0.5, 2.0):
        grid = Grid(Axis(-3.0, 3.0, 0.2), Axis(0.0, 0.5, collapsed=True), Axis(-2.0, 0.4, 0.2), Faces(z_min="fixed"))
        body = Body(GEOMETRY / "cylinder.geo", 1500.0, name="pipe", position=(0.07, 0.25, 0.0), rest_on=0.0,
                    rotation=(1.0, 0.0, 0.0, 90.0), parameters={"radius": 0.5, "height": 0.5 * length, "size": 0.1})
        simulation, _, _ = simulate(Scene(
            name="pipe", grid=grid, soil=Soil(clay.clay(10e3, 300.0), top=0.0), bodies=(body,), time=Time(0.02),
            stages=(Stage("set down", 50),)))
        sunk.append(simulation.initial_bodies[0].position[2] - simulation.state.bodies[0].position[2])
    return "sinks by " + ", ".join(f"{1e3 * depth:.2f}" for depth in sunk) + " mm, as long as, half and twice the slice"


def circle():
    """Smooth circular footing on clay, 3 cells in its radius."""
    found = plasticity.push("circle", 3)
    return f"finishes, F / (A s_u) = {found.factor[-1]:.2f} (5.69), {found.iterations} iterations in 20 steps"


def cone():
    """Cone of 60° into clay of rigidity E / s_u = 300, 2.5 cells in its radius."""
    values = {"radius": 0.1, "angle": 60.0, "strength": 1e4, "rigidity": 300.0, "across": 2.5}
    r = runner.run_problem(clay.FAMILIES["cone"], values)
    return r.reason or f"finishes, q/s_u = {r.errors['q/s_u']:.2f}, jitter {100 * r.errors['jitter']:.1f} %"


def collapse():
    """Block of 8 x 8 m, E = 1 MPa, yield stress 20 kPa (von Mises), cells of 1 m, 20 steps."""
    strength = 20e3 / np.sqrt(3)
    values = {"height": 8.0, "slender": 1.0, "cells": 8, "load": 1.8e4 * 8 / strength, "rigidity": 1e6 / strength,
              "poisson": 0.3}
    r = runner.run_problem(clay.FAMILIES["collapse"], values)
    return r.reason or f"finishes, {r.newton} iterations"


def plate():
    """A free plate that tumbles about its intermediate axis; error of the attitude after 20 rad."""
    values, errors = {"edges": [1.0, 0.6, 0.1], "spin": 1.0, "axis": [0.01, 1.0, 0.0]}, []
    for n in (1, 2, 4, 8):
        simulation, _, _ = simulate(tumbling.scene(scale=1.0, turn=0.08 / n, steps=250 * n, **values))
        errors.append(tumbling.off(simulation.state, **values))
    return "attitude off by " + ", ".join(f"{error:.1e}" for error in errors) + " rad at Δt, Δt/2, Δt/4, Δt/8"


ROWS = {row.__name__: row for row in (sphere, nine, cylinder, pipe, circle, cone, collapse, plate)}

if __name__ == "__main__":
    for name in sys.argv[1:] or ROWS:
        try:
            text = ROWS[name]()
        except HybridError as failure:
            text = f"failed: {failure}"
        print(f"{name}: {ROWS[name].__doc__}\n    {text}", flush=True)
