"""Time of a step against the number of unknowns: the block of `hybrid.bench.block` on successively finer grids."""

import numpy as np

from hybrid.bench.scenes import block
from hybrid.bench.timed_steps import exponent, sizes, timed_steps, warm
from hybrid.setup.build import build

HEIGHTS = (9, 13, 19, 29)      # cells, twice as many along x and y: 9 700 to 302 000 unknowns
STEPS = 4       # the first one, which allocates, counts for nothing
PHASES = ("soil", "assemble", "factor", "solve", "transfer", "update")   # of a step, on average


def run(options):
    """A row for each size, with the powers of the number of unknowns with which times and iterations grow up to it."""
    warm()
    rows = []
    for height in (2, 3) if options.quick else HEIGHTS:
        simulation = build(block((2 * height, 2 * height, height), 0.5 / height, steps=STEPS))
        size = sizes(simulation)
        records, seconds = timed_steps(simulation)
        records, seconds = records[1:], seconds[1:]
        newton, krylov = (sum(getattr(record, name) for record in records) for name in ("iterations", "krylov"))
        phases = {f"{name} [s]": float(np.mean([record.seconds.get(name, 0.0) for record in records])) for name in PHASES}
        rows.append({**size, "s a step": float(np.mean(seconds)), "s a Newton iteration": sum(seconds) / newton,
                     "Newton a step": newton / len(records), "Krylov a Newton": krylov / newton, **phases})
    for last in range(len(rows)):
        own = rows[:last + 1]
        for name in ("s a step", "s a Newton iteration", "Krylov a Newton"):
            fitted = exponent([r["unknowns"] for r in own], [r[name] for r in own]) if last else None
            rows[last][f"power of {name}"] = fitted
    return rows
