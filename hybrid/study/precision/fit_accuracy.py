"""Fits the levels and targets of a scene's `accuracy` to the records of the study of precision.

Levels. A level sets the loosest tolerance that changes the error of every problem by no more than the level's share,
compared with the tightest tolerance that converged. Cells and steps are doubled or halved; the default curves of the
records show the cost and the gain of a halving.

Targets. Each problem contributes its Pareto front of error against work (Newton iterations times unknowns; the seconds
of runs this small are overhead). Only runs that differ in cells and options count, because the time steps of a problem
are not those of another scene; and not those of another linear solver, which changes no error, and which in a larger scene
may be the slow one. Errors are rounded up to two digits, and to the smallest error that is certain.
"""

import json
import math
from dataclasses import asdict, replace

from hybrid.scene.accuracy import WRITTEN, Level, Reference, Settings
from hybrid.study.precision.pareto import front
from hybrid.study.precision.registry import PROBLEMS

SIZES = {"draft": 2.0, "standard": 1.0, "reference": 0.5}
SHARES = {"draft": 0.5, "standard": 0.05, "reference": 0.005}   # change of an error that a tolerance may cause
FLOOR = 5e-5    # smaller changes of an error are disregarded
CHAOTIC = ("anchor",)   # two runs differ by more than a tolerance changes them
CURVE = "Newton tolerance"


def loosest(records, share, curve=CURVE):
    """The loosest tolerance of a curve that changes no error of any problem by more than `share` of it.

    Raises ValueError if no problem has that curve.
    """
    tolerances = []
    for name in dict.fromkeys(r.problem for r in records if r.problem not in CHAOTIC):
        own = sorted((r for r in records if (r.problem, r.curve) == (name, curve)), key=lambda r: float(r.setting))
        while own and own[0].failed:    # below round-off
            del own[0]
        same = [not record.failed and all(
            not abs(error - own[0].errors[kind]) > max(share * own[0].errors[kind], FLOOR)
            for kind, error in record.errors.items()) for record in own]
        if own:
            tolerances.append(float(own[(same + [False]).index(False) - 1].setting))
    if not tolerances:
        raise ValueError(f"no records of the curve {curve!r}")
    return min(tolerances)


def levels(records):
    """{name: Level}."""
    return {name: Level(size, size, loosest(records, SHARES[name]))
            for name, size in SIZES.items()}


def references(records):
    """{name: Reference} of the recorded problems that scenes can resemble: the front of their first error over work."""
    fitted = {}
    for name, problem in PROBLEMS.items():
        if problem.transferable is None:
            continue
        error = next(iter(problem.errors))
        settings = {r.key: problem.transferable(r.values) for r in records if r.problem == name}
        rounded = [replace(r, errors={error: _upwards(max(r.errors.get(error, math.nan), problem.certain))})
                   for r in records if settings.get(r.key) and "linear" not in settings[r.key].get("solver", {})]
        if rounded:
            fitted[name] = Reference(problem.length, tuple(
                Settings(r.errors[error], f"{r.curve}, {r.setting}", **settings[r.key])
                for r in front(rounded, error, "work")))
    return fitted


def _upwards(error):
    """The next number of two digits that is not smaller; nan and 0 stay."""
    if not error > 0:
        return error
    digit = 10.0 ** (math.floor(math.log10(error)) - 1)
    return float(f"{math.ceil(error / digit - 1e-9) * digit:.1e}")


def write(records, path=WRITTEN):
    """Write the levels and targets that the records give."""
    written = {"levels": {name: asdict(level) for name, level in levels(records).items()},
               "problems": {name: asdict(reference) for name, reference in references(records).items()}}
    path.write_text(json.dumps(written, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
