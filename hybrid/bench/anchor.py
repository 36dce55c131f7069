"""The drag anchor of demos/anchor.toml: steps, iterations, and the time of each phase."""

from hybrid.bench.timed_steps import sizes, timed_steps, warm
from hybrid.runtime.data import DEMOS
from hybrid.scene.file import load_scene
from hybrid.setup.build import build

COARSE = [f"grid.{axis}.{key}" for axis, fine in (("x", "[-0.8, 3.6]"), ("y", "[0.0, 1.6]"), ("z", "[-1.2, 0.8]"))
          for key in ("size=0.4", f"fine={fine}")]
QUICK = [*COARSE, "stage.0.steps=4", "stage.1.steps=2"]


def run(options):
    """A row for each stage: steps, iterations, and seconds of each phase; no files are written."""
    warm()
    simulation = build(load_scene(DEMOS / "anchor.toml", QUICK if options.quick else []))
    size = sizes(simulation)
    records, seconds = timed_steps(simulation)
    phases = sorted({phase for record in records for phase in record.seconds})
    rows = []
    for stage in dict.fromkeys(record.stage for record in records):
        own = [(record, taken) for record, taken in zip(records, seconds) if record.stage == stage]
        rows.append({
            "stage": stage, "steps": len(own), "iterations": sum(record.iterations for record, _ in own),
            "rejections": sum(record.rejections for record, _ in own), "s": sum(taken for _, taken in own),
            **{phase: sum(record.seconds.get(phase, 0.0) for record, _ in own) for phase in phases}, **size})
    return rows
