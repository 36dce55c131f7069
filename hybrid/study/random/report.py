"""Figures and tables of the study of random scenes, made from a file of records only.

RECORDED is the file that ships with the program.
"""

from pathlib import Path

import numpy as np

from hybrid.output.scatter import Cloud, scatter
from hybrid.study.random.record import load
from hybrid.study.random.registry import FAMILIES

RECORDED = Path(__file__).with_name("random.json")
ACROSS = {"sphere": ("slope", "mu"), "cylinder": ("slope", "mu"), "slab": ("slope", "mu")}     # abscissa and colour
LABELS = {"slope": "slope θ [°]", "mu": "friction coefficient μ [-]"}


def draw(path, out):
    """Draw the figure of a file of records in the folder `out`; returns [its path], [] without rides."""
    marks, records = load(path)
    clouds = [cloud(name, error, own) for name in ACROSS for error in ("distance", "spin")
              if (own := [r for r in records if r.family == name])]
    mark = f"commit {str(marks['commit'])[:8]}, numpy {marks['versions']['numpy']}"
    return [scatter(Path(out) / "rides.png", clouds, LABELS["mu"], mark)] if clouds else []


def cloud(name, error, records):
    """Cloud of one error [%] of the records of a family over their slopes, coloured by μ."""
    done = [r for r in records if r.kind != "failed"]
    across, colour = ACROSS[name]
    return Cloud(
        FAMILIES[name].title, LABELS[across], f"error of {error} [%]", [r.values[across] for r in done],
        [100 * r.errors[error] for r in done], [r.values[colour] for r in done],
        [r.values[across] for r in records if r.kind == "failed"], 100 * FAMILIES[name].aims[error])


def table(records):
    """Rows of {family, error, aim, number of scenes, largest, root mean square, number above the aim, failed}."""
    rows = []
    for name in dict.fromkeys(r.family for r in records):
        own = [r for r in records if r.family == name]
        for error, aim in FAMILIES[name].aims.items():
            values = np.array([r.errors[error] for r in own if r.kind != "failed"])
            rows.append({
                "family": name, "error of": error, "aim": aim, "scenes": len(own),
                "lowest": values.min() if len(values) else None, "highest": values.max() if len(values) else None,
                "rms": float(np.sqrt(np.mean(values**2))) if len(values) else None,
                "above the aim": sum(error in r.missed for r in own), "failed": sum(r.kind == "failed" for r in own),
                "silent": sum(r.kind == "silent" and error in r.missed for r in own)})
    return rows


def listing():
    """Rows of {name, title, number of scenes} of all families."""
    return [{"name": name, "title": family.title, "scenes": family.seeds} for name, family in FAMILIES.items()]


def line(r):
    """Text of a record: its errors, or why it failed."""
    run = f"{r.family}, seed {r.seed}: {r.kind}"
    if r.kind == "failed":
        return f"{run}; {r.reason}"
    return f"{run}, " + ", ".join(_quoted(*error, FAMILIES[r.family]) for error in r.errors.items()) + (
        f"; {r.newton} iterations" + "".join(f"; {text}" for text in r.messages))


def _quoted(name, value, family):
    """Text of a value: an error that has an aim in percent, others, such as a cone's q/s_u, as they are."""
    return f"{name} {value:+.2%}" if name in family.aims else f"{name} {value:.3g}"
