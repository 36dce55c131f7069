"""A drag anchor is lowered onto loose sand, settles for a second and is dragged for 0.6 s, until its fluke digs in.

The scene is demos/anchor.toml with a shorter drag: nothing is set. No exact solution is known: errors are differences
from a fine run of the same kind with cells of 0.2 m and Δt = 0.02 s. Its path of the centre of mass and its line tension
are kept in anchor_reference.json (`write_reference`). An error much smaller than the difference between that run and a
finer one shows only that two runs of this program agree.
"""

import json
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np

from hybrid.bench.timed_steps import newton_iterations, sizes, timed_steps
from hybrid.runtime.data import DEMOS
from hybrid.scene import Solver
from hybrid.scene.file import load_scene
from hybrid.setup.build import build
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import RunResult
from hybrid.study.precision.settings import PUBLISHED

REFERENCE = Path(__file__).with_name("anchor_reference.json")
SETTLE, DRAG, SPEED = 1.0, 0.6, 0.5     # [s], [s], [m/s] of the far end
FINE = {    # [m] around the path, by size of the cells; all hold z = 0
    0.4: ((-0.8, 3.6), (0.0, 1.6), (-1.2, 0.8)), 0.3: ((-0.6, 3.9), (0.0, 1.5), (-1.5, 0.9)),
    0.25: ((-0.75, 3.75), (0.0, 1.5), (-1.5, 0.75)), 0.2: ((-0.6, 3.8), (0.0, 1.4), (-1.4, 0.8))}
LOOSE = {"tolerance": 1e-3, "tangent_tolerance": 0.1}


def curves(quick):
    """Cell sizes; methods on coarse cells; tolerances and time step at 0.4 m. quick: none, because one run takes too
    long."""
    if quick:
        return {}
    return {
        "default": _cells((0.4, 0.3, 0.25, 0.2)),
        PUBLISHED: _cells((0.4, 0.3), method="published", body={"penalty": 50.0}),
        "neither F-bar nor ghost": _cells((0.4, 0.3), soil={"fbar": False, "ghost": 0.0}),
        "no ghost penalty": _cells((0.4, 0.3, 0.25), soil={"ghost": 0.0}),
        "Newton tolerance": [(f"{t:g}", {"solver": {"tolerance": t}}) for t in (1e-2, 1e-3, 1e-4)],
        "looser solver": _cells((0.4, 0.3), solver=LOOSE),
        "time step": [(f"Δt = {step:g} s", {"step": step}) for step in (0.08, 0.02)],
        "standard MPM": _cells((0.4, 0.3), soil={"basis": "mpm"})}


def _cells(sizes, **values):
    return [(f"h = {h:g} m", {"h": h, **values}) for h in sizes]


def scene(h=0.4, step=0.04, drag=DRAG, method="default", solver=(), soil=(), body=()):
    """Scene with cells of `h` [m], steps of `step` [s] and a drag of `drag` [s].

    method: "default" or "published"; solver, soil, body: values of these tables, those of soil and body beside
    demos/anchor.toml.
    """
    given = load_scene(DEMOS / "anchor.toml")
    axes = {name: replace(getattr(given.grid, name), size=h, fine=fine) for name, fine in zip("xyz", FINE[h])}
    stages = [replace(stage, steps=round(time / step)) for stage, time in zip(given.stages, (SETTLE, drag))]
    return replace(given, method=method, grid=replace(given.grid, **axes), soil=replace(given.soil, **dict(soil)),
                   bodies=(replace(given.bodies[0], **dict(body)),), time=replace(given.time, step=step),
                   stages=tuple(stages), solver=Solver(**dict(solver)))


def dragged(**values):
    """(simulation, records, processor time [s] of each step) of a `scene`; raises StepError if a step fails."""
    simulation = build(scene(**values))
    return simulation, *timed_steps(simulation, clock=process_time)


def course(records):
    """Time (n,) [s] since the pull began, position (n, 3) [m] of the centre of mass, line tension (n,) [N] of the
    drag."""
    pulled = [record for record in records if record.stage == "drag"]
    begun = max(record.time for record in records if record.stage == "settle")
    bodies = [record.bodies[0] for record in pulled]
    return (np.array([record.time - begun for record in pulled]), np.array([body.position for body in bodies]),
            np.array([body.line_tension for body in bodies]))


def write_reference():
    """Run the reference, which takes some minutes, and write its file."""
    time, place, tension = course(dragged(h=0.2, step=0.02)[1])
    kept = {"time [s]": np.round(time, 6).tolist(), "place [m]": np.round(place, 6).tolist(),
            "tension [N]": np.round(tension, 2).tolist()}
    REFERENCE.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


def missed(time, place, tension, reference):
    """Errors of a course against the `reference` file, interpolated linearly between its times."""
    known, way, pull = (np.array(reference[key]) for key in ("time [s]", "place [m]", "tension [N]"))
    exact = np.stack([np.interp(time, known, along) for along in way.T], axis=1)
    distance = np.sqrt(np.mean(np.sum((place - exact) ** 2, axis=1)))
    mean = np.mean(pull[known <= time[-1] + 1e-9])
    return {"trajectory": float(distance / (SPEED * time[-1])), "tension": float(abs(np.mean(tension) / mean - 1))}


def solve(**values):
    """RunResult of a drag; `values` are those of `scene`. Raises StepError if a step fails."""
    simulation, records, seconds = dragged(**values)
    reference = json.loads(REFERENCE.read_text(encoding="utf-8"))
    return RunResult(missed(*course(records), reference), newton_iterations(records), sizes(simulation)["unknowns"],
                     sum(seconds))


PROBLEM = Problem(
    title="short anchor drag",
    errors={"trajectory": "rms distance of the anchor from the reference over the way of the line's far end [-]",
            "tension": "|T/T_ref - 1| of the mean line tension over the drag [-]"},
    shown=(PUBLISHED, "neither F-bar nor ghost", "standard MPM", "Newton tolerance", "looser solver"),
    chosen=("time step",), curves=curves, solve=solve)
