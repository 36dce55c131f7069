"""How should the domains of points follow the soil? By second moments or not at all? And standard points,
without domains; in plane strain.

    none      l = l0
    moments   l_i ~ √Σ_j (F_ij l0_j)², of the volume J V0

Prescribed: a block moves homogeneously through the grid (`domains_prescribed.py`).
Solved: a column is squeezed to 3/4 by its weight and let go again; a block spins by one turn.
Beyond the cell: a bar is stretched, and the width of domains is limited to that of their cell.

With n points a cell along the bar, domains that follow it are exact up to a stretch of n; from 2n on cells may be
empty, and the bar separates. Constant domains are wrong from the start and separate from n + 1, standard points from n.

    .venv/bin/python demos/domains.py          a minute; draws out/domains/domains.png
"""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from domains_prescribed import MOTIONS, RULES, SIZE, draw, prescribed, stretched, turned

from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.soil.domains import updated_half
from hybrid.soil.model import Refusal
from hybrid.step.equations import Unknowns, begin
from hybrid.step.workspace import Workspace

FREE = Faces(*["free"] * 6)


def squeezed(rule, already=0.0, cells=16, steps=40):
    """Column of 0.8 m (E = 283 Pa, ν = 0, 50 kg/m³) under its weight and let go again but for 1 %: mean errors of the
    stress over that at the bottom, under all of it and at the end."""
    size = 0.8 / cells
    side = Axis(start=0.0, end=size, collapsed=True)
    simulation = build(Scene(
        name="column", grid=Grid(side, side, Axis(start=0.0, end=0.8, size=size)),
        soil=Soil(Material(law="hencky", young=283.0, poisson=0.0, density=50.0), geostatic=False, **choice(rule)),
        time=Time(step=1.0, inertia=False), solver=Solver(linear="direct", tolerance=1e-9),
        stages=(Stage("load", steps, gravity=(0.0, 1.0)), Stage("unload", steps, gravity=(1.0, 0.01))),
        output=Output(every=0, checkpoint=0)))
    turn(simulation, already)
    wanted, bottom = -50.0 * 9.81 * (0.8 - simulation.initial_position[:, 2]), 50.0 * 9.81 * 0.8
    for record in simulation.steps():
        if record.step == steps:
            loaded = np.abs(simulation.state.points.stress[:, 2, 2] - wanted).mean() / bottom
    return loaded, np.abs(simulation.state.points.stress[:, 2, 2] - 0.01 * wanted).mean() / bottom


def turn(simulation, degrees):
    """Soil that has turned by `degrees` before the start, without strain: only its domains differ."""
    simulation.state.points.deformation[:] = turned(degrees)


def choice(rule):
    return {"basis": "mpm", "domain": "none"} if rule == "mpm" else {"domain": rule}


def spinning(rule, turns=1, steps=100, period=2.0):
    """A block of 1 m (E = 1 MPa, ν = 0, 1000 kg/m³) that spins once in 2 s from rest without stress: stress [Pa] at the
    end, root mean square, share of energy left, and share of the motion that is no rigid motion; None if it fails."""
    axis = Axis(start=0.0, end=1.6, size=SIZE)
    simulation = build(Scene(
        name="spin", grid=Grid(axis, Axis(start=0.0, end=1.0, collapsed=True), axis, FREE),
        soil=Soil(Material(law="hencky", young=1e6, poisson=0.0, density=1000.0), lower=(0.3, 0.0, 0.3),
                  upper=(1.3, 1.0, 1.3), geostatic=False, **choice(rule)),
        gravity=(0.0, 0.0, 0.0), time=Time(step=period / steps), stages=(Stage("spin", turns * steps),),
        solver=Solver(tolerance=1e-8, linear="direct"), output=Output(every=0, checkpoint=0)))
    points, mass = simulation.state.points, simulation.model.soil.constants.mass
    arm, rate = points.position - np.array([0.8, 0.5, 0.8]), 2 * np.pi / period
    points.velocity[:] = rate * np.cross([0.0, 1.0, 0.0], arm)
    points.acceleration[:] = -rate**2 * arm * [1.0, 0.0, 1.0]
    start = 0.5 * mass @ np.sum(points.velocity**2, axis=1)
    for record in simulation.steps():
        pass
    points = simulation.state.points
    arm = points.position - mass @ points.position / mass.sum()
    spin = mass @ np.cross(arm, points.velocity)[:, 1] / (mass @ np.sum(arm**2 * [1.0, 0.0, 1.0], axis=1))
    rest = points.velocity - spin * np.cross([0.0, 1.0, 0.0], arm)
    stress = np.sqrt(np.mean(np.sum(points.stress**2, axis=(1, 2))))
    left = record.energies["kinetic"] + record.energies["elastic"]
    return stress, left / start, 0.5 * mass @ np.sum(rest**2, axis=1) / start


