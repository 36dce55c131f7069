"""A platen on an elastic cube, and a sphere pressed into an elastic block.

Platen, frictionless, ν = 0, cube of edge L and section A pressed to the height l:     F = A E ln(L/l) L/l
Hertz, sphere of radius R, ν = 0.3, depth δ:            F = 4/3 E / (1 - ν²) sqrt(R δ³), radius of contact sqrt(R δ)

with a the radius of contact. What is left of the deviation from Hertz's force, by halving each on its own: finite strains
1.5 % at a = 0.1 R and 3 % at 0.2 R; cells of a/4 1.5 %, of the order 2; a block 120 a wide and deep 0.7 %, of the order 1.
"""

import numpy as np

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.study.random.family import Family, spread, uniform

PUSHED = {"driven": ("z",), "held": ("x", "y", "rx", "ry", "rz")}


def draw_platen(generator):
    """Values of a platen."""
    return {"edge": spread(generator, 0.1, 10.0), "cells": int(generator.integers(1, 6)),
            "young": spread(generator, 1e4, 1e9), "squeeze": uniform(generator, 0.05, 0.3),
            "overhang": uniform(generator, 0.05, 0.4), "steps": int(generator.integers(5, 21))}


def platen(edge, cells, young, squeeze, overhang, steps):
    """Scene of a platen that squeezes a cube by a share `squeeze` of its edge; overhang: in edges, on each side."""
    axis, side = Axis(start=0.0, end=edge, size=edge / cells), (1 + 2 * overhang) * edge
    body = Body(GEOMETRY / "box.geo", 1000.0, name="platen", position=(0.5 * edge, 0.5 * edge, 0.0), rest_on=edge,
                parameters={"length": side, "width": side, "height": 0.5 * edge, "size": side},
                velocity=(0.0, 0.0, -squeeze * edge / steps), **PUSHED)
    return quasi_static("platen", Grid(axis, axis, axis, Faces()), Soil(elastic(young, 0.0), geostatic=False), body,
                        steps)


def measure_platen(run, edge, young, squeeze, **_):
    """{error: value} of a platen."""
    exact = edge**2 * young * np.log(1 / (1 - squeeze)) / (1 - squeeze)
    return {"force": run.records[-1].bodies[0].contact_force[2] / exact - 1}


def draw_hertz(generator):
    """Values of a sphere."""
    return {"radius": spread(generator, 0.1, 10.0), "young": spread(generator, 1e4, 1e9),
            "contact": uniform(generator, 0.1, 0.2), "facets": uniform(generator, 0.125, 0.25),
            "steps": int(generator.integers(1, 5))}


def hertz(radius, young, contact, facets, steps):
    """Scene of a sphere over a quarter of a block; contact: radius of contact in radii, facets: in radii of contact.

    Cells of a quarter of the radius of contact, up to twice that radius, where strains change fast; then growing by half.
    """
    patch = contact * radius
    span, fine, cell = 120 * patch, 2 * patch, patch / 4
    side = Axis(start=0.0, end=span, size=cell, fine=(0.0, fine), growth=1.5)
    down = Axis(start=-span, end=0.0, size=cell, fine=(-fine, 0.0), growth=1.5)
    body = Body(GEOMETRY / "sphere.geo", 1000.0, name="sphere", rest_on=0.0,
                parameters={"radius": radius, "size": facets * patch, "growth": 0.8},
                velocity=(0.0, 0.0, -contact**2 * radius / steps), **PUSHED)
    faces = Faces(z_min="fixed", x_max="free", y_max="free")
    return quasi_static("hertz", Grid(side, side, down, faces), Soil(elastic(young, 0.3), geostatic=False), body, steps)


def measure_hertz(run, radius, young, contact, **_):
    """{error: value} of a sphere."""
    exact = 4 / 3 * young / (1 - 0.3**2) * np.sqrt(radius * (contact**2 * radius) ** 3)
    return {"force": 4 * run.records[-1].bodies[0].contact_force[2] / exact - 1}


def elastic(young, poisson):
    """Elastic material."""
    return Material(law="hencky", young=young, poisson=poisson, density=1000.0)


def quasi_static(name, grid, soil, body, steps):
    """Scene without inertia and gravity, in steps of 1 s."""
    return Scene(name=name, grid=grid, soil=soil, bodies=(body,), time=Time(1.0, inertia=False),
                 stages=(Stage("press", steps),), gravity=(0.0, 0.0, 0.0))


FAMILIES = {
    "platen": Family("platen on a cube", {"force": 0.005}, draw_platen, lambda **values: [platen(**values)],
                     measure_platen, seeds=40),
    "hertz": Family("sphere pressed into a block", {"force": 0.06}, draw_hertz, lambda **values: [hertz(**values)],
                    measure_hertz, seeds=12, quick=1)}
