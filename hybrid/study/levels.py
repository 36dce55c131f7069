"""The levels of a scene's `accuracy` from the records of the study of precision.

A tolerance may change the error of any problem by no more than the share that its level allows, compared with the
tightest one that got to the end; the loosest that keeps to this everywhere is taken. Cells and steps go by halves: what
a halving costs and gains is in the records' default curves.
"""

import json

from hybrid.levels import WRITTEN, Level

SIZES = {"draft": 2.0, "standard": 1.0, "reference": 0.5}
SHARES = {"draft": 0.5, "standard": 0.05, "reference": 0.005}   # of the error, by which a tolerance may change it
FLOOR = 5e-5    # of an error: a change below this is none
CHAOTIC = ("anchor",)   # two runs there differ by more than a tolerance makes
CURVES = {"tolerance": "Newton tolerance", "linear_tolerance": "Krylov tolerance"}


def loosest(records, curve, share):
    """The loosest tolerance of `curve` that changes no error of any problem by more than `share` of it.

    Raises ValueError where no problem has that curve.
    """
    found = []
    for name in dict.fromkeys(r.problem for r in records if r.problem not in CHAOTIC):
        own = sorted((r for r in records if (r.problem, r.curve) == (name, curve)), key=lambda r: float(r.setting))
        while own and own[0].failed:    # tighter than the machine's round-off allows
            del own[0]
        same = [not record.failed and all(
            not abs(error - own[0].errors[kind]) > max(share * own[0].errors[kind], FLOOR)
            for kind, error in record.errors.items()) for record in own]
        if own:
            found.append(float(own[(same + [False]).index(False) - 1].setting))
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
