"""Running a scene with its results in a folder."""

import logging
from contextlib import ExitStack
from pathlib import Path

from hybrid import output
from hybrid.output import checkpoint
from hybrid.output.first import StopAfterStep
from hybrid.output.run_folder import RunFolder
from hybrid.runtime import ranks
from hybrid.runtime.stop_signals import stop_signals
from hybrid.scene.file import load_scene, validate
from hybrid.setup.build import build

log = logging.getLogger("hybrid")


def run(scene, out=None, overrides=(), resume=False, quiet=False, body_force=None, law=None, overwrite=False):
    """Run a Scene, or the scene file at a path, and return its Simulation.

    out               folder of the results, default out/<scene name>
    overrides         "key.path=value" texts for a scene file
    resume            continue from the checkpoint in that folder
    quiet             nothing on stderr about its progress, notes and end, which summary.json has too
    body_force, law   as in `hybrid.setup.build.build`
    overwrite         replace whatever results the folder holds; without it, `hybrid.output.run_folder` has the rule

    SIGINT, SIGTERM and SIGHUP end the run with a checkpoint and raise `hybrid.runtime.stop_signals.Stopped`, a
    KeyboardInterrupt; a second one ends the process. Raises HybridError, whose message names what to change.

    Of several processes that mpirun has started, all call this. `state` of the Simulation then has the points of each.
    """
    ranks.prepare()
    scene = load_scene(scene, overrides) if isinstance(scene, (str, Path)) else validate(scene)
    folder = Path(out) if out is not None else Path("out") / scene.name
    with stop_signals() as signals, ExitStack() as stack:
        place = ranks.in_first(lambda: stack.enter_context(RunFolder(folder, scene, resume, overwrite)))
        simulation = build(scene, body_force=body_force, law=law)
        signals.take()      # again: PETSc has its own handlers
        if resume:
            _resume(simulation, folder / checkpoint.NAME)
        with output.output_errors(folder):
            ranks.in_first(lambda: place.begin())
        observers = output.standard(folder, progress=not quiet, run=ranks.same(place and place.run))
        observers.append(StopAfterStep(signals.note() if ranks.started() > 1 else signals))
        simulation.run(observers)
    return simulation


def _resume(simulation, path):
    """Continue from the checkpoint at `path`; settings that have changed since are logged."""
    number = None
    if ranks.started() == 1:
        state = checkpoint.load(path, simulation.scene)
    else:
        state, number = ranks.together(lambda: checkpoint.load_share(path, simulation.scene, simulation.keeps()))
    if changed := checkpoint.changed_settings(path, simulation.scene):
        log.warning("continues with settings that differ from those of the checkpoint:\n%s", changed)
    simulation.resume(state, number=number, **checkpoint.read_extra(path))
