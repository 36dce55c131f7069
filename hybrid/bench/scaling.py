"""Time of a step against the number of unknowns: the block of `hybrid.bench.block` in finer and finer cells."""

import numpy as np

from hybrid.bench.soils import block, exponent, sizes, stepped, warm
from hybrid.build import build

HEIGHTS = (9, 13, 19, 29)      # cells, twice as many along x and y: 9 700 to 302 000 unknowns
STEPS = 3


def run(options):
    """A row for each size, and in each the powers of the unknowns with which times and iterations go up to it."""
    warm()
    rows = []
    for height in (2, 3) if options.quick else HEIGHTS:
        simulation = build(block((2 * height, 2 * height, height), 0.5 / height, steps=STEPS))
        size = sizes(simulation)
        records, seconds = stepped(simulation)
        newton, krylov = (sum(getattr(record, name) for record in records) for name in ("iterations", "krylov"))
        rows.append({**size, "s a step": float(np.median(seconds[1:])), "s a Newton iteration": sum(seconds) / newton,
                     "Newton a step": newton / STEPS, "Krylov a Newton": krylov / newton,
                     "assembly [s]": _phase(records, "assemble"), "factor [s]": _phase(records, "factor"),
                     "solve [s]": _phase(records, "solve")})
    for last in range(len(rows)):
        own = rows[:last + 1]
        for name in ("s a Newton iteration", "Krylov a Newton"):
            fitted = exponent([r["unknowns"] for r in own], [r[name] for r in own]) if last else None
            rows[last][f"power of {name}"] = fitted
    return rows


def _phase(records, name):
    """Seconds of a phase in a step, on average."""
    return sum(record.seconds.get(name, 0.0) for record in records) / len(records)
