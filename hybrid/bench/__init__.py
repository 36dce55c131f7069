"""Benchmarks: time and memory of the program for scenes of known size, recorded as JSON with the machine.

A case is a module with one function, `run(options) -> list of rows`, a row being a dict of numbers and texts; all
rows of a case have the same keys. The counts in a row do not depend on the machine; its times do.
"""

import json
from dataclasses import dataclass
from datetime import datetime, timezone
from importlib import import_module
from pathlib import Path
from time import perf_counter

CASES = {
    "kernels": "each part of a step on 48 000 points",
    "anchor": "demos/anchor.toml, by phase",
    "sphere": "demos/rolling_sphere.toml in 300 steps",
    "scaling": "a block of soil under gravity, from 10 000 to 300 000 unknowns",
    "ranks": "one process, two threads and two processes: a block of 106 000 unknowns, and the anchor",
    "exchange": "iterations, bytes, messages and reductions of a block on 1, 2, 4 and 8 processes",
    "solvers": "the linear solvers for one tangent, easy and hard",
    "block": "the peer's block of 46 552 points, also run by the peer if there is one",
}


@dataclass(frozen=True)
class Options:
    """quick: the smallest size of every case, to check its counts; peer: path of a Python with Kratos MPM, or None."""

    quick: bool = False
    peer: Path | None = None


def run(names=(), options=Options(), out=None, log=print):
    """Run the cases of these names (all if none), log a table of each, and return {"stamp": ..., "cases": {name:
    {"rows", "seconds", "peak_MiB"}}}, which is also written to `out` as JSON after each case.

    Raises KeyError for a name that is not among CASES.
    """
    from hybrid.bench.stamp import stamp
    from hybrid.bench.table import table

    names = list(names) or list(CASES)
    modules = {name: import_module(f"hybrid.bench.{name}") for name in names if CASES[name]}
    began = datetime.now(timezone.utc).isoformat(timespec="seconds")
    result = {"stamp": {"date": began, "quick": options.quick, **stamp()}, "cases": {}}
    for name, module in modules.items():
        result["cases"][name] = case = measured(module.run, options)
        smallest = "; --quick: its smallest size" * options.quick
        log(f"\n{name}: {CASES[name]}{smallest}\n{table(case['rows'])}\n"
            f"  {case['seconds']:.3g} s in all, peak memory {case['peak_MiB']:.0f} MiB")
        if out is not None:
            Path(out).parent.mkdir(parents=True, exist_ok=True)
            Path(out).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    return result


def measured(work, options):
    """Rows of a case, its wall time [s] and its peak memory [MiB]."""
    from hybrid.bench.stamp import forget_peak
    from hybrid.runtime.memory import peak_memory

    forget_peak()
    begin = perf_counter()
    rows = work(options)
    return {"rows": rows, "seconds": perf_counter() - begin, "peak_MiB": peak_memory() / 2**20}
