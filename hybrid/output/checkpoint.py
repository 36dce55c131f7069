"""checkpoint.npz: the complete state, bit for bit, with the run and the scene that it belongs to.

A run is resumed only with the physics that it was started with. Settings may differ, and are listed: the tables output
and solver, soil.stray, and the number of steps of the last stage, so that a run can be continued beyond its end.

A checkpoint is written beside the last one and then takes its place. While a run computes, the space for the next one
is kept allocated, so that a disk filled by other files does not cost the state. Of several processes each writes and
keeps room for its own points (`hybrid.output.checkpoint_parts`).
"""

import json
import time
from pathlib import Path

from hybrid.output import checkpoint_parts as parts
from hybrid.output import partial_name, sync
from hybrid.output.checkpoint_file import (
    FIRST_GROWTH,
    FORMAT,
    GROWTH,
    IN_PARTS,
    CheckpointError,
    below,
    flattened,
    keep_room,
    read,
    reserve,
    restored,
    write,
)
from hybrid.output.history import NAME as HISTORY
from hybrid.output.scene_keys import differences, fingerprint, settings
from hybrid.runtime import comm, ranks

NAME = "checkpoint.npz"
# Attributes of a Simulation that its next step continues with; functions are called where they are saved
CONTINUED = ("increment", "backtrack", "solver_memory", "remembered")
LONGEST = 600.0     # [s] of computing between two checkpoints


class Checkpoints:
    """Observer that saves the state at the start, every `scene.output.checkpoint` outer steps or ten minutes, whichever
    comes first, and at the end (0: never).

    At the end it saves the last step that all observers before it have accepted, so that a step without all its results
    is computed again.
    """

    def __init__(self, folder, run=""):
        self.path, self.run = Path(folder) / NAME, run
        self.saved = self._accepted = None      # number of the step on disk; `_noted` of the last step

    def start(self, simulation):
        self._keys = _of_scene(simulation.scene)    # now: its files may change while it runs
        self._accepted = self._noted(simulation)
        self._written = time.monotonic()
        if simulation.state.step:
            self.saved = simulation.state.step
            if simulation.scene.output.checkpoint:
                self._reserve(GROWTH)
        elif simulation.scene.output.checkpoint:
            self._save()
            self._reserve(FIRST_GROWTH)

    def accepted(self, record, simulation):
        self._accepted = self._noted(simulation)
        every = simulation.scene.output.checkpoint
        if every and (record.step % every == 0 or comm.anywhere(time.monotonic() - self._written > LONGEST)):
            self._save()
            self._reserve(GROWTH)      # a disk without room for the next one is full now

    def finish(self, summary, simulation):
        try:
            gone = not ranks.same(self.path.is_file())      # with its folder
            if simulation.scene.output.checkpoint and (gone or self._accepted[0].step != self.saved):
                self._save()
        finally:
            self.finish_alone(summary, simulation)

    def finish_alone(self, summary, simulation):
        """The end of a run by several processes where this one does not know what the others do: what is on disk stays."""
        self._free()
        if self.saved is not None:
            summary["checkpoint_step"] = self.saved

    def _noted(self, simulation):
        """(State, numbers of its points in a run by several processes, {name: value} of the CONTINUED)."""
        extra = {name: getattr(simulation, name) for name in CONTINUED}
        return simulation.state, None, {k: v for k, v in extra.items() if v is not None}

    def _save(self):
        self._sync_history()
        state, _, extra = self._accepted
        save(self.path, state, None, extra, self.run, self._keys)
        parts.remove(self.path.parent)
        self.saved, self._written = state.step, time.monotonic()

    def _reserve(self, growth):
        """Keep room for the next checkpoint."""
        reserve(self.path, growth)

    def _free(self):
        partial_name(self.path).unlink(missing_ok=True)

    def _sync_history(self):
        history = self.path.with_name(HISTORY)
        if history.exists():
            sync(history)       # before a checkpoint that relies on its lines


