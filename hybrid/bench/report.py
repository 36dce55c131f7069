"""A record of the benchmarks in Markdown: tables of all cases, and a summary in a paragraph."""

from statistics import median

from hybrid.bench import rank_model
from hybrid.bench.table import markdown, number, paragraph

SIZES = ("points", "unknowns", "entries")
SOLVERS = {"sweeps": "SSOR", "incomplete": "ILU(0)", "damped": "ILU(0), 1.5 D", "direct": "LU"}     # by the record's names
COUNTS = {"with": "preconditioner used", "in vain": "iterations of abandoned solvers",
          "copied / own": "ghost / owned unknowns", "kB a preconditioner": "kB a preconditioner application"}


def tables(record):
    """Markdown of all cases of a record, with date, commit, machine and versions."""
    stamp = record["stamp"]
    machine, versions = stamp["machine"], [f"{name} {known}" for name, known in stamp["versions"].items() if known]
    head = paragraph(f"Measured {_when(stamp)}; {machine['cpu']}, {machine['cpus']} processors, "
                     f"{stamp['numba_threads']} threads, {machine['memory_GiB']} GiB; {machine['platform']}; "
                     f"{', '.join(versions)}.")
    sections = [title + "\n\n" + section(record["cases"][name]) for name, (title, section) in SECTIONS.items()
                if name in record["cases"]]
    if rank_model.NEEDED <= set(record["cases"]):
        sections.append(rank_model.section(record))
    return "\n".join([head, *sections])


def summary(record):
    """Paragraph with a few of the times in the tables, for README.md."""
    cases, found = {name: case["rows"] for name, case in record["cases"].items()}, []
    if "scaling" in cases:
        steps = (f"{number(row['s a step'])} s with {number(row['unknowns'])}"
                 for row in (cases["scaling"][0], cases["scaling"][-1]))
        found.append(f"A plastic dynamic step takes {' and '.join(steps)} unknowns.")
    if "anchor" in cases:
        total, steps = (number(sum(row[key] for row in cases["anchor"])) for key in ("s", "steps"))
        found.append(f"{steps} steps of the drag anchor take {total} s.")
    return paragraph(" ".join([*found, f"Measured {_when(record['stamp'])}."]))


def _when(stamp):
    commit = stamp["commit"] or "unknown"
    return (f"on {stamp['date'][:10]} at commit {commit[:7]}{' with changes' * commit.endswith('+')}"
            + ", the smallest size of each case (`--quick`)" * stamp["quick"])


def _sizes(row):
    return ", ".join(f"{number(row[key])} {key}" for key in SIZES if row[key])


def _block(case):
    keys = ["s a step", "s a later step", "s a Newton iteration", "Newton", "Krylov", "tolerance", "lowest [mm]"]
    rows = [[name, *(_median(case["rows"], name, key) for key in keys)]
            for name in dict.fromkeys(row["program"] for row in case["rows"])]
    return (paragraph(f"{_sizes(case['rows'][0])}. Medians over the runs; Newton and Krylov: iterations of all steps.")
            + "\n" + markdown(["program", *keys], rows))


def _median(rows, program, key):
    values = [row[key] for row in rows if row["program"] == program and row[key] is not None]
    return median(values) if values else None


def _kernels(case):
    first, keys = case["rows"][0], ["part", "ms", "ns a point", "ns an entry"]
    return (paragraph(f"{_sizes(first)}; {number(first['contact points'])} points in contact, {number(first['flowing'])} "
                      "points that yield.")
            + "\n" + markdown(keys, [[row[key] for key in keys] for row in case["rows"]]))


def _sphere(case):
    steps, seconds, each, contact, newton = (
        number(case["rows"][0][key]) for key in ("steps", "s", "ms a step", "contact [ms a step]", "iterations"))
    return paragraph(f"{steps} steps of [rolling_sphere.toml](../rolling_sphere.toml) with {newton} Newton iterations "
                     f"take {seconds} s: {each} ms a step, {contact} ms of them for contact.")


