"""What is lost between points and grid? Two ways to take up the motion of the nodes, three blocks of soil in flight.

A block of 1 m in plane strain, ρ = 1000 kg/m³, E = 1 MPa, ν = 0, cells of 0.1 m, 4 points a cell (400 points), no
gravity. Newmark (1/4, 1/2) damps nothing, so whatever energy goes is lost in the transfer:

    free       flies at 2 m/s through 13 cells while it swings along its length: energy of the swing after 10 periods
    rotating   turns once in 2 s: angular momentum and energy after one turn
    bouncing   hits a rigid wall at 1 m/s: energy of all that moves and is strained after it came off

    .venv/bin/python demos/transfers.py          a minute
"""

from pathlib import Path

import numpy as np

from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build

TRANSFERS = ("increments", "affine")
BOX = Path(__file__).parents[1] / "geometry" / "box.geo"
SIZE, DENSITY, YOUNG = 0.1, 1000.0, 1e6
FREE = Faces(*["free"] * 6)


def block(transfer, length, step, steps, left=0.3, bodies=(), **time):
    """A block from x = `left` to left + 1 m in a grid of `length` [m]."""
    axis = Axis(start=0.0, end=1.6, size=SIZE)
    return build(Scene(
        name="transfers", grid=Grid(Axis(start=0.0, end=length, size=SIZE), Axis(start=0.0, end=1.0, collapsed=True),
                                    axis, FREE),
        soil=Soil(Material(law="hencky", young=YOUNG, poisson=0.0, density=DENSITY), lower=(left, 0.0, 0.3),
                  upper=(left + 1.0, 1.0, 1.3), geostatic=False, transfer=transfer),
        gravity=(0.0, 0.0, 0.0), bodies=tuple(bodies), time=Time(step=step, **{"scheme": "newmark", **time}),
        stages=(Stage("fly", steps),),
        solver=Solver(tolerance=1e-10, linear="direct"), output=Output(every=0, checkpoint=0)))


def energy(record):
    return record.energies["kinetic"] + record.energies["elastic"] + record.energies["contact"]


def free(transfer, steps=320, **time):
    """Share of the energy of the swing that is left after `steps` of 2 ms; the translation's is left out."""
    simulation = block(transfer, 3.2, 0.002, steps, **time)
    points, mass = simulation.state.points, simulation.model.soil.constants.mass
    points.velocity[:, 0] = 0.5 * np.sin(np.pi * (points.position[:, 0] - 0.8))
    start = 0.5 * mass @ points.velocity[:, 0] ** 2
    points.velocity[:, 0] += 2.0
    if transfer == "affine":
        points.affine = np.zeros((len(points), 1, 3, 3))
        points.affine[:, 0, 0, 0] = 0.5 * np.pi * np.cos(np.pi * (points.position[:, 0] - 0.8))
    for record in simulation.steps():
        pass
    return (energy(record) - 0.5 * mass.sum() * 2.0**2) / start


def rotating(transfer, steps=200, turns=1.0, **time):
    """Shares of angular momentum and of energy left after `turns` at one in 2 s."""
    simulation = block(transfer, 1.6, 2.0 * turns / steps, steps, **time)
    points, mass = simulation.state.points, simulation.model.soil.constants.mass
    arm, rate = points.position - np.array([0.8, 0.5, 0.8]), np.pi
    points.velocity[:] = rate * np.cross([0.0, 1.0, 0.0], arm)
    if transfer == "affine":
        turn = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
        points.affine = np.tile(rate * turn, (len(points), 1, 1, 1))
    points.acceleration[:] = -rate**2 * arm * [1.0, 0.0, 1.0]

    def spin(points):
        return mass @ np.cross(points.position - mass @ points.position / mass.sum(), points.velocity)[:, 1]

    first, start = spin(points), 0.5 * mass @ np.sum(points.velocity**2, axis=1)
    for record in simulation.steps():
        pass
    return spin(simulation.state.points) / first, energy(record) / start


def bouncing(transfer, steps=150, **time):
    """Share of the energy left after the block came off a held plate at x = 0.2 m, and of its speed."""
    wall = Body(geometry=BOX, density=1000.0, parameters={"length": 0.1, "width": 2.0, "height": 1.6, "size": 10.0},
                position=(0.15, 0.5, 0.0), held=("x", "y", "z", "rx", "ry", "rz"), penalty=100.0)
    simulation = block(transfer, 1.6, 0.002, steps, 0.3, [wall], **time)
    points, mass = simulation.state.points, simulation.model.soil.constants.mass
    points.velocity[:, 0] = -1.0
    start = 0.5 * mass.sum()
    for record in simulation.steps():
        pass
    assert record.contacts == 0, "still in contact"
    return energy(record) / start, mass @ simulation.state.points.velocity[:, 0] / mass.sum()


if __name__ == "__main__":
    print("transfer     free: swing left   rotating: momentum, energy   bouncing: energy, speed")
    for transfer in TRANSFERS:
        print(f"{transfer:12s} {free(transfer):12.4f}      {'  '.join(f'{x:10.6f}' for x in rotating(transfer))}"
              f"      {'  '.join(f'{x:8.4f}' for x in bouncing(transfer))}", flush=True)
    print("dissipative  " + f"{free('increments', beta=0.5625, gamma=1.0):12.4f}")
    print("gen-alpha    " + f"{free('increments', scheme='generalised-alpha', spectral_radius=0.8):12.4f}")
