"""checkpoint.npz: the complete state, bit for bit, with the scene it belongs to.

A run is resumed only with the scene that wrote the checkpoint. Keys that do not change the physics may differ: the
tables output and solver, soil.stray, and the number of steps of the last stage, so that a run can be continued
beyond its end.
"""

import dataclasses
import hashlib
import json
import os
import zipfile
from pathlib import Path

import numpy as np

from hybrid.output import atomic
from hybrid.runtime.errors import HybridError
from hybrid.scene import Scene
from hybrid.scene.defaults import resolve
from hybrid.state import BodyState, ContactHistory, Ground, PointConstants, Points, Population, State

NESTED = {"points": Points, "constants": PointConstants, "behind": Population}  # fields that are dataclasses themselves
NAME = "checkpoint.npz"
FORMAT = 3
CONTINUED = ("increment", "solver_memory")    # attributes of a Simulation that its next step continues with


class CheckpointError(HybridError):
    """A checkpoint cannot be read, or belongs to another scene."""


class Checkpoints:
    """Observer that saves the state every `scene.output.checkpoint` outer steps and at the end (0: never)."""

    def __init__(self, folder):
        self.path = Path(folder) / NAME
        self.saved = None

    def start(self, simulation):
        self.saved = simulation.state.step

    def accepted(self, record, simulation):
        every = simulation.scene.output.checkpoint
        if every and record.step % every == 0:
            self._save(simulation)

    def finish(self, summary, simulation):
        if simulation.scene.output.checkpoint and simulation.state.step != self.saved:
            self._save(simulation)

    def _save(self, simulation):
        extra = {name: getattr(simulation, name, None) for name in CONTINUED}
        save(self.path, simulation.state, simulation.scene, {k: v for k, v in extra.items() if v is not None})
        self.saved = simulation.state.step


def save(path, state, scene=None, extra=None):
    """Write `state` (and the scene's fingerprint) to `path`, completely or not at all.

    extra: dict of numbers, text or arrays that `read_extra` gives back, such as the CONTINUED ones.
    """
    arrays = {"format": FORMAT, "scene": json.dumps(fingerprint(scene)), "state/time": state.time}
    arrays["state/step"] = state.step
    arrays.update(_fields(state.points, "points"))
    if state.ground is not None:
        arrays.update(_fields(state.ground, "ground"))
    for name, items in (("bodies", state.bodies), ("contacts", state.contacts)):
        arrays[f"{name}/count"] = len(items)
        for i, item in enumerate(items):
            arrays.update(_fields(item, f"{name}/{i}"))
    arrays.update({f"work/{name}": value for name, value in state.work.items()})
    arrays.update({f"extra/{name}": value for name, value in (extra or {}).items()})
    with atomic(path) as partial, open(partial, "wb") as file:
        np.savez(file, **arrays)
        file.flush()
        os.fsync(file.fileno())


def load(path, scene=None):
    """State saved in `path`, bit for bit.

    Raises CheckpointError if the file is missing or not a checkpoint, or if `scene` is given and is not the one that
    wrote it; the message lists the keys that differ.
    """
    arrays = _read(path)
    if scene is not None:
        _refuse_other_scene(path, json.loads(str(arrays["scene"])), fingerprint(scene))
    return State(
        time=float(arrays["state/time"]),
        step=int(arrays["state/step"]),
        points=_restored(Points, arrays, "points"),
        bodies=_restored_list(BodyState, arrays, "bodies"),
        contacts=_restored_list(ContactHistory, arrays, "contacts"),
        work={name: float(value) for name, value in _below(arrays, "work/").items()},
        ground=_restored(Ground, arrays, "ground") if _below(arrays, "ground/") else None,
    )


def read_extra(path):
    """The dict that was given to `save` as `extra`."""
    return {name: value[()] for name, value in _below(_read(path), "extra/").items()}


def fingerprint(scene):
    """Keys of a scene that determine the physics of its run: {"soil.material.young": text}; geometry by content, keys
    left out as they are decided."""
    if isinstance(scene, Scene):
        scene, _ = resolve(scene)
    flat = {}
    _flatten("", _plain(scene), flat)
    last = len(getattr(scene, "stages", ())) - 1
    ignored = ("output.", "solver.", "soil.stray", f"stages.{last}.steps")
    return {key: value for key, value in sorted(flat.items()) if not key.startswith(ignored)}


def _refuse_other_scene(path, saved, wanted):
    keys = [key for key in sorted(saved.keys() | wanted.keys()) if saved.get(key) != wanted.get(key)]
    if not keys:
        return
    shown = [f"  {k}: checkpoint {saved.get(k, 'none')}, scene {wanted.get(k, 'none')}" for k in keys[:8]]
    shown += [f"  ... and {len(keys) - 8} more"] if len(keys) > 8 else []
    raise CheckpointError(
        f"{path} was written by another scene; these keys differ:\n" + "\n".join(shown)
        + "\nResume with the scene that wrote it (output, solver, soil.stray and the steps of the last stage may "
        "differ), or start a new run in another folder."
    )


def _read(path):
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
    except FileNotFoundError:
        raise CheckpointError(f"{path} does not exist: there is no run to resume in that folder") from None
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise CheckpointError(f"{path} is not a readable checkpoint ({error}): start a new run") from error
    if int(arrays.get("format", -1)) != FORMAT:
        found = arrays.get("format")
        raise CheckpointError(f"{path} has format {found}, this version reads {FORMAT}: start a new run")
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
        flat[prefix] = _content(item) if prefix.endswith(".geometry") else repr(item)
        return
    for key, value in item:
        _flatten(f"{prefix}.{key}" if prefix else str(key), value, flat)


def _content(path):
    path = Path(path)
    if not path.is_file():
        return path.name
    return f"{path.name} (sha256 {hashlib.sha256(path.read_bytes()).hexdigest()[:12]})"
