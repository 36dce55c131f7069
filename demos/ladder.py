"""The verification ladder of the soil: six rungs from a column to a footing, each with its closed form.

    columns        two columns under their own weight, Lambert's W: order of GIMP, failure of standard MPM
    cantilever     bent down by most of its length in plane strain, against elastica and a beam of Hencky fibres
    manufactured   orders in space and time, of points at rest, shaken and drifting; a swirl in three dimensions
    wave           a pulse in a bar: speed, shape, energy under four schemes
    dimensions     column, cantilever and bar again in three dimensions: the same numbers at what cost
    footing        Prandtl's bearing capacity at φ = 0, 20°, 30°, with and without F-bar

    .venv/bin/python demos/ladder.py                     all, coarse: two minutes
    .venv/bin/python demos/ladder.py columns wave        some
    .venv/bin/python demos/ladder.py --fine footing      a refinement more of each

Tables go to the terminal, a figure of each rung to out/ladder/. What is asserted here at a glance is asserted with its
rates in tests/analytic/test_{column,compaction,cantilever,manufactured,wave,footing}.py.
"""

import sys
from pathlib import Path

import ladder_figures as figures
import ladder_wave as wave
import numpy as np

from hybrid.runtime.errors import StepError
from hybrid.study.precision.problems import cantilever, footing, manufactured
from hybrid.study.precision.problems import column as columns

OUT = Path("out/ladder")
STANDARD = {"basis": "mpm", "domain": "none", "transfer": "increments"}
METHODS = {"GIMP": {}, "GIMP, rigid domains": {"domain": "none"}, "standard MPM": STANDARD}


def table(title, headings, rows):
    """Print rows of texts under headings, in columns as wide as they need."""
    rows = [headings, *([str(cell) for cell in row] for row in rows)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(headings))]
    print(f"\n{title}")
    for row in rows:
        print("  " + "  ".join(cell.rjust(width) for cell, width in zip(row, widths)))


def order(errors, sizes):
    """Observed order over the last refinement, as text."""
    return f"{np.log(errors[-2] / errors[-1]) / np.log(sizes[-2] / sizes[-1]):.2f}"


def run_columns(fine):
    """Errors of stress and height against the number of cells."""
    cells, curves, rows = (8, 16, 32, 64, 128, 256)[:5 + fine], {}, []
    cases = {"50 m, 1 MPa": columns.STIFF, "50 m, 10 kPa": columns.SOFT, "0.8 m, 283 Pa": columns.SELF_WEIGHT}
    for case, column in cases.items():
        for method, soil in METHODS.items():
            found = [columns.settle(column, n, **soil) for n in cells]
            sizes, errors = column.length / np.array(cells), np.array([(s.stress_error, s.height_error) for s in found])
            curves[case, method] = np.array(cells), errors
            rows.append([case, method, f"{found[-1].height:.6f} m", f"{column.height():.6f} m",
                         *(f"{e:.1e} ({order(errors[:, i], sizes)})" for i, e in enumerate(errors[-1])),
                         found[-1].unknowns, f"{found[-1].seconds:.1f} s"])
    table(f"columns of {cells[-1]} cells: errors, and orders over the last halving",
          ["column", "method", "height", "exact", "stress", "height", "unknowns", "time"], rows)
    profiles = {case: (column, {m: columns.settle(column, 32, **METHODS[m]) for m in ("GIMP", "standard MPM")})
                for case, column in cases.items()}
    print(figures.columns(OUT / "columns.png", curves, profiles))
    for case in cases:
        good, bad = curves[case, "GIMP"][1][-1], curves[case, "standard MPM"][1][-1]
        assert (good < 1e-3).all() and bad[0] > 20 * good[0], case


