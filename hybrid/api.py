"""Running a scene with its results in a folder."""

from pathlib import Path

from hybrid import output
from hybrid.output import checkpoint
from hybrid.scene.file import load_scene
from hybrid.setup.build import build


def run(scene, out=None, overrides=(), resume=False, quiet=False, body_force=None, law=None):
    """Run a Scene, or the scene file at a path, and return its Simulation.

    out               folder of the results, default out/<scene name>
    overrides         "key.path=value" texts for a scene file
    resume            continue from the checkpoint in that folder
    quiet             nothing on stderr about its progress, notes and end, which summary.json has too
    body_force, law   as in `hybrid.setup.build.build`

    Raises HybridError, whose message names what to change.
    """
    if isinstance(scene, (str, Path)):
        scene = load_scene(scene, overrides)
    folder = Path(out) if out is not None else Path("out") / scene.name
    simulation = build(scene, body_force=body_force, law=law)
    if resume:
        path = folder / checkpoint.NAME
        simulation.resume(checkpoint.load(path, simulation.scene), **checkpoint.read_extra(path))
    simulation.run(output.standard(folder, progress=not quiet))
    return simulation
