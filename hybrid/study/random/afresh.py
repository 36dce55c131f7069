"""Small problems with known answers, set up once with nothing but geometry, physics, grid and steps.

    .venv/bin/python -m hybrid.study.random.afresh [NAME ...]      # runs them and writes afresh.json beside this file

Each Problem gives its closed form or published value and the error that its few cells excuse. `demos/random/README.md`
has the table. All sizes, strengths and starts differ from those of the demos, the tests and the other studies.
"""
import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from hybrid.bench.stamp import stamp
from hybrid.output import atomic
from hybrid.runtime.errors import HybridError
from hybrid.scene import Material
from hybrid.study.failure.simulate import simulate
from hybrid.study.random.family import Run
from hybrid.study.random.fresh import clay, elastic, motion, sand

PATH = Path(__file__).with_name("afresh.json")


@dataclass(frozen=True)
class Outcome:
    """What a Problem gave: error: beyond low to high [-], None of a run that failed, whose reason is the last of the
    messages."""

    name: str
    title: str
    low: float
    high: float
    found: float | None
    error: float | None
    allowed: float
    messages: tuple
    seconds: float

PROBLEMS = {
    "strip": lambda: clay.strip(),
    "strip, small": lambda: clay.strip(half=0.031, strength=370e3, size=0.004),
    "strip, shifted": lambda: clay.strip(half=3.3),
    "circle": lambda: clay.circle(),
    "deep pipe, smooth": lambda: clay.deep_cylinder(),
    "deep pipe, rough": lambda: clay.deep_cylinder(diameter=1.1, strength=40e3, adhesion=1.0, factor=11.94),
    "half-buried pipe": lambda: clay.half_buried(),
    "plate anchor": lambda: clay.plate_anchor(),
    "ball": lambda: clay.ball(),
    "ball rolls": lambda: motion.ride("sphere", 20, 0.5, 33, 0.4, 0.3),
    "ball slides": lambda: motion.ride("sphere", 65, 0.05, 211, 0.11, 0.2, steps=40),
    "drum rolls": lambda: motion.ride("cylinder", 45, 0.9, 118, 0.55, 0.5),
    "block slides": lambda: motion.ride("block", 30, 0.3, 61, 0.4, 0.35),
    "block sticks": lambda: motion.ride("block", 20, 0.5, 290, 0.4, 0.35),
    "block on clay": lambda: motion.on_bank("block", 17.0, 0.11, clay.clay(130e3, 1850.0)),
    "block on sand": lambda: motion.on_bank("block", 13.0, 0.08, Material(relative_density=85.0)),
    "drum on clay": lambda: motion.on_bank("cylinder", 12.0, 0.55, clay.clay(130e3, 1850.0)),
    "bounce": lambda: motion.bounce(),
    "pendulum": lambda: motion.pendulum(),
    "oedometer": lambda: elastic.oedometer(),
    "hertz": lambda: elastic.hertz(),
    "heave": lambda: elastic.heave(),
    "wall": lambda: sand.wall(),
    "wall, quasi-static": lambda: sand.wall(inertia=False),
    "square": lambda: clay.square(),
    "pin": lambda: clay.pin(),
    "block lands": lambda: clay.lands(),
    "light block": lambda: clay.lies(150.0, 1.0),
    "buoyant pipe": lambda: clay.buoyant(),
    "light pipe": lambda: clay.floats(),
    "wall drawn back": lambda: sand.retreat(),
    "bank, 26°": lambda: sand.bank(26.0),
    "bank, 44°": lambda: sand.bank(44.0),
    "bank, 44°, gravity at once": lambda: sand.bank(44.0, geostatic=False),
    "slab, 27°": lambda: sand.slab(27.0),
    "slab, 33°": lambda: sand.slab(33.0),
    "slab, 38°": lambda: sand.slab(38.0),
    "column, low": lambda: sand.column(0.7),
    "column, high": lambda: sand.column(1.8),
    "column, round": lambda: sand.round_column(),
    "sphere dropped": lambda: sand.dropped(),
    "plate anchor, 6 cells": lambda: clay.plate_anchor(across=6),
    "plate anchor, 18 cells": lambda: clay.plate_anchor(across=18),
    "plate anchor, thin": lambda: clay.plate_anchor(thickness=1 / 12),
    "square, 4 cells": lambda: clay.square(across=4),
    "square, 6 cells": lambda: clay.square(across=6),
    "wall with a foot, 4 cells": lambda: sand.footed_wall(4),
    "wall with a foot, 8 cells": lambda: sand.footed_wall(8),
    "wall with a foot, 16 cells": lambda: sand.footed_wall(16),
    "column, round, 9 cells": lambda: sand.round_column(cells=9),
}


def measure(name):
    """Outcome of the Problem of this name."""
    problem, begin = PROBLEMS[name](), perf_counter()
    try:
        simulation, records, messages = simulate(problem.scene)
        found = float(problem.measure(Run(simulation, records)))
    except HybridError as failure:
        return Outcome(name, problem.title, problem.low, problem.high, None, None, problem.allowed, (str(failure),),
                       round(perf_counter() - begin, 1))
    error = (found - np.clip(found, problem.low, problem.high)) / (problem.high or 1.0)
    return Outcome(name, problem.title, problem.low, problem.high, found, float(error), problem.allowed,
                   tuple(dict.fromkeys(messages)),
                   round(perf_counter() - begin, 1))


def table(rows):
    """Lines of a Markdown table of recorded outcomes, dicts."""
    lines = ["| problem | exact | found | beyond it | messages | time |", "|---|---|---|---|---|---|"]
    for row in rows:
        exact = f"{row['low']:.4g}" + (f" to {row['high']:.4g}" if row["high"] != row["low"] else "")
        found, error = ("stops", "-") if row["found"] is None else (f"{row['found']:.4g}", f"{100 * row['error']:+.2g} %")
        lines.append(f"| {row['name']}: {row['title']} | {exact} | {found} | {error} | {len(row['messages']) or '-'} | "
                     f"{row['seconds']:.0f} s |")
    return lines


def recorded():
    """Rows of the record, dicts."""
    return json.loads(PATH.read_text(encoding="utf-8"))["problems"]


def main(names):
    """Run the problems of these names, all if none, and keep what they gave in PATH."""
    for name in names or PROBLEMS:
        outcome = asdict(measure(name))
        kept = {row["name"]: row for row in recorded()} if PATH.is_file() else {}
        kept[name] = outcome
        print(json.dumps(kept[name], ensure_ascii=False), flush=True)
        rows = ",\n".join(json.dumps(kept[each], ensure_ascii=False) for each in PROBLEMS if each in kept)
        with atomic(PATH) as partial:
            partial.write_text(f'{{"stamp": {json.dumps(stamp())},\n"problems": [\n{rows}\n]}}\n', encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
    print("\n".join(table(recorded())))
