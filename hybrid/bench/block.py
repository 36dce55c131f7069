"""A block of soil under sudden gravity: 46 552 points, plastic from the first step; also run by a peer.

1 x 1 x 0.5 m in 23 x 23 x 11 cells, E = 10 MPa, ν = 0.3, ρ = 1800 kg/m³, φ = 32°, ψ = 2°, c = 1 kPa, full gravity at
once, rollers at base and sides, Newmark, 5 steps of 0.01 s. If a Python with Kratos MPM is given, both run alternately
on the same number of threads, and the last row gives the peer's times over ours.
"""

import numba
import numpy as np

from hybrid.bench.peer import ask
from hybrid.bench.scenes import SAND, block
from hybrid.bench.timed_steps import sizes, timed_steps, warm
from hybrid.setup.build import build

ROUNDS, THREADS, STEPS, STEP = 3, 2, 5, 0.01
PEER_TOLERANCE = 1e-4   # of the peer's residual relative to its first; ours is relative to the forces acting


def run(options):
    """A row for each run, and a row of ratios if there is a peer."""
    warm()
    cells, rounds = ((6, 6, 3), 1) if options.quick else ((23, 23, 11), ROUNDS)
    before = numba.get_num_threads()
    threads = min(THREADS, numba.config.NUMBA_NUM_THREADS)
    numba.set_num_threads(threads)
    try:
        rows = []
        for _ in range(rounds):
            rows.append(ours(cells))
            if options.peer is not None:
                rows.append(peers(cells, options.peer, threads))
    finally:
        numba.set_num_threads(before)
    return rows + ([ratios(rows)] if options.peer is not None else [])


def ours(cells):
    """Row of a run of this program."""
    simulation = build(block(cells, 1 / cells[0], SAND, steps=STEPS))
    records, seconds = timed_steps(simulation)
    sunk = simulation.state.points.position[:, 2] - simulation.initial_position[:, 2]
    tolerance = simulation.scene.solver.tolerance
    return row("hybrid", seconds, [record.iterations for record in records], tolerance, sizes(simulation), sunk.min(),
               [record.krylov for record in records])


def peers(cells, python, threads):
    """Row of a run of the peer. Raises HybridError with the end of its output if it fails."""
    answer = ask(python, "kratos_block.py", {"cells": cells, "size": 1 / cells[0], "steps": STEPS, "step": STEP,
                                           "tolerance": PEER_TOLERANCE, "material": SAND}, threads)
    size = {"points": answer["points"], "unknowns": None, "entries": None}
    return row(f"kratos {answer['version'].partition('-')[0]}", answer["seconds"], answer["newton"], PEER_TOLERANCE,
               size, answer["lowest [m]"])


def row(program, seconds, newton, tolerance, size, lowest, krylov=None):
    """Row of one run: mean time of all and median of later steps, iterations of Newton's method and of the linear
    solver."""
    return {"program": program, "s a step": float(np.mean(seconds)), "s a later step": float(np.median(seconds[1:])),
            "s a Newton iteration": sum(seconds) / sum(newton), "Newton": sum(newton),
            "Krylov": None if krylov is None else sum(krylov), "tolerance": tolerance,
            "lowest [mm]": 1e3 * float(lowest), **size}


def ratios(rows):
    """Row of the peer's medians over ours, both over the rounds."""
    own, other = ([r for r in rows if (r["program"] == "hybrid") == mine] for mine in (True, False))
    ratio = dict.fromkeys(rows[0])
    for name in ("s a step", "s a later step", "s a Newton iteration", "Newton", "lowest [mm]"):
        ratio[name] = float(np.median([r[name] for r in other]) / np.median([r[name] for r in own]))
    return {**ratio, "program": "peer over hybrid"}
