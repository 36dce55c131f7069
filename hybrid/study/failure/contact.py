"""Failure modes of contact: its stiffness, its friction, and bodies finer than the points of the soil."""

from math import log

import numpy as np
from scipy.optimize import brentq

from hybrid.runtime.data import DEMOS
from hybrid.scene import Axis, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.scene.file import load_scene
from hybrid.study.failure.mode import Mode
from hybrid.study.failure.outcome import Observation
from hybrid.study.failure.simulate import messages, simulate
from hybrid.study.precision.problems import platen
from hybrid.study.precision.problems import sphere as rolling
from hybrid.study.scenes import NO_OUTPUT, box, driven, plane, soil_scene, sphere

GRAVITY = 9.81  # [m/s²]


def penalty(factor, **body):
    """Contact too soft: springs in series with the soil take a share of the displacement. Or too stiff for the solver.

    A rigid platen presses an elastic cube by a quarter (the problem `platen`). With the height l = 0.6 m + δ of the
    cube under a platen at 0.6 m,

        F = p_f E A δ = A E ln(L/l) L/l         ideal, δ = 0: 245.49 kN

    so the error is about 2.7 / p_f, p_f in 1/m; the contact takes 1 / (1 + p_f L) of the displacement. Left out, p_f
    follows from the cells, and the contact takes 1 / (1 + 500 L/h). Stiffness up to 1e11 /m loses no accuracy here;
    Newton's method only reaches round-off earlier. Its effect on impacts is shown in `bounce_map`.
    """
    pressed = platen.press(penalty=factor, steps=10, **body)
    return Observation(abs(pressed.force / platen.IDEAL - 1), messages(pressed.simulation, pressed.records))


LAYER, SIDE, YOUNG = 0.2, 0.8, 1e6      # [m], [m], [Pa]


def squeezed_layer(share, penalty=None, **body):
    """Hardly any soil left under a body: it overlaps the soil by more than a point's domain, and a second row of
    contact points comes into contact.

    A rigid platen presses a layer of one cell, two points high, against the base (quasi-static, ν = 0). With the height
    l = l_p + δ of the layer under a platen at l_p,

        F = p_f E A δ = A E ln(L/l) L/l

    As soon as the overlap δ exceeds the height l/2 of a domain, the faces between the two points are inside the platen
    too. Every row represents the whole area, so the pressure is counted twice; corners also at the base.
    """
    steps, low = 20, (1 - share) * LAYER
    axis, up = Axis(start=0.0, end=SIDE, size=LAYER), Axis(start=0.0, end=2 * LAYER, size=LAYER)
    pressing = driven(1.2, 1.2, 0.4, velocity=(0.0, 0.0, -share * LAYER / steps), position=(0.4, 0.4, 0.0),
                      rest_on=LAYER, penalty=penalty, **body)
    material = Material(law="hencky", young=YOUNG, poisson=0.0, density=1000.0)
    simulation, records, texts = simulate(Scene(
        name="squeezed", grid=Grid(axis, axis, up, Faces()), soil=Soil(material, top=LAYER, geostatic=False),
        bodies=(pressing,), time=Time(1.0, inertia=False), stages=(Stage("press", steps),), gravity=(0.0, 0.0, 0.0),
        output=NO_OUTPUT))
    exact = _series_force(low, simulation.model.bodies[0].penalty)
    return Observation(abs(records[-1].bodies[0].contact_force[2] / exact - 1), texts)


def _layer_force(height):
    """Force [N] on a layer pressed to a height [m]."""
    return SIDE**2 * YOUNG * log(LAYER / height) * LAYER / height


def _series_force(low, penalty):
    """Force [N] under a platen at `low` [m] with contact springs in series."""
    height = brentq(lambda h: penalty * YOUNG * SIDE**2 * (h - low) - _layer_force(h), low, LAYER, xtol=1e-14)
    return _layer_force(height)


def stick_threshold(ratio, tangential=1.0, parts=1):
    """Friction at the threshold of sliding: a regularised law creeps where it should stick.

    A block of 4 t, supported by 1 m² of a plane of tan θ = 0.5, is released after its weight is carried.

        a = max(0, g (sin θ - μ cos θ))         d = a t² / 2

    Friction that acts only after a displacement lets the block creep: a spring k = ε_T/ε_N p_f E A oscillates over 2 m
    g sin θ / k, which is 70 μm with p_f E = 5e8 Pa/m. At μ = tan θ exactly nothing stops a moving block, and it keeps the
    speed at which the spring breaks loose: g sin θ / ω, ω = √(k/m), or g sin θ Δt / 2 if a step is longer than that. The
    error is that of the displacement in 0.4 s, relative to that of a block without friction.
    """
    slope, step, steps = np.arctan(0.5), 0.01, 40
    block = box(4.0, 4.0, 0.25, rest_on=0.0, friction=ratio * np.tan(slope), held=("y", "rx", "ry", "rz"),
                tangential=tangential)
    gravity = GRAVITY * np.array([np.sin(slope), 0.0, -np.cos(slope)])
    simulation, _, texts = simulate(plane(
        block, parts * steps, step / parts, stiffness=1e7, settle=5, gravity=tuple(gravity),
        solver={"tolerance": 1e-8}))
    way, time = simulation.state.bodies[0].position[0], steps * step
    free, exact = 0.5 * gravity[0] * time**2, 0.5 * max(0.0, gravity[0] * (1 - ratio)) * time**2
    return Observation(abs(way - exact) / free, texts)