def stretched_bar(stretch, per_cell, rule="moments", already=0.0, cells=8, steps=60):
    """(stretch, error of the stress, empty cells) of a bar whose end is pulled, a row for each step.

    The bar lies along x with its lateral strain held, E = 1 MPa, ν = 0: σ = E ln λ / λ everywhere. Nodes in the last
    cell and beyond are moved as λ prescribes, the others are in equilibrium. The error is the root mean square over the
    bar's first three quarters, relative to E / e, the largest stress of the law in tension.
    """
    young, length = 1e6, float(cells)
    side = Axis(start=0.0, end=1.0, collapsed=True)
    simulation = build(Scene(
        name="bar", grid=Grid(Axis(start=0.0, end=(stretch * cells + 2) // 1 + 1, size=1.0), side, side,
                              replace(FREE, x_min="roller")),
        soil=Soil(Material(law="hencky", young=young, poisson=0.0, density=1000.0), upper=(length, 1.0, 1.0),
                  geostatic=False, points_per_axis=(per_cell, 1, 1), **choice(rule)),
        gravity=(0.0, 0.0, 0.0), time=Time(step=1.0, inertia=False), stages=(Stage("draw", 1),),
        solver=Solver(linear="direct"), output=Output(every=0, checkpoint=0)))
    model, state, rows = simulation.model, simulation.state, []
    nodes = model.soil.grid.axes[0]
    turn(simulation, already)
    near = model.soil.constants.position[:, 0] < 0.75 * length
    before = 1.0
    for factor in np.linspace(1.0, stretch, steps + 1)[1:]:
        fixed = model.soil.grid.fixed.copy()
        fixed[nodes > before * length - 1.0] = True
        soil = replace(simulation.model.soil, grid=replace(simulation.model.soil.grid, fixed=fixed))
        model = model.with_soil(soil)
        try:
            step = begin(model, state, 1.0, False, Workspace(model))
        except StepError:       # the bar has parted, and nothing carries one of its pieces
            break
        displacement = np.zeros((len(nodes), 3))
        displacement[:, 0] = (factor / before - 1) * nodes
        evaluation = balanced(step, Unknowns(displacement, ()), 1e-9 * young)
        if evaluation is None:
            break
        state, before = step.accept(evaluation), factor
        stress = state.points.stress[near, 0, 0] - young * np.log(factor) / factor
        rows.append((factor, np.sqrt(np.mean(stress**2)) * np.e / young, empty_cells(state.points, nodes, rule)))
    return np.array(rows)


def balanced(step, unknowns, tolerance, iterations=30):
    """Evaluation with no residual above `tolerance` [N], found from `unknowns`, whose held nodes move as given; None
    without one. (The forces of a uniform stress cancel at every free node, so there is none to compare with.)"""
    evaluation = step.evaluate(unknowns)
    for _ in range(iterations):
        if isinstance(evaluation, Refusal):
            return None
        if np.abs(evaluation.soil).max() <= tolerance:
            return evaluation
        step.assemble(evaluation)
        soil, body, _ = step.system.solve(evaluation.soil, evaluation.body)
        evaluation = step.evaluate(step.moved(evaluation.unknowns, soil, body))
    return None


def empty_cells(points, nodes, rule):
    """Number of cells between the first and the last point that no domain reaches."""
    x, half = points.position[:, 0], points.half_width[:, 0] * (rule != "mpm")
    low, high = nodes[:-1, None], nodes[1:, None]
    full = np.flatnonzero(np.any((x + half >= low + 1e-9) & (x - half <= high - 1e-9), axis=1))
    return int(full[-1] - full[0] + 1 - len(full))


def parts(per_cell, rule="moments", cells=12):
    """Stretch from which a uniform bar, wherever it lies, may have cells that no domain reaches: there it parts."""
    nodes, start = np.arange(-1.0, 12.0 * cells), (np.arange(cells * per_cell) + 0.5) / per_cell
    half = np.full((len(start), 3), 0.5 / per_cell)
    for stretch in np.arange(1.0, 10.0, 0.05) + 1e-6:
        for offset in np.linspace(0.0, 1.0, 11):
            position = (offset + stretch * start)[:, None] * [1.0, 0.0, 0.0]
            F = np.tile(stretched(stretch), (len(start), 1, 1))
            axes = nodes, np.zeros(1), np.zeros(1)
            wide = updated_half("none" if rule == "mpm" else rule, half, F, position, axes)
            if empty_cells(SimpleNamespace(position=position, half_width=wide), nodes, rule):
                return stretch
    return np.inf


def show():
    print("prescribed, worst on the way                    volume       gap   overlap     force")
    for name, motion in MOTIONS.items():
        for rule in RULES:
            print(f"{name:37s} {rule:9s}" + "".join(f"{v:10.4f}" for v in prescribed(rule, motion)))
    print("\nsolved         column: stress under load, left      the same, turned by 90 deg first        one spin:"
          " stress [Pa], energy left, not rigid")
    for rule in RULES:
        values = *squeezed(rule), *squeezed(rule, 90), *spinning(rule)
        print(f"{rule:9s}" + "".join(f"{v:18.5g}" for v in values))
    print("\nbar stretched: points a cell, largest stretch with no error of the stress, error then, cells empty from")
    for rule in RULES:
        for count in (2, 3, 4):
            rows = stretched_bar(1.2 * count, count, rule, steps=60)
            good = rows[rows[:, 1] < 1e-6]
            upto, then = (good[-1, 0], rows[min(len(good), len(rows) - 1), 1]) if len(good) else (1.0, rows[0, 1])
            print(f"{rule:9s} {count} {upto:10.3f} {then:12.2g} {parts(count, rule):10.2f}")


if __name__ == "__main__":
    show()
    draw(Path("out/domains"))
