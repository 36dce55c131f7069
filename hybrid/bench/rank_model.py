"""Time of an outer step on many processes, from the record of one process and the sizes of blocks: a model, not a
measurement.

    step(N) = Σ phases(1) w(N)                                   work of the fullest block, w its share of the points
            + n (fixed + exchanges (m α + B_f/β) + R_n ρ_n)       each of n Newton iterations
            + k g(N) (calls + 3 m α + (B_p + B_s)/β + R_k ρ_k)    each of k GMRES iterations

| symbol   | meaning                                                                | from                                  |
|----------|------------------------------------------------------------------------|---------------------------------------|
| w        | share of factor and solution: times 1 + overlap / own unknowns         | blocks as cut by `hybrid.grid.blocks` |
| m        | neighbours of a block                                                  | the same                              |
| B_f      | bytes of fields a Newton iteration, in proportion to a nodal vector    | the same, case `exchange`             |
| B_p, B_s | bytes of a product, of a preconditioner: overlap of one layer of nodes | the same                              |
| R_n, R_k | reductions a Newton, a GMRES iteration                                 | case `exchange`, most of 2 to 8 ranks |
| g        | growth of iterations, N^p                                              | case `exchange`, sand                 |
| fixed    | a Newton iteration without soil                                        | case `sphere`, without its contact    |
| α, β     | latency [s] and bandwidth [B/s] of a message                           | NETWORK                               |
| ρ_k      | latency of a reduction, α log2 N                                       | NETWORK                               |
| ρ_n      | the same and N COMBINED, as every process combines N numbers in Python | measured                              |

Every process has a core of the record's kind for itself, and its memory. Work of contact is not divided. Files are left out:
each process writes its own points.
"""

from dataclasses import dataclass
from math import log2

import numpy as np

from hybrid.bench.block_sizes import sizes
from hybrid.bench.exchange import HEIGHT as COUNTED
from hybrid.bench.ranks import HEIGHT
from hybrid.bench.table import markdown, paragraph

RANKS = (1, 2, 8, 64, 1024)
LATENCY, BANDWIDTH = 2e-6, 10e9     # [s], [B/s] of a network of a cluster: assumed
CALLS = 1e-4        # [s] of Python in a GMRES iteration: assumed
COMBINED = 1.4e-6   # [s] by which a number of another process is unpacked and added
CONTACT = ("contact", "contact search")
FINER = 0.25        # power of the number of cells along a body with which Newton iterations grow (`hybrid.cost`)
ANCHOR, DRAG = (30, 10, 10), (226, 75, 74)      # cells of a block of its proportions: 24 000 points, and 10 million
NEEDED = {"exchange", "ranks", "scaling", "sphere"}     # cases of a record


@dataclass(frozen=True)
class Run:
    """A recorded run of one process. cells: (a, b, c) of soil; seconds: of a step by phase; newton, krylov: iterations a
    step."""

    name: str
    cells: tuple
    seconds: dict
    newton: float
    krylov: float

    @property
    def points(self):
        return 8 * int(np.prod(self.cells))


def step(run, ranks, record):
    """{part: seconds} of an outer step of a Run on so many `ranks`."""
    contact = sum(run.seconds.get(name, 0.0) for name in CONTACT)
    linear = run.seconds["factor"] + run.seconds["solve"]
    soil = sum(run.seconds.values()) - contact - linear
    if ranks == 1:
        return {"points": soil, "linear solver": linear, "contact": contact}
    size, counts = sizes(run.cells, ranks), exchanged(record)
    grown, share = ranks ** counts["growth"], size.share.max()
    wider = 1 + (size.overlap / np.maximum(size.own, 1)).max()
    fixed = fixed_part(record) * run.newton
    gmres, reduction = run.krylov * grown, LATENCY * log2(ranks)
    met = size.neighbours.max()
    fields = 24 * size.given_nodes.max() * counts["fields"] / BANDWIDTH + counts["exchanges"] * met * LATENCY
    moved = 8 * ((size.copies + size.given).max() + size.overlap.max()) / BANDWIDTH
    return {
        "points": soil * share + fixed, "linear solver": linear * share * wider * grown + gmres * CALLS, "contact": contact,
        "messages": run.newton * fields + gmres * (moved + 3 * met * LATENCY),
        "reductions": gmres * counts["of GMRES"] * reduction
        + run.newton * counts["of Newton"] * (reduction + ranks * COMBINED),
    }


def exchanged(record):
    """Counts of the case `exchange`, of the soil that is sand: the most of several ranks, and the power of the growth."""
    rows = [row for row in record["cases"]["exchange"]["rows"] if row["soil"] == "sand"]
    several = [row for row in rows if row["ranks"] > 1]
    relative = np.log([row["Krylov"] / rows[0]["Krylov"] for row in several])
    known = np.log([row["ranks"] for row in several])

    def most(value):
        return max(map(value, several))

    return {"growth": max(0.0, float(relative @ known / (known @ known))),
            "fields": most(lambda row: row["kB of fields a Newton iteration"] / row["kB a vector field"]),
            "exchanges": most(lambda row: row["exchanges a Newton iteration"]),
            "of GMRES": most(lambda row: row["reductions a GMRES iteration"]),
            "of Newton": most(lambda row: row["reductions a Newton iteration"])}