def run_cantilever(fine):
    """Tip against cell size for two heights; the bent shape."""
    sizes, rows, curves = (1.0, 0.5, 0.25, 0.125, 0.0625)[:4 + fine], [], {}
    elastica = np.array(cantilever.elastica())
    cases = {"2 points an axis": {}, "3 points an axis": {"points_per_axis": 3},
             "standard MPM, 3 points": {"points_per_axis": 3, **STANDARD},
             "2 points, half the height": {"height": 0.5}}
    shown = None
    for case, options in cases.items():
        beam = np.array(cantilever.hencky_beam(options.get("height", 1.0)))
        here = [s * options.get("height", 1.0) for s in sizes[1:]] if "standard" in case else [
            s * options.get("height", 1.0) for s in sizes]
        found = [cantilever.bend(size, **options) for size in here]
        tips = np.array([(b.drop[-1], b.shortening[-1]) for b in found])
        curves[case] = np.array(here), np.abs(tips / beam - 1)
        shown = shown or found[1]
        for size, tip, b in zip(here, tips, found):
            relative = [f"{100 * e:+.2f} %" for wanted in (elastica, beam) for e in tip / wanted - 1]
            rows.append([case, f"{size:g} m", f"{tip[0]:.4f}", f"{tip[1]:.4f}", *relative, b.iterations, b.unknowns,
                         f"{b.seconds:.1f} s"])
    table("cantilever: drop and shortening [m] of the tip, and relative to elastica and beam of Hencky fibres",
          ["case", "cells", "drop", "short", "elastica", "", "beam", "", "its", "unknowns", "time"], rows)
    print(figures.cantilever(OUT / "cantilever.png", curves, shown, elastica, cantilever.hencky_beam()))
    assert (curves["2 points an axis"][1][-1] < (0.003, 0.011)).all()
    assert curves["standard MPM, 3 points"][1][-1, 1] > 0.05


def run_manufactured(fine):
    """Errors against cell size and step."""
    cells, rows, space = (8, 16, 32, 64, 128)[:4 + fine], [], {}
    waves = {"at rest": manufactured.Wave(1e-4), "shaken": manufactured.Wave(0.05),
             "drifting": manufactured.Wave(0.05, 5.0)}
    for case, solution in waves.items():
        for method in ("GIMP", "standard MPM"):
            found = [manufactured.vibrate(solution, n, 2 * n, **METHODS[method]) for n in cells]
            errors, sizes = np.array([(o.displacement, o.stress) for o in found]), manufactured.LENGTH / np.array(cells)
            space[case, method] = sizes, errors
            rows.append([case, method, f"{found[-1].crossed:.1f}",
                         *(f"{e:.1e} ({order(errors[:, i], sizes)})" for i, e in enumerate(errors[-1])),
                         found[-1].unknowns, f"{found[-1].seconds:.1f} s"])
    for method in ("GIMP", "standard MPM"):
        found = [manufactured.vibrate(manufactured.Swirl(0.1), n, 2 * n, solver={"tolerance": 1e-7}, **METHODS[method])
                 for n in (4, 8, 12)[:2 + fine]]
        errors, sizes = np.array([(o.displacement, o.stress) for o in found]), 1 / np.array([4, 8, 12])[:2 + fine]
        space["swirl", method] = sizes, errors
        rows.append(["swirl, 3-D", method, f"{found[-1].crossed:.1f}",
                     *(f"{e:.1e} ({order(errors[:, i], sizes)})" for i, e in enumerate(errors[-1])),
                     found[-1].unknowns, f"{found[-1].seconds:.1f} s"])
    table("manufactured solutions, finest grid: errors, and orders over the last refinement",
          ["points", "method", "nodes crossed", "displacement", "stress", "unknowns", "time"], rows)
    counts, steps = np.array((12, 24, 48)), {}
    for name in ("Newmark (1/4, 1/2)", "generalised α, ρ∞ = 0.8", "Newmark (0.5625, 1)"):
        errors = manufactured.in_time(waves["at rest"], 64, counts, 384, wave.SCHEMES[name])
        steps[name] = waves["at rest"].duration / counts, errors
    table("the same in time, 64 cells, against a step of 1/384",
          ["scheme", *(f"{n} steps" for n in counts), "order"],
          [[name, *(f"{e:.1e}" for e in errors), order(errors, 1 / counts)] for name, (_, errors) in steps.items()])
    print(figures.manufactured(OUT / "manufactured.png", space, steps))
    good, bad = (space["shaken", m][1][-1] for m in ("GIMP", "standard MPM"))
    assert (good < 0.01).all() and bad[1] > 10 * good[1]


