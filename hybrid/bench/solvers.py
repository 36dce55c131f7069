"""The linear solvers for single tangents: well-conditioned ones, and with stiff contact, small or hardly filled cells.

Each preconditioner takes at most 300 iterations; which of them a run takes is decided by `hybrid.linalg.solver_choice`.
The tangent is that of a block under a cube that moves down by a share of a cell; without a cube, that of the block in
free fall with random displacements of all nodes. The right-hand side is the residual in that state. Rows give the
relative residual after the solve and the Krylov iterations to 1e-3.
"""

from dataclasses import replace
from time import perf_counter

import numpy as np

from hybrid.bench.kernels import pressed
from hybrid.bench.scenes import ELASTIC, SAND, block, contracted
from hybrid.bench.timed_steps import warm
from hybrid.linalg.solver_choice import DIRECT, ILU0, ILU0_SHIFTED, SSOR, Single
from hybrid.runtime.errors import StepError
from hybrid.setup.build import build
from hybrid.step.equations import begin
from hybrid.step.evaluation import Unknowns
from hybrid.step.workspace import Workspace

SMALL, LARGE = (26, 26, 9), (36, 36, 14)    # 20 000 and 60 000 unknowns
CUBE = 0.3  # [m]
CLAY = {**ELASTIC, "law": "von-mises", "poisson": 0.49, "strength": 1e3}
SOLVERS = {"sweeps": SSOR, "incomplete": ILU0, "damped": ILU0_SHIFTED, "direct": DIRECT}


def cases(quick):
    """(name, cells, size [m], options of the block, share of its cell that the top layer fills, solvers)."""
    every, krylov, width = tuple(SOLVERS), tuple(SOLVERS)[:-1], 1.0
    sizes = [((6, 6, 4), every)] if quick else [(SMALL, every), (LARGE, every)]
    for cells, solvers in sizes:
        for law, material in (("elastic", ELASTIC), ("plastic", SAND), ("clay", CLAY)):
            for kind, inertia in (("dynamic", True), ("quasi-static", False)):
                yield (f"{law}, {kind}", cells, width / cells[0], {"material": material, "inertia": inertia}, 1.0,
                       solvers if law == "elastic" or cells != LARGE else krylov)
    cells = sizes[0][0]
    for factor in (1.0, 100.0, 1e4):
        yield (f"contact, penalty x {factor:g}", cells, width / cells[0], {"body": (CUBE, 50.0 * factor)}, 1.0, krylov)
    half = tuple(2 * n for n in cells) if quick else LARGE
    yield "contact, smaller cells", half, width / half[0], {"body": (CUBE, 50.0)}, 1.0, krylov
    for filled in (0.3, 0.01):
        for ghost in (0.0, 0.033):
            yield (f"top cells filled to {filled:g}, ghost {ghost:g}", cells, width / cells[0],
                   {"material": ELASTIC, "inertia": False, "ghost": ghost}, filled, krylov)


def run(options):
    """A row for each tangent and solver."""
    warm()
    rows = []
    for name, cells, size, chosen, filled, solvers in cases(options.quick):
        simulation = build(block(cells, size, **chosen))
        state = contracted(simulation.state) if filled == 1.0 else _lifted(simulation, filled)
        for solver in solvers:
            rows.append(_solved(name, solver, simulation.model, state))
    return rows


def _lifted(simulation, filled):
    """State of a block that fills a share `filled` of the next layer of cells."""
    state, cell = simulation.state, simulation.model.soil.grid.smallest_cell
    up = state.points.position + (0.0, 0.0, filled * cell)
    low = up[:, 2].min() - state.points.half_width[0, 2]
    up[:, 2] -= low * np.clip(1 - up[:, 2] / up[:, 2].max(), 0, 1)     # the base stays
    return replace(state, points=replace(state.points, position=up))


def _solved(name, solver, model, state):
    """Row of one tangent and solver."""
    workspace = Workspace(model)
    workspace.systems.choice = Single(SOLVERS[solver])
    step = begin(model, state, 0.01, False, workspace)
    unknowns = pressed(step) if model.bodies else _shaken(step)
    found = step.evaluate(unknowns)
    step.assemble(found)
    started = perf_counter()
    step.system.factor()
    factored = perf_counter()
    row = {"tangent": name, "solver": solver, "unknowns": step.pattern.size + len(found.body),
           "entries": len(step.system.values), "contact points": sum(len(c) for c in found.contacts)}
    try:
        soil, body, iterations = step.system.solve(found.soil, found.body)
        left, failed = _residual(step, found, soil, body), ""
    except StepError as error:
        iterations, left, failed = 0, 1.0, str(error).partition(";")[0]
    solved = perf_counter()
    step.system.destroy()
    return {**row, "iterations": iterations, "left": left, "factor [s]": factored - started,
            "solve [s]": solved - factored, "failed": failed}


def _shaken(step):
    """Unknowns with random displacements of all free nodes, up to a 500th of a cell, the same in every run."""
    grid = step.model.soil.grid
    shaken = np.random.default_rng(1).uniform(-1, 1, (grid.node_count, 3)) * 0.002 * grid.smallest_cell
    shaken[grid.fixed] = 0.0
    shaken[~step.soil.active] = 0.0
    return Unknowns(shaken, ())


def _residual(step, found, soil, body):
    """Norm of the remaining residual over that of the right-hand side. The product of matrix and solution is the
    difference of two residuals a small step along the solution, so the format of the matrix does not matter."""
    share = 1e-6
    before = np.concatenate([found.soil, found.body])
    moved = step.evaluate(step.moved(found.unknowns, soil, body, share))
    change = (np.concatenate([moved.soil, moved.body]) - before) / share
    return float(np.linalg.norm(before + change) / np.linalg.norm(before))