def tangential_stiffness(ratio, changes=()):
    """Tangential springs too soft: a rolling body creeps.

    A sphere rolls down a slope of 45° without slip (the problem `sphere`, μ = 1), on faces or on corners.

        d = 5/14 g t² sin θ        ω = 5/7 g sin θ t / r

    The spring ε_T of a sticking point is unstretched when contact closes and is released when it opens. The sphere
    therefore slides by a share of its way: a softer spring has to be stretched farther to carry the same friction.
    """
    changed = [*rolling.overrides(1.0), *changes, f"body.0.tangential={ratio}"]
    simulation, _, texts = simulate(load_scene(DEMOS / "rolling_sphere.toml", changed))
    start, end = simulation.initial_bodies[0], simulation.state.bodies[0]
    _, spin = rolling.missed(1.0, simulation.state.time, end.position[0] - start.position[0],
                             float((end.rotation @ end.spin)[1]))
    return Observation(abs(spin), texts)


# Spacing of corners [m]; step [s]; length of wall and edge [m]; penalty [1/m]; depth [m]
SPACING, STEP, LENGTH, PENALTY, SHALLOW = 0.1, 0.01, 0.3, 50.0, 0.002


def thin_wall(ratio, **body):
    """Bodies thinner than the spacing of corners: such a body can lie between the soil's corners and touch none.

    A wall 0.3 m long is driven edge-down, 4 mm deep, into held soil whose corners lie s = 0.1 m apart.

        F = p_f E t L d         of a wall of thickness t and length L, pressed down by d

    A row of corners under the edge carries s L p_f E d, and there are t/s rows of them, rounded up or down depending on
    the position of the wall: the larger error of two positions counts. Points on faces do the same s/4 apart, with as
    much less to each.
    """
    thickness = ratio * SPACING
    exact = PENALTY * YOUNG * thickness * 0.3 * 2 * SHALLOW
    return max((_pressed(driven(thickness, LENGTH, LENGTH, velocity=(0.0, 0.0, -SHALLOW / STEP), rest_on=0.0, size=0.05,
                                position=(0.4 + offset * SPACING, 0.4, 0.0), penalty=PENALTY, **body), 2, exact)
                for offset in (0.1, 0.4)), key=lambda o: o.error)      # from a row of corners, in spacings


def sharp_edge(ratio, contact="faces"):
    """Sharp edges between corners: an edge enters the soil freely until its flanks reach the corners on either side.

    A cube is driven on its edge into held soil, midway between two rows of corners s = 0.1 m apart.

        F = p_f E L d² cos 45° / 2          of an edge of 90° and length L, d deep; corners: without cos 45°

    because the overlap is that normal to the nearer flank, of which cos 45° acts upwards, and the pressure acts on the
    area projected on the flank; corners have their whole area. They carry nothing up to d = s/2, where the flanks reach
    them. Faces that are upright inside the ground, between domains, add a share of d/s.
    """
    depth, steps = ratio * SPACING, max(2, round(ratio * SPACING / 0.01))
    cube = driven(LENGTH, LENGTH, LENGTH, velocity=(0.0, 0.0, -depth / (steps * STEP)), position=(0.45, 0.4, 0.0),
                  rotation=(0.0, 1.0, 0.0, 45.0), rest_on=0.0, size=0.02, penalty=PENALTY, contact=contact)
    share = 1.0 if contact == "corners" else np.sqrt(0.5)
    return _pressed(cube, steps, PENALTY * YOUNG * LENGTH * depth**2 * share / 2)


def _pressed(body, steps, exact):
    """Observation of a body driven into held soil; exact: vertical force [N] at the end."""
    _, records, texts = simulate(soil_scene([body], held=True, steps=steps, young=YOUNG, time=Time(step=STEP)))
    return Observation(abs(records[-1].bodies[0].contact_force[2] / exact - 1), texts)


RADIUS = 0.25   # [m]
STIFFNESS = 4 / 3 * 1000.0 * GRAVITY / (0.1**2 * (1 - 0.1 / 3))     # p_f E [Pa/m] for d = r/10


