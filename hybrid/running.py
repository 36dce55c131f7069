"""Running a scene with its results in a folder."""

from pathlib import Path

from hybrid import output
from hybrid.build import build
from hybrid.output import checkpoint
from hybrid.scene_file import load_scene


def run(scene, out=None, overrides=(), resume=False, quiet=False, law=None):
    """Run a Scene, or the scene file at a path, and return its Simulation.

    out: folder of results, default out/<scene name>; overrides: "key.path=value" texts for a scene file; resume:
    continue from the folder's checkpoint; quiet: no progress line; law: makes that of a scene whose law is "user".
    Raises HybridError with what to change.
    """
    if isinstance(scene, (str, Path)):
        scene = load_scene(scene, overrides)
    folder = Path(out) if out is not None else Path("out") / scene.name
    simulation = build(scene, law=law)
    if resume:
        simulation.state = checkpoint.load(folder / checkpoint.NAME, simulation.scene)
        simulation.increment = checkpoint.read_extra(folder / checkpoint.NAME).get("increment")
    simulation.run(output.standard(folder, progress=not quiet))
    return simulation