class PartCheckpoints(Checkpoints):
    """The same of several processes, all of which have this observer: each writes its part, then the first one the list."""

    def __init__(self, folder, run):
        super().__init__(folder, run)
        self._partial = parts.partial(folder)
        self._last = None       # name of the part written last

    def _noted(self, simulation):
        state, _, extra = super()._noted(simulation)
        return state, simulation.model.soil.constants.number, extra

    def _save(self):
        (state, number, extra), folder = self._accepted, self.path.parent
        of_points, others = parts.arrays(state, number)
        stamp = {"format": IN_PARTS, "run": self.run, "state/step": state.step}
        name = parts.name(state.step, ranks.rank())
        ranks.together(lambda: write(folder / name, stamp | of_points, self._partial))
        names = [parts.name(state.step, rank) for rank in range(ranks.started())]

        def close():
            self._sync_history()
            write(self.path, stamp | self._keys | others | _named(extra) | {"parts": names})
            parts.remove(folder, names)

        ranks.together(lambda: ranks.rank() or close())
        self.saved, self._last, self._written = state.step, folder / name, time.monotonic()

    def _reserve(self, growth):
        def room():
            if ranks.rank() == 0:
                reserve(self.path, growth)
            size = self._last.stat().st_size if self._last else parts.size(self.path) / ranks.started()
            keep_room(self._partial, growth * size, self.path)

        ranks.together(room)

    def _free(self):
        self._partial.unlink(missing_ok=True)
        if ranks.rank() == 0:
            super()._free()


def save(path, state, scene=None, extra=None, run="", keys=None):
    """Write `state`, with the keys of the scene and the identity of the run, to `path`, completely or not at all.

    extra: dict of numbers, text or arrays that `read_extra` gives back, such as the CONTINUED ones; keys: what `_of_scene`
    has given of the scene before, instead of it.
    """
    stamp = {"format": FORMAT, "run": run, "state/time": state.time, "state/step": state.step}
    write(path, stamp | (keys or _of_scene(scene)) | flattened(state) | _named(extra))


def _of_scene(scene):
    return {"scene": json.dumps(fingerprint(scene)), "settings": json.dumps(settings(scene))}


def _named(extra):
    return {f"extra/{name}": value() if callable(value) else value for name, value in (extra or {}).items()}


def load(path, scene=None):
    """State saved in `path`, bit for bit, with the points of all parts.

    Raises CheckpointError if the file is missing or not a checkpoint, or if `scene` is given and is not the one that
    wrote it; the message lists the keys that differ.
    """
    _refuse_other(path, scene)
    arrays = read(path)
    return parts.whole(path) if "parts" in arrays else restored(arrays)


def load_share(path, scene, keeps):
    """The share of one of several processes, as `hybrid.output.checkpoint_parts.share` gives it; errors as `load`."""
    _refuse_other(path, scene)
    return parts.share(path, keeps)


def _refuse_other(path, scene):
    if scene is None:
        return
    other = differences(json.loads(str(read(path, ("scene",))["scene"])), fingerprint(scene), "checkpoint")
    if other:
        raise CheckpointError(
            f"{path} was written by another scene; these keys differ:\n{other}\nResume with the scene that wrote it "
            "(output, solver, soil.stray and the steps of the last stage may differ), or start a new run in another "
            "folder (--out), or in its place (--overwrite)")


def read_extra(path):
    """The dict that was given to `save` as `extra`."""
    return {name: value[()] for name, value in below(read(path), "extra/").items()}


def read_run(path):
    """Identity of the run that wrote `path`."""
    return str(read(path, ("run",))["run"])


def changed_settings(path, scene):
    """Text that lists the settings in which `scene` differs from the one that wrote `path`; empty if there are none."""
    return differences(json.loads(str(read(path, ("settings",))["settings"])), settings(scene), "checkpoint")