def coarse_corners(ratio, **body):
    """Bodies smaller than the spacing of corners rest on single corners, or fall between them.

    A sphere is let down on a held plane, onto a corner or in the middle of four. Under its weight it sinks by d = r/10,

        p_f E π d² (r - d/3) = 4/3 π r³ ρ g

    if the plane is smooth; between four corners s apart its lowest point is up to r - √(r² - s²/2) deeper, and a sphere
    of r < s/√2 falls between them. The larger error of the two positions counts.
    """
    return max((_rest(ratio, offset, **body) for offset in (0.0, 0.5)), key=lambda o: o.error)


def _rest(ratio, offset, **body):
    """Observation of a sphere above a corner, moved by `offset` spacings along both axes."""
    spacing = RADIUS / ratio
    count = 2 * int(np.ceil(0.8 * ratio) + 1)
    ball = sphere(RADIUS, 0.06, position=(offset * spacing, offset * spacing, 0.0), rest_on=0.0, penalty=1.0,
                  held=("x", "y", "rx", "ry", "rz"), **body)
    simulation, _, texts = simulate(plane(
        ball, 25, 0.3 * np.sqrt(0.1 * RADIUS / GRAVITY), cell=2 * spacing, cells=(count, count), stiffness=STIFFNESS,
        gravity=(0.0, 0.0, -GRAVITY), time={"beta": 0.5625, "gamma": 1.0}))
    return Observation(abs(simulation.state.bodies[0].position[2] / RADIUS - 0.9), texts)


NARROW = r"spacings of contact points, limit 2:.*cells of at most|falls free at .* below the surface of the soil"
OPEN = r"inside the soil without contact.*body\.contact = .faces"
CORNERS = {"contact": "corners", "penalty": 50.0}
PLACES = {"corners (published)": {"contact": "corners"}, "faces": {}}

MODES = {
    "penalty": Mode(
        title="penalty too soft and too stiff", parameters=("penalty factor p_f [1/m]",),
        measure="error of the force", right=0.06, wrong=0.25,
        methods=PLACES, default="faces", message=r"penalty .* limit 10: contact takes .*Set body\.penalty",
        full=(1.0, 2.0, 5.0, 10.0, 50.0, 1e3, 1e5, 1e7, 1e9, 1e11), quick=(2.0, 50.0), solve=penalty),
    "squeezed_layer": Mode(
        title="hardly any soil left under a body", parameters=("share of a layer's height pressed away",),
        measure="error of the force", right=0.02, wrong=0.1,
        methods={"corners (published)": CORNERS, "faces, p_f = 50 /m": {"penalty": 50.0}, "faces": {}}, default="faces",
        message=r"penetrates the soil too far.* limit.*body\.penalty",
        full=(0.2, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99), quick=(0.9,), solve=squeezed_layer),
    "stick_threshold": Mode(
        title="friction at the threshold of sliding", parameters=("friction over slope, μ / tan θ",),
        measure="error of the way over that without friction", right=0.01, wrong=0.05,
        methods={"ε_T/ε_N = 1e-3": {"tangential": 1e-3}, "ε_T/ε_N = 1": {}, "Δt / 4": {"parts": 4}},
        default="ε_T/ε_N = 1", message=r"tangential .* limit 0.3.*body\.tangential",
        full=(0.5, 0.9, 0.99, 1.0, 1.01, 1.1, 1.5), quick=(1.0,), solve=stick_threshold),
    "tangential_stiffness": Mode(
        title="tangential springs too soft", parameters=("tangential over normal stiffness, ε_T / ε_N",),
        measure="error of the spin after 1 s", right=0.03, wrong=0.1,
        methods={"corners (published)": {"changes": rolling.corners()}, "faces": {}}, default="faces",
        message=r"tangential .* limit 0.3.*body\.tangential",
        full=(10.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.01, 0.001), quick=(0.01,), solve=tangential_stiffness),
    "thin_wall": Mode(
        title="walls thinner than the spacing of corners", parameters=("thickness over the spacing of corners, t / s",),
        measure="error of the force on the edge", right=0.05, wrong=0.25,
        methods=PLACES, default="faces", message=NARROW,
        full=(4.6, 3.4, 2.6, 1.5, 0.7, 0.3, 0.1, 0.05), quick=(4.6, 0.3), solve=thin_wall),
    "sharp_edge": Mode(
        title="sharp edges between corners", parameters=("depth of an edge over the spacing of corners, d / s",),
        measure="error of the force on the edge", right=0.1, wrong=0.25, methods=PLACES, default="faces", message=OPEN,
        full=(1.0, 0.8, 0.6, 0.5, 0.4, 0.3), quick=(1.0, 0.4), solve=sharp_edge),
    "coarse_corners": Mode(
        title="spheres smaller than the spacing of corners",
        parameters=("radius of a sphere over the spacing of corners, r / s",),
        measure="error of the height at rest over the radius", right=0.05, wrong=0.25, methods=PLACES,
        default="faces", message=f"{NARROW}|{OPEN}",
        full=(8.0, 4.0, 2.0, 1.5, 1.0, 0.8, 0.5, 0.25), quick=(2.0, 0.5), solve=coarse_corners),
}
