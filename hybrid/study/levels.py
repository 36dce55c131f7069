"""The levels and targets of a scene's `accuracy` from the records of the study of precision.

A tolerance may change the error of any problem by no more than the share that its level allows, compared with the
tightest one that got to the end; the loosest that keeps to this everywhere is taken. Cells and steps go by halves: what
a halving costs and gains is in the records' default curves.

A target is reached by the cheapest record of a problem that differs in cells and options only, for its steps are not
those of another scene. Cost is work, Newton iterations times unknowns: seconds of runs this small are overhead. Errors
are rounded up to two digits, and to what a problem's own answer is sure of.
"""

import json
import math
from dataclasses import asdict, replace

from hybrid.scene.accuracy import WRITTEN, Level, Reference, Settings
from hybrid.study import sweep
from hybrid.study.front import front

SIZES = {"draft": 2.0, "standard": 1.0, "reference": 0.5}
SHARES = {"draft": 0.5, "standard": 0.05, "reference": 0.005}   # of the error, by which a tolerance may change it
FLOOR = 5e-5    # of an error: a change below this is none
CHAOTIC = ("anchor",)   # two runs there differ by more than a tolerance makes
ALIKE = ("column", "manufactured", "cantilever", "platen", "footing")  # problems that a scene can resemble
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


def reached(records):
    """{name: Likeness} of the problems ALIKE that were recorded: the front of each one's first error over work."""
    found = {}
    for name in ALIKE:
        module = sweep.problem(name)
        error, sure = next(iter(module.ERRORS)), getattr(module, "SURE", 0.0)
        taken = {r.key: module.like(r.values) for r in records if r.problem == name}
        rounded = [replace(r, errors={error: _upwards(max(r.errors.get(error, math.nan), sure))})
                   for r in records if taken.get(r.key)]
        if rounded:
            found[name] = Reference(module.LIKE, tuple(
                Settings(r.errors[error], f"{r.curve}, {r.setting}", **taken[r.key])
                for r in front(rounded, error, "work")))
    return found


def _upwards(error):
    """The next number of two digits that is not smaller; nan and 0 stay."""
    if not error > 0:
        return error
    digit = 10.0 ** (math.floor(math.log10(error)) - 1)
    return float(f"{math.ceil(error / digit - 1e-9) * digit:.1e}")


def write(records, path=WRITTEN):
    """Write the levels and targets that the records give."""
    written = {"levels": {name: asdict(level) for name, level in made(records).items()},
               "problems": {name: asdict(found) for name, found in reached(records).items()}}
    path.write_text(json.dumps(written, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