def fixed_part(record):
    """Seconds of a Newton iteration that do not depend on the soil."""
    (row,) = record["cases"]["sphere"]["rows"]
    return 1e-3 * (row["ms a step"] - row["contact [ms a step]"]) * row["steps"] / row["iterations"]


def runs(record):
    """The blocks of 106 000 and 300 000 unknowns as recorded, and the drag of the anchor with many more points."""
    height = 3 if record["stamp"]["quick"] else HEIGHT
    large = record["cases"]["scaling"]["rows"][-1]
    steps, power = large["Newton a step"], large["power of Krylov a Newton"]
    phases = {key.removesuffix(" [s]"): value for key, value in large.items() if key.endswith("[s]")}
    deep = round((large["points"] / 32) ** (1 / 3))
    anchor = recorded(record, "anchor", ANCHOR)
    times = np.prod(DRAG) / np.prod(ANCHOR)
    newton, gmres = times ** (FINER / 3), times ** power
    grown = {name: seconds * newton * {"solve": times * gmres}.get(name, times ** (2 / 3) if name in CONTACT else times)
             for name, seconds in anchor.seconds.items()}
    return [recorded(record, "block", (2 * height, 2 * height, height)),
            Run("block", (2 * deep, 2 * deep, deep), phases, steps, steps * large["Krylov a Newton"]),
            Run("drag", DRAG, grown, anchor.newton * newton, anchor.krylov * newton * gmres)]


def recorded(record, name, cells, way="one process"):
    """Run of a scene of the case `ranks`."""
    row = next(row for row in record["cases"]["ranks"]["rows"] if (row["scene"], row["way"]) == (name, way))
    phases = [key for key in row if key not in ("scene", "way", "steps", "iterations", "krylov", "s", "gain")]
    steps = row["steps"]
    return Run(name, cells, {key: row[key] / steps for key in phases}, row["iterations"] / steps, row["krylov"] / steps)


# ------------------------------------------------------------------ on the page


def section(record):
    """Part of the page of speed: the model's table, its assumptions, and how far it is from what was measured."""
    rows = []
    for run in runs(record):
        alone = sum(step(run, 1, record).values())
        for ranks in RANKS:
            parts = step(run, ranks, record)
            total, most = sum(parts.values()), max(parts, key=parts.get)
            rows.append([f"{run.name}, {_round(run.points)} points", ranks, total, f"{alone / total / ranks:.0%}",
                         ranks ** exchanged(record)["growth"], f"{most}, {parts[most] / total:.0%}"])
    return ("## Many processes, by a model\n\n" + paragraph(
        "Not measured. Time of an outer step from phases and iterations of one process, as recorded; blocks as the "
        "program cuts them; messages and reductions as counted above, on a network with an assumed latency of "
        f"{1e6 * LATENCY:g} µs and {1e-9 * BANDWIDTH:g} GB/s; a core and its memory for each process, of the record's "
        "kind (two threads where the record has them). GMRES iterations grow with a power of the ranks, fitted to the "
        "sand above and extrapolated beyond 8 ranks. Work of contact is not divided. Files are left out: each process "
        f"writes its own points. `reductions` take log2 N latencies, those outside GMRES also {1e6 * COMBINED:g} µs a "
        "process, as each combines the numbers of all in Python. The drag is the anchor of the record in smaller cells: "
        "work in proportion to the points, that of contact to their power 2/3, Newton iterations to the power 1/4 of the "
        "cells along the anchor, GMRES iterations as in the scaling above. Limit: the part that takes most.")
        + "\n" + markdown(["scene", "ranks", "s a step", "efficiency", "iterations, times", "limit"], rows)
        + "\n" + paragraph(_checked(record)))


def _checked(record):
    """How far the model is from the record where there is one."""
    found = []
    for name, run in (("block", runs(record)[0]), ("anchor", recorded(record, "anchor", ANCHOR))):
        measured = sum(recorded(record, name, run.cells, "two ranks").seconds.values())
        modelled = sum(step(run, 2, record).values())
        found.append(f"{modelled:.2g} s a step of the {name}, measured {measured:.2g} s ({modelled / measured - 1:+.0%})")
    return (f"Check: on two ranks the model gives {' and '.join(found)}. "
            "Unknowns of the fullest block and its copies differ from those counted on 2 to 8 ranks by "
            f"{largest_difference(record):.2g} at the most. Where points flow or touch the "
            "body, work is not in proportion to the points, and blocks with equal points are not equal.")


def largest_difference(record):
    """Largest difference of unknowns that a process owns or copies, and of kilobytes a product, from the counted ones."""
    height = 3 if record["stamp"]["quick"] else COUNTED
    found = [0.0]
    for row in record["cases"]["exchange"]["rows"]:
        if row["ranks"] > 1:
            size = sizes((2 * height, 2 * height, height), row["ranks"])
            pairs = ((size.own.max(), "own unknowns"), (size.copies.max(), "copied unknowns"),
                     (size.neighbours.max(), "neighbours"), (8e-3 * (size.copies + size.given).max(), "kB a product"))
            found += [abs(float(value) - row[key]) for value, key in pairs]
    return max(found)


def _round(points):
    return f"{points / 1e6:.2g} million" if points >= 1e6 else f"{round(points, -3):,}".replace(",", " ")
