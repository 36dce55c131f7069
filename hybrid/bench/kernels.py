"""Each part of a step alone, on soil that yields under a cube of steel, its points moved from their initial lattice."""

from dataclasses import replace
from time import perf_counter

import numpy as np

from hybrid.bench.scenes import block, contracted
from hybrid.bench.timed_steps import sizes, warm
from hybrid.contact.contact_pair import ContactPair
from hybrid.contact.contact_points import SoilSurface
from hybrid.contact.search import Domains
from hybrid.setup.build import build
from hybrid.soil.basis import evaluate_basis
from hybrid.step.equations import begin
from hybrid.step.evaluation import Unknowns
from hybrid.step.workspace import Workspace

REPEAT = 7


def run(options):
    """A row for each part: median time, in all, per point and per entry of the soil block."""
    warm()
    cells = (6, 6, 4) if options.quick else (20, 20, 15)
    described = block(cells, 0.05, body=(0.2, 50.0))
    simulation = build(described)
    model, state = simulation.model, contracted(simulation.state)
    soil, workspace = model.soil, Workspace(model)
    step = begin(model, state, 0.01, False, workspace)
    unknowns = pressed(step)
    found = step.evaluate(unknowns)
    step.assemble(found)
    law = soil.law
    strain, plastic = found.soil_trial.strain.strain.copy(), state.points.plastic_strain
    fbar = build(replace(described, soil=replace(described.soil, fbar=True))).model.soil
    begun = fbar.begin(state.points, model.gravity)
    trial = fbar.evaluate(begun, unknowns.displacement)
    parts = {
        "basis": lambda: evaluate_basis(state.points.position, state.points.half_width, soil.grid.axes),
        "begin: basis and projection": lambda: soil.begin(state.points, model.gravity),
        "return mapping": lambda: law.respond(strain, plastic),
        "strain, law, internal force": lambda: soil.evaluate(
            step.soil, unknowns.displacement, keep=found.soil_trial),
        "tangent into the block matrix": lambda: soil.add_stiffness(
            step.soil, found.soil_trial, step.pattern, step.system.values),
        "the same with F-bar": lambda: fbar.add_stiffness(begun, trial, step.pattern, step.system.values),
        "state update": lambda: soil.accept(
            step.soil, found.soil_trial, unknowns.displacement, *found.rates),
        "search of contact": lambda: _pair(step),
        "contact": lambda: [pair.evaluate(unknowns.displacement, pose)
                            for pair, pose in zip((b.pair for b in step.bodies), unknowns.poses)],
        "factor": lambda: step.system.factor(),
    }
    size = sizes(simulation)
    size["entries"] = len(step.system.values)
    flowing = np.abs(strain - found.soil_trial.response.elastic).max(axis=1) > 1e-12
    rows = []
    for name, work in parts.items():
        seconds = _median(work)
        rows.append({"part": name, "ms": 1e3 * seconds, "ns a point": 1e9 * seconds / size["points"],
                     "ns an entry": 1e9 * seconds / size["entries"], **size,
                     "contact points": sum(len(c) for c in found.contacts), "flowing": int(flowing.sum())})
    return rows


def pressed(step, share=0.02):
    """Unknowns with the cube moved down by a `share` of a cell and the soil following it, less with depth and with
    distance: enough for the soil to yield."""
    grid, (pose,) = step.model.soil.grid, step.at_rest().poses
    nodes = np.stack([a.ravel() for a in np.meshgrid(*grid.axes, indexing="ij")], axis=1)
    surface = step.state.points.position[:, 2].max()
    depth = share * grid.smallest_cell
    away = np.linalg.norm(nodes[:, :2] - pose[0][:2], axis=1)
    down = 0.5 * depth * np.exp(-((away / 0.1) ** 2)) * np.clip(nodes[:, 2] / surface, 0, 1)
    displacement = np.where(grid.fixed, 0.0, -down[:, None] * [0.0, 0.0, 1.0])
    displacement[~step.soil.active] = 0.0
    return Unknowns(displacement, ((pose[0] - (0.0, 0.0, depth), pose[1]),))


def _pair(step):
    """The pair of cube and soil made anew: the search of contact."""
    guess, begun, soil = step.predictor(), step.bodies[0], step.model.soil
    domains = Domains.of(step.soil.points, soil.constants, soil.basis)
    return ContactPair(SoilSurface(domains, soil.grid, step.soil.active), begun.body, begun.state, step.state.contacts[0],
                       begun.reach, (guess.displacement, guess.poses[0]))


def _median(work):
    """Median wall time [s] of `work`, after one call that is not timed."""
    work()
    times = []
    for _ in range(REPEAT):
        started = perf_counter()
        work()
        times.append(perf_counter() - started)
    return float(np.median(times))
