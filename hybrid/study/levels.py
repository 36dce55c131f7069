"""The levels of a scene's `accuracy` from the records of the study of precision.

A tolerance may add to the error of any problem no more than the share that its level allows; the loosest that keeps to
this everywhere is taken. Cells and steps go by halves: what a halving costs and gains is in the records' default curves.
"""

import json
import math

from hybrid.levels import WRITTEN, Level

SIZES = {"draft": 2.0, "standard": 1.0, "reference": 0.5}
SHARES = {"draft": 0.3, "standard": 0.05, "reference": 0.005}   # of the error, that a tolerance may add
CURVES = {"tolerance": "Newton tolerance", "linear_tolerance": "Krylov tolerance"}


def loosest(records, curve, share):
    """The loosest tolerance of `curve` that adds no more than `share` to any error of any problem.

    Raises ValueError where no problem has that curve.
    """
    found = []
    for name in dict.fromkeys(r.problem for r in records):
        own = sorted((r for r in records if (r.problem, r.curve) == (name, curve)), key=lambda r: float(r.setting))
        if not own:
            continue
        allowed = math.nan
        for record in own:
            if record.failed or any(error > (1 + share) * own[0].errors[kind] for kind, error in record.errors.items()):
                break
            allowed = float(record.setting)
        found.append(allowed)
    if not found:
        raise ValueError(f"no records of the curve {curve!r}")
    return min(found)


def made(records):
    """{name: Level}."""
    return {name: Level(size, size, *(loosest(records, curve, SHARES[name]) for curve in CURVES.values()))
            for name, size in SIZES.items()}


def write(records, path=WRITTEN):
    """Write the levels that the records give."""
    text = json.dumps({name: vars(level) for name, level in made(records).items()}, indent=1)
    path.write_text(text + "\n", encoding="utf-8")
