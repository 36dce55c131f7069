"""Runs random scenes and records every run."""

from pathlib import Path
from time import perf_counter

from hybrid.bench.timed_steps import newton_iterations
from hybrid.runtime.errors import HybridError
from hybrid.study.failure.simulate import simulate
from hybrid.study.random import record, report
from hybrid.study.random.family import Run
from hybrid.study.random.record import Record
from hybrid.study.random.registry import FAMILIES
from hybrid.study.records import chosen, record_runs


def run(names=(), quick=False, out=Path("out/random"), resume=False, log=print):
    """Run the scenes of the families of these names (all if none), write records and figures to the folder `out`;
    returns records.

    quick: the first seeds of each family; resume: keep the records of the folder and run the scenes that are missing.
    Raises SceneError for an unknown name.
    """
    keys = [(name, seed) for name in chosen(names, FAMILIES, "random", "family")
            for seed in range(FAMILIES[name].quick if quick else FAMILIES[name].seeds)]
    return record_runs(keys, measure, record, report, out, quick, resume, log)


def measure(name, seed):
    """Record of problem number `seed` of the family of this name."""
    family = FAMILIES[name]
    return run_problem(family, family.values(name, seed), name, seed)


def run_problem(family, values, name="", seed=-1):
    """Record of a problem of a family with given values."""
    begin = perf_counter()
    try:
        found = [simulate(scene) for scene in family.scenes(**values)]
    except HybridError as failure:
        return Record(name, seed, values, "failed", reason=str(failure), seconds=round(perf_counter() - begin, 2))
    errors = family.measure(*(Run(simulation, records) for simulation, records, _ in found), **values)
    missed = tuple(family.missed(errors))
    messages = tuple(dict.fromkeys(text for *_, texts in found for text in texts))
    kind = "right" if not missed else "missed" if messages else "silent"
    return Record(name, seed, values, kind, {name: float(error) for name, error in errors.items()}, missed, "", messages,
                  sum(newton_iterations(records) for _, records, _ in found), round(perf_counter() - begin, 2))
