"""GMRES iterations against the number of processes, and what the processes exchange: bytes, messages, reductions.

Three steps of a block of sand and one of clay with F-bar, on 1 to 8 processes that share the cores there are. All figures
are counts: they do not depend on how busy the machine is. A figure is that of the process that has most of it.

`python -m hybrid.bench.exchange HEIGHT SOIL FILE` under mpirun counts one run; rank 0 writes its row to FILE.
"""

import json
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

HEIGHT, STEPS = 14, 3       # cells of the block, twice as many along x and y: 37 000 unknowns
RANKS = (1, 2, 4, 8)
SOILS = ("sand", "clay")
# Strength [Pa] of clay that bears its weight; weaker clay ends with a direct factor on any number of ranks
STRENGTH = 10e3
SOLVERS = ("sweeps", "incomplete", "damped", "direct")      # by their numbers in hybrid.linalg.solver_choice
COLLECTIVE = ("_over_processes", "gathered", "counts", "offset", "from_first", "to_each")     # of hybrid.runtime.comm


def run(options):
    """A row for each soil and number of processes."""
    height, soils, ranks = (3, SOILS[:1], RANKS[:2]) if options.quick else (HEIGHT, SOILS, RANKS)
    with tempfile.TemporaryDirectory() as folder:
        return [{"soil": soil, "ranks": number, **_counted(height, soil, number, Path(folder, "row.json"))}
                for soil in soils for number in ranks]


def _counted(height, soil, number, file):
    """Row of a run by a `number` of processes. Raises RuntimeError with the end of its messages if it fails."""
    from hybrid.runtime.ranks import launch

    program = ["-m", "hybrid.bench.exchange", height, soil, file]
    command, environment = launch(number, program)
    command = command if number > 1 else [sys.executable, *map(str, program)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed: {done.stderr[-500:]}")
    return json.loads(file.read_text(encoding="utf-8"))


# ------------------------------------------------------------------ in each process


def scene(height, soil):
    """The block, `height` cells high, with F-bar; clay is nearly incompressible."""
    from hybrid.bench.scenes import ELASTIC, SAND, block

    clay = {**ELASTIC, "law": "von-mises", "poisson": 0.49, "strength": STRENGTH}
    return block((2 * height, 2 * height, height), 1 / height, SAND if soil == "sand" else clay, steps=STEPS)


class Counts(Counter):
    """Counts of collective operations and of exchanged fields, by whether a linear system is being solved.

    unknowns: of the last linear system; local: (ranks,) those that this process holds, by their owners
    """

    def __init__(self, comm, systems, choice):
        super().__init__()
        self._solving = False
        for name in COLLECTIVE:
            setattr(comm, name, self._counting(getattr(comm, name)))
        comm.neighbours = self._exchanging(comm.neighbours)
        for kind in systems:
            kind.solve = self._solved(kind.solve)
        choice.solved = self._finished(choice.solved)

    def _counting(self, function):
        def counted(*given):
            self["collective", self._solving] += 1
            return function(*given)
        return counted

    def _exchanging(self, function):
        def counted(send, *given):
            self["fields"] += 1
            self["bytes"] += sum(array.nbytes for array in send.values())
            return function(send, *given)
        return counted

    def _solved(self, function):
        def counted(system, *given):
            self._solving = True
            try:
                found = function(system, *given)
            finally:
                self._solving = False
            self.unknowns, self.local = system.soil_unknowns, _local(system)
            return found
        return counted

    def _finished(self, function):
        def counted(choice, solver, iterations, tolerance):
            self[SOLVERS[solver]] += iterations
            return function(choice, solver, iterations, tolerance)
        return counted


def count(height, soil):
    """Row of this run, the same in all processes."""
    from hybrid.linalg.petsc import BlockSystem
    from hybrid.linalg.petsc_ranks import DistributedSystem, begin_counting, counted
    from hybrid.linalg.solver_choice import SolverChoice
    from hybrid.runtime import comm, ranks
    from hybrid.setup.build import build

    simulation = build(scene(height, soil))
    counts = Counts(comm, (BlockSystem, DistributedSystem), SolverChoice)
    begin_counting()
    records = list(simulation.steps())
    within, outside = counts["collective", True], counts["collective", False]
    newton, krylov = (sum(getattr(record, name) for record in records) for name in ("iterations", "krylov"))
    inverse, gmres = (counted(name) for name in ("PCApply", "KSPSolve"))
    grid, local, several = simulation.model.soil.grid, counts.local, ranks.started() > 1
    plan, own = grid.nodes, int(local[ranks.rank()])
    copies, given = int(local.sum()) - own, int(comm.counts(local)[ranks.rank()]) - own
    figures = {
        "own nodes": np.count_nonzero(plan.owned) if several else grid.node_count,
        "copied nodes": np.count_nonzero(~plan.owned) if several else 0,
        "own unknowns": own, "copied unknowns": copies,
        "neighbours": len(plan.given.keys() | plan.copies.keys()) if several else 0,
        "kB a product": 8e-3 * (given + copies),      # copies are filled, and what was added to them goes back
        "kB a preconditioner": 0.5e-3 * inverse["messageLength"] / inverse["count"],   # PETSc counts sent and received
        "kB a vector field": 24e-3 * sum(map(len, plan.given.values())) if several else 0,
        "reductions a GMRES iteration": ((gmres["numReductions"] if several else 0) + within) / krylov,
        "exchanges a Newton iteration": counts["fields"] / newton,
        "kB of fields a Newton iteration": 1e-3 * counts["bytes"] / newton,
        "reductions a Newton iteration": outside / newton if several else 0,
    }
    largest = {key: comm.largest([value]) for key, value in figures.items()}
    whole = ("nodes", "unknowns", "neighbours")     # numbers of things
    largest = {key: int(value) if key.endswith(whole) else value for key, value in largest.items()}
    used = {name: counts[name] for name in SOLVERS if counts[name]}
    return {"unknowns": counts.unknowns, "steps": len(records), "Newton": newton, "Krylov": krylov,
            "with": ", ".join(used),
            "in vain": krylov - sum(used.values()),
            "copied / own": largest["copied unknowns"] / largest["own unknowns"], **largest}


def _local(system):
    """(ranks,) numbers of unknowns that this process holds, by their owners."""
    from hybrid.runtime import ranks

    if ranks.started() == 1:
        return np.array([system.soil_unknowns])
    return np.bincount(system.owners(), minlength=ranks.started())


if __name__ == "__main__":
    from hybrid.runtime.ranks import rank

    row = count(int(sys.argv[1]), sys.argv[2])
    if rank() == 0:
        Path(sys.argv[3]).write_text(json.dumps(row), encoding="utf-8")