def _anchor(case):
    stages, counts = case["rows"], ("steps", "iterations", "rejections")
    phases = [key for key in stages[0] if key not in ("stage", "s", *SIZES, *counts)]
    phases.sort(key=lambda key: -sum(row[key] for row in stages))
    names = {**{key: key for key in counts}, "s": "time [s]", **{key: f"{key} [s]" for key in phases}}
    rows = [[name, *(row[key] for row in stages), sum(row[key] for row in stages)] for key, name in names.items()]
    return (paragraph(f"[anchor.toml](../anchor.toml): {_sizes(stages[0])}; without start-up and files. Round-off "
                      "decides which increments are rejected and halved.")
            + "\n" + markdown(["", *(row["stage"] for row in stages), "all"], rows))


def _scaling(case):
    last = case["rows"][-1]
    rows = [[key, *(row[key] for row in case["rows"])] for key in last if not key.startswith("power")]
    step, krylov = (number(last[f"power of {key}"]) for key in ("s a step", "Krylov a Newton"))
    return (paragraph(f"A block of plastic soil under gravity. The time of a step grows with the power {step} of the "
                      f"unknowns, Krylov iterations with the power {krylov}, memory to "
                      f"{number(case['peak_MiB'] / 1024)} GiB. Phases are in s a step.")
            + "\n" + markdown(rows[0], rows[1:]))


def _ranks(case):
    phases = [key for key in case["rows"][0] if key not in ("scene", "way", "steps", "iterations", "krylov", "s", "gain")]
    keys = ["steps", "iterations", "krylov", "s", "gain",
            *sorted(phases, key=lambda key: -sum(row[key] for row in case["rows"]))]
    rows = [[key if key not in phases else f"{key} [s]", *(row[key] for row in case["rows"])] for key in keys]
    return (paragraph("One process, two threads and two processes (`--ranks 2`) on the machine of the stamp, one after "
                      "the other: three steps of a block of 106 000 unknowns, and the first of the anchor. Gain: time of "
                      "one process over that of the column."
                      + (f" Measured at commit {case['commit']}." if "commit" in case else ""))
            + "\n" + markdown(["", *(f"{row['scene']}, {row['way']}" for row in case["rows"])], rows))


def _exchange(case):
    rows = [{**row, "with": SOLVERS.get(row["with"], row["with"])} for row in case["rows"]]
    heads, keys = ["", *(f"{row['soil']}, {row['ranks']}" for row in rows)], list(rows[0])[2:]
    return (paragraph("Three steps of a block of sand, and of clay (ν = 0.49), both with F-bar, by ranks, which share the "
                      "cores of the machine: all are counts, from `ghost / owned unknowns` on of the process with the most. "
                      "A product K x fills the copies (ghosts) and adds them up at their owners; a vector field is one of "
                      "the grid's nodes, whose copies are filled."
                      + (f" Counted at commit {case['commit']}." if "commit" in case else ""))
            + "\n" + markdown(heads, [[COUNTS.get(key, key), *(row[key] for row in rows)] for key in keys]))


def _solvers(case):
    rows = [{**row, "solver": SOLVERS[row["solver"]], "iterations": None if row["failed"] else row["iterations"]}
            for row in case["rows"]]
    keys = ["tangent", "unknowns", "solver", "iterations", "factor [s]", "solve [s]",
            *["failed"] * any(row["failed"] for row in rows)]
    return (paragraph("Iterations to a residual of 1e-3 for one tangent with SSOR (symmetric Gauss-Seidel), ILU(0), ILU(0) "
                      "with the diagonal D times 1.5, and a direct factor LU (MUMPS). A run takes the cheapest by its own "
                      "counts, SSOR first where the tangent is symmetric.")
            + "\n" + markdown(keys, [[row[key] for key in keys] for row in rows]))


SECTIONS = {
    "block": ("## Falling block", _block), "kernels": ("## Parts of a step", _kernels),
    "sphere": ("## Rolling sphere", _sphere), "anchor": ("## Drag anchor, by phase", _anchor),
    "scaling": ("## Scaling", _scaling), "ranks": ("## Several processes", _ranks),
    "exchange": ("## Iterations and messages, by ranks", _exchange), "solvers": ("## Linear solver", _solvers),
}