def run_wave(fine):
    """Speed, shape and energy."""
    cells, rows, rides = (36, 72, 144)[:2 + fine], [], {}
    for name, scheme in wave.SCHEMES.items():
        for n in cells:
            found = rides[name] = wave.ride(n, scheme=scheme)
            rows.append([name, n, f"{100 * (found.speed() - 1):+.2f} %", f"{100 * found.missed():.1f} %",
                         f"{100 * (found.energy[-1] - 1):+.1f} %", found.unknowns, f"{found.seconds:.1f} s"])
    table("pulse in a bar, there and back: speed, shape that is wrong, energy",
          ["scheme", "cells", "speed", "shape", "energy", "unknowns", "time"], rows)
    print(figures.wave(OUT / "wave.png", rides, wave))
    assert abs(rides["Newmark (1/4, 1/2)"].speed() - 1) < 0.02


def run_dimensions(fine):
    """The same scenes with collapsed axes and without."""
    runs = {"column, 32 cells": (lambda full: columns.settle(columns.SOFT, 32, full=full), lambda s: s.height),
            "cantilever, 0.5 m": (lambda full: cantilever.bend(0.5 / (1 + fine), full=full), lambda b: b.drop[-1]),
            "bar, 36 cells": (lambda full: wave.ride(36, full=full), lambda r: r.energy[-1])}
    rows, ratios = [], {}
    for case, (run, number) in runs.items():
        flat, full = run(False), run(True)
        difference = abs(number(full) / number(flat) - 1)
        ratios[case] = full.unknowns / flat.unknowns, full.seconds / flat.seconds
        rows.append([case, f"{number(flat):.8f}", f"{difference:.0e}", flat.unknowns, full.unknowns,
                     f"{flat.seconds:.2f} s", f"{full.seconds:.2f} s"])
        assert difference < 2e-5 and ratios[case][0] > 3, case
    table("collapsed axes against three dimensions, two cells wide",
          ["case", "number", "difference", "unknowns", "3-D", "time", "3-D"], rows)
    print(figures.dimensions(OUT / "dimensions.png", ratios))


def run_footing(fine):
    """Bearing capacity against settlement and cell size."""
    across, rows, curves = (2, 4, 8)[:2 + fine], [], {}
    for angle in (0, 20, 30):
        for name, soil in footing.CURES.items():
            for n in across:
                try:
                    found = curves[angle, name, n] = footing.press(angle, n, **soil)
                except StepError as failure:
                    print(f"φ = {angle}°, {name}, {n} cells: {failure}")
                    continue
                rows.append([f"{angle}°", name, n, f"{found.factor[-1]:.3f}",
                             f"{100 * (found.factor[-1] / footing.prandtl(angle) - 1):+.1f} %", found.iterations,
                             found.unknowns, f"{found.seconds:.1f} s"])
    table("strip footing: Nc = F / (B c); " + ", ".join(f"{footing.prandtl(a):.4f} for φ = {a}°" for a in (0, 20, 30)),
          ["φ", "soil", "cells in B/2", "Nc", "over Prandtl's", "its", "unknowns", "time"], rows)
    print(figures.footing(OUT / "footing.png", curves, footing))
    for angle, limit in ((0, 0.03), (20, 0.04), (30, 0.07)):
        assert abs(curves[angle, "default", across[-1]].factor[-1] / footing.prandtl(angle) - 1) < limit


RUNGS = {name.removeprefix("run_"): rung for name, rung in globals().copy().items() if name.startswith("run_")}

if __name__ == "__main__":
    chosen = [name for name in sys.argv[1:] if name != "--fine"] or list(RUNGS)
    if unknown := set(chosen) - set(RUNGS):
        raise SystemExit(f"no rung {', '.join(unknown)}; there are {', '.join(RUNGS)}")
    for name in chosen:
        RUNGS[name]("--fine" in sys.argv)
