"""A free box that tumbles, without gravity and far from the soil, against Euler's equations.

It spins near its intermediate axis, which is unstable, by 0.003 to 0.05 rad a step. The error of the attitude is
of second order in the step: half the step has a quarter of the error.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.study.random.family import Family, spread, uniform


def draw(generator):
    """Values of a box."""
    axis = np.array([0.0, 1.0, 0.0]) + spread(generator, 1e-3, 1.0) * generator.normal(size=3)
    return {"edges": [uniform(generator, *limits, 3) for limits in ((0.7, 1.0), (0.4, 0.6), (0.1, 0.3))],
            "scale": spread(generator, 0.01, 10.0), "spin": spread(generator, 0.1, 100.0),
            "axis": [round(float(a), 4) for a in axis / np.linalg.norm(axis)],
            "turn": spread(generator, 0.003, 0.05), "steps": int(generator.integers(200, 401))}


def scene(edges, scale, spin, axis, turn, steps):
    """Scene of a box; scale [m]: of its edges; spin [rad/s], about `axis`; turn [rad]: in a step."""
    edges = scale * np.array(edges)
    cell = Axis(start=0.0, end=2.0 * scale, size=scale)
    body = Body(GEOMETRY / "box.geo", 1000.0, name="box", position=(scale, scale, 4 * scale),
                parameters={**dict(zip(("length", "width", "height"), edges.tolist())), "size": 0.5 * scale},
                spin=tuple((spin * np.array(axis)).tolist()))
    ground = Material(law="hencky", young=1e6, poisson=0.0, density=1000.0)
    return Scene(name="tumbling", grid=Grid(cell, cell, cell, Faces()), soil=Soil(ground, held=True, geostatic=False),
                 bodies=(body,), time=Time(step=turn / spin), stages=(Stage("turn", steps),), gravity=(0.0, 0.0, 0.0))


def exact(edges, spin, axis, time):
    """Rotation of the box after a time [s]."""
    a, b, c = np.square(edges)
    inertia = np.array([b + c, a + c, a + b])

    def rate(_, state):
        turned, w = Rotation.from_quat(state[:4]), state[4:]
        x, y, z, s = turned.as_quat()
        half = 0.5 * w
        q = np.array([s * half[0] + y * half[2] - z * half[1], s * half[1] + z * half[0] - x * half[2],
                      s * half[2] + x * half[1] - y * half[0], -x * half[0] - y * half[1] - z * half[2]])
        return [*q, *(-np.cross(w, inertia * w) / inertia)]

    start = [0.0, 0.0, 0.0, 1.0, *(spin * np.array(axis))]
    return Rotation.from_quat(solve_ivp(rate, (0.0, time), start, rtol=1e-11, atol=1e-12).y[:4, -1])


def off(state, edges, spin, axis):
    """Angle [rad] between the attitude of the box in a State and the exact one."""
    turned = Rotation.from_matrix(state.bodies[0].rotation)
    return (exact(edges, spin, axis, state.time).inv() * turned).magnitude()


def measure(*runs, edges, spin, axis, **_):
    """{error: value} of a box: attitude [rad], and what the observed order lacks of 2."""
    errors = [off(run.simulation.state, edges, spin, axis) for run in runs]
    return {"attitude": errors[0], "order": 2 - np.log2(errors[0] / errors[1])}


FAMILIES = {"tumbling": Family(
    "free box that tumbles", {"attitude": 0.05, "order": 0.2}, draw, lambda turn, steps, **values: [
        scene(turn=turn / n, steps=n * steps, **values) for n in (1, 2)], measure, seeds=20)}
