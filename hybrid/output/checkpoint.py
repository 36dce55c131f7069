"""checkpoint.npz: the complete state, bit for bit, with the run and the scene that it belongs to.

A run is resumed only with the physics that it was started with. Settings may differ, and are listed: the tables output
and solver, soil.stray, and the number of steps of the last stage, so that a run can be continued beyond its end.

A checkpoint is written beside the last one and then takes its place. While a run computes, the space for the next one
is kept allocated, so that a disk filled by other files does not cost the state.
"""

import dataclasses
import errno
import hashlib
import json
import os
import time
import zipfile
from pathlib import Path

import numpy as np

from hybrid.body.geometry_text import files_of
from hybrid.output import partial_name, sync
from hybrid.output.history import NAME as HISTORY
from hybrid.runtime.errors import GeometryError, HybridError
from hybrid.scene import Scene
from hybrid.scene.defaults import resolve
from hybrid.state import (
    BodyState,
    ContactHistory,
    Ground,
    JointState,
    PairHistory,
    PointConstants,
    Points,
    Population,
    State,
)

NESTED = {"points": Points, "constants": PointConstants, "behind": Population}  # fields that are dataclasses themselves
NAME = "checkpoint.npz"
FORMAT = 5
CONTINUED = ("increment", "solver_memory")    # attributes of a Simulation that its next step continues with
LONGEST = 600.0     # [s] of computing between two checkpoints
# By which a checkpoint may be larger than the last, where contact begins or points are split, and than that of the start,
# which has no history yet: 2.2 for a box that slides; and bytes.
GROWTH, FIRST_GROWTH, MORE = 1.25, 2.5, 65536


class CheckpointError(HybridError):
    """A checkpoint cannot be read, or belongs to another run or scene."""


class Checkpoints:
    """Observer that saves the state at the start, every `scene.output.checkpoint` outer steps or ten minutes, whichever
    comes first, and at the end (0: never).

    At the end it saves the last step that all observers before it have accepted, so that a step without all its results
    is computed again.
    """

    def __init__(self, folder, run=""):
        self.path, self.run = Path(folder) / NAME, run
        self.saved = self._accepted = None      # number of the step on disk; State and extra of the last step

    def start(self, simulation):
        self._note(simulation)
        self._written = time.monotonic()
        if simulation.state.step:
            self.saved = simulation.state.step
            if simulation.scene.output.checkpoint:
                reserve(self.path)
        elif simulation.scene.output.checkpoint:
            self._save(simulation)
            reserve(self.path, FIRST_GROWTH)

    def accepted(self, record, simulation):
        self._note(simulation)
        every = simulation.scene.output.checkpoint
        if every and (record.step % every == 0 or time.monotonic() - self._written > LONGEST):
            self._save(simulation)
            reserve(self.path)      # a disk without room for the next one is full now

    def finish(self, summary, simulation):
        try:
            if simulation.scene.output.checkpoint and self._accepted[0].step != self.saved:
                self._save(simulation)
        finally:
            partial_name(self.path).unlink(missing_ok=True)
            if self.saved is not None:
                summary["checkpoint_step"] = self.saved

    def _note(self, simulation):
        extra = {name: getattr(simulation, name, None) for name in CONTINUED}
        self._accepted = simulation.state, {k: v for k, v in extra.items() if v is not None}

    def _save(self, simulation):
        history = self.path.with_name(HISTORY)
        if history.exists():
            sync(history)       # before a checkpoint that relies on its lines
        state, extra = self._accepted
        save(self.path, state, simulation.scene, extra, self.run)
        self.saved, self._written = state.step, time.monotonic()


def save(path, state, scene=None, extra=None, run=""):
    """Write `state`, with the keys of the scene and the identity of the run, to `path`, completely or not at all.

    extra: dict of numbers, text or arrays that `read_extra` gives back, such as the CONTINUED ones.
    """
    arrays = {"format": FORMAT, "run": run, "state/time": state.time, "state/step": state.step}
    arrays["scene"], arrays["settings"] = json.dumps(fingerprint(scene)), json.dumps(settings(scene))
    arrays.update(_fields(state.points, "points"))
    if state.ground is not None:
        arrays.update(_fields(state.ground, "ground"))
    if state.joints is not None:
        arrays.update(_fields(state.joints, "joints"))
    for name, items in (("bodies", state.bodies), ("contacts", state.contacts), ("pairs", state.pairs)):
        arrays[f"{name}/count"] = len(items)
        for i, item in enumerate(items):
            arrays.update(_fields(item, f"{name}/{i}"))
    arrays.update({f"work/{name}": value for name, value in state.work.items()})
    arrays.update({f"extra/{name}": value for name, value in (extra or {}).items()})
    path = Path(path)
    partial = partial_name(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(os.open(partial, os.O_RDWR | os.O_CREAT, 0o666), "r+b") as file:  # into the space kept by `reserve`
        _write(file, arrays)
        file.truncate()
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)
    sync(path.parent)


def _write(file, arrays):
    """What np.savez writes. That leaves its archive open where the disk is full, to fail again later."""
    with zipfile.ZipFile(file, "w") as archive:
        for name, value in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, np.asanyarray(value), allow_pickle=False)


def reserve(path, growth=GROWTH):
    """Allocate the space of the next checkpoint, which may be `growth` times as large as the one at `path`, where the
    file system can do so. Raises OSError where there is no room."""
    partial = partial_name(path)
    try:
        with open(partial, "wb") as file:
            os.posix_fallocate(file.fileno(), 0, int(growth * path.stat().st_size) + MORE)
    except OSError as error:
        partial.unlink(missing_ok=True)
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise OSError(error.errno, error.strerror, os.fspath(path)) from None


def load(path, scene=None):
    """State saved in `path`, bit for bit.

    Raises CheckpointError if the file is missing or not a checkpoint, or if `scene` is given and is not the one that
    wrote it; the message lists the keys that differ.
    """
    arrays = _read(path)
    if scene is not None:
        other = differences(json.loads(str(arrays["scene"])), fingerprint(scene), "checkpoint")
        if other:
            raise CheckpointError(
                f"{path} was written by another scene; these keys differ:\n{other}\nResume with the scene that wrote it "
                "(output, solver, soil.stray and the steps of the last stage may differ), or start a new run in another "
                "folder (--out), or in its place (--overwrite)")
    return State(
        time=float(arrays["state/time"]),
        step=int(arrays["state/step"]),
        points=_restored(Points, arrays, "points"),
        bodies=_restored_list(BodyState, arrays, "bodies"),
        contacts=_restored_list(ContactHistory, arrays, "contacts"),
        work={name: float(value) for name, value in _below(arrays, "work/").items()},
        ground=_restored(Ground, arrays, "ground") if _below(arrays, "ground/") else None,
        joints=_restored(JointState, arrays, "joints") if _below(arrays, "joints/") else None,
        pairs=_restored_list(PairHistory, arrays, "pairs"),
    )


def read_extra(path):
    """The dict that was given to `save` as `extra`."""
    return {name: value[()] for name, value in _below(_read(path), "extra/").items()}


def read_run(path):
    """Identity of the run that wrote `path`."""
    return str(_read(path, ("format", "run"))["run"])


def changed_settings(path, scene):
    """Text that lists the settings in which `scene` differs from the one that wrote `path`; empty if there are none."""
    return differences(json.loads(str(_read(path, ("format", "settings"))["settings"])), settings(scene), "checkpoint")


def fingerprint(scene):
    """Keys of a scene that determine the physics of its run: {"soil.material.young": text}; geometry by content, keys
    left out as they are decided."""
    return {key: value for key, value in _keys(scene).items() if not key.startswith(_setting_keys(scene))}


def settings(scene):
    """The other keys of a scene, with which a run may be continued differently: {"output.every": text}."""
    return {key: value for key, value in _keys(scene).items() if key.startswith(_setting_keys(scene))}


def differences(saved, wanted, name):
    """Lines that list the keys in which two dicts of texts differ; `name`: what the first one belongs to."""
    keys = [key for key in sorted(saved.keys() | wanted.keys()) if saved.get(key) != wanted.get(key)]
    shown = [f"  {k}: {name} {saved.get(k, 'none')}, scene {wanted.get(k, 'none')}" for k in keys[:8]]
    return "\n".join(shown + ([f"  ... and {len(keys) - 8} more"] if len(keys) > 8 else []))


def _keys(scene):
    if isinstance(scene, Scene):
        scene, _ = resolve(scene)
    flat = {}
    _flatten("", _plain(scene), flat)
    return dict(sorted(flat.items()))


def _setting_keys(scene):
    return "output.", "solver.", "soil.stray", f"stages.{len(getattr(scene, 'stages', ())) - 1}.steps"


def _read(path, names=()):
    """Arrays of a checkpoint, all of them or those named."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in names or file.files if name in file.files}
    except FileNotFoundError:
        raise CheckpointError(f"{path} does not exist: there is no run to resume in that folder") from None
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
        raise CheckpointError(f"{path} is not a readable checkpoint ({error}): start a new run, with --overwrite"
                              ) from error
    if int(arrays.get("format", -1)) != FORMAT:
        found = arrays.get("format")
        raise CheckpointError(f"{path} has format {found}, this version reads {FORMAT}: start a new run, with "
                              "--overwrite")
    return arrays


def _fields(item, prefix):
    flat = {}
    for field in dataclasses.fields(item):
        name, value = f"{prefix}/{field.name}", getattr(item, field.name)
        if dataclasses.is_dataclass(value):
            flat |= _fields(value, name)
        elif value is not None:
            flat[name] = value
    return flat


def _restored(kind, arrays, prefix):
    own = _below(arrays, prefix + "/")
    inner = {name: NESTED[name] for name in NESTED if _below(own, name + "/")}
    values = {name: value for name, value in own.items() if "/" not in name}
    return kind(**values, **{name: _restored(part, own, name) for name, part in inner.items()})


def _restored_list(kind, arrays, prefix):
    return [_restored(kind, arrays, f"{prefix}/{i}") for i in range(int(arrays[f"{prefix}/count"]))]


def _below(arrays, prefix):
    return {key[len(prefix):]: value for key, value in arrays.items() if key.startswith(prefix)}


def _plain(item):
    if dataclasses.is_dataclass(item):
        return {f.name: getattr(item, f.name) for f in dataclasses.fields(item)}
    return vars(item) if hasattr(item, "__dict__") and not isinstance(item, Path) else item


def _flatten(prefix, item, flat):
    item = _plain(item)
    if isinstance(item, dict):
        item = item.items()
    elif isinstance(item, (list, tuple)):
        item = enumerate(item)
    else:
        flat[prefix] = _content(item) if isinstance(item, Path) else repr(item)
        return
    for key, value in item:
        _flatten(f"{prefix}.{key}" if prefix else str(key), value, flat)


def _content(path):
    """Name and digest of a file; of a geometry with the files that it reads, as gmsh gets them."""
    path = Path(path)
    if not path.is_file():
        return path.name
    try:
        files = files_of(path) if path.suffix == ".geo" else {path.name: path.read_bytes()}
    except GeometryError:       # of a file that was never meshed
        files = {path.name: path.read_bytes()}
    return f"{path.name} (sha256 {hashlib.sha256(b'|'.join(files.values())).hexdigest()[:12]})"
