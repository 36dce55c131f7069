"""The archive of arrays that a checkpoint is: written completely or not at all, into space that is kept for it.

State, and the dataclasses in it, are flattened to arrays with names such as points/position and contacts/0/anchor.
"""

import dataclasses
import errno
import os
import zipfile
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from hybrid.output import partial_name, sync
from hybrid.runtime.errors import HybridError
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

FORMAT = 9
IN_PARTS = 10       # of a first file that lists the parts (`hybrid.output.checkpoint_parts`), and of these
NESTED = {"points": Points, "constants": PointConstants, "behind": Population}  # fields that are dataclasses themselves
# By which a checkpoint may be larger than the last, where contact begins or points are split, and than that of the start,
# which has no history yet: 2.2 for a box that slides; and bytes.
GROWTH, FIRST_GROWTH, MORE = 1.25, 2.5, 65536


class CheckpointError(HybridError):
    """A checkpoint cannot be read, or belongs to another run or scene."""


# ------------------------------------------------------------------ files


def write(path, arrays, partial=None):
    """Write `arrays` by name to `path`, by way of the name `partial`, and wait until they are on disk."""
    path = Path(path)
    partial = partial or partial_name(path)
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
    keep_room(partial_name(path), growth * path.stat().st_size, path)


def keep_room(partial, size, path):
    """Allocate so many bytes and MORE at `partial` for the file that becomes `path`. Raises OSError where there is no
    room."""
    try:
        with open(partial, "wb") as file:
            os.posix_fallocate(file.fileno(), 0, int(size) + MORE)
    except OSError as error:
        partial.unlink(missing_ok=True)
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise OSError(error.errno, error.strerror, os.fspath(path)) from None


def read(path, names=()):
    """Arrays of a checkpoint, all of them or those named."""
    with opened(path) as arrays:
        return {name: arrays[name] for name in names or arrays.files if name in arrays.files}


@contextmanager
def opened(path):
    """Context with the arrays at `path`, each of which is read when it is asked for. Raises CheckpointError for a file
    that is missing, broken or of another format."""
    try:
        with np.load(path, allow_pickle=False) as file:
            found = int(file["format"]) if "format" in file.files else None
            if found not in (FORMAT, IN_PARTS):
                raise CheckpointError(f"{path} has format {found}, this version reads {FORMAT}: start a new run, with "
                                      "--overwrite")
            yield file
    except FileNotFoundError:
        raise CheckpointError(f"{path} does not exist: there is no run to resume in that folder") from None
    except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
        raise CheckpointError(f"{path} is not a readable checkpoint ({error}): start a new run, with --overwrite"
                              ) from error


# ------------------------------------------------------------------ states


def flattened(state):
    """{name: array or number} of a State."""
    arrays = {"state/time": state.time, "state/step": state.step, "state/increment": state.increment,
              **_fields(state.points, "points")}
    if state.ground is not None:
        arrays.update(_fields(state.ground, "ground"))
    if state.joints is not None:
        arrays.update(_fields(state.joints, "joints"))
    for name, items in (("bodies", state.bodies), ("contacts", state.contacts), ("pairs", state.pairs)):
        arrays[f"{name}/count"] = len(items)
        for i, item in enumerate(items):
            arrays.update(_fields(item, f"{name}/{i}"))
    arrays.update({f"work/{name}": value for name, value in state.work.items()})
    return arrays


def restored(arrays):
    """The State that was `flattened`; other arrays are left aside."""
    return State(
        time=float(arrays["state/time"]),
        step=int(arrays["state/step"]),
        points=_restored(Points, arrays, "points"),
        bodies=_restored_list(BodyState, arrays, "bodies"),
        contacts=_restored_list(ContactHistory, arrays, "contacts"),
        work={name: float(value) for name, value in below(arrays, "work/").items()},
        ground=_restored(Ground, arrays, "ground") if below(arrays, "ground/") else None,
        joints=_restored(JointState, arrays, "joints") if below(arrays, "joints/") else None,
        pairs=_restored_list(PairHistory, arrays, "pairs"),
        increment=float(arrays["state/increment"]),
    )


def below(arrays, prefix):
    """{name after the prefix: array} of those whose names begin with it."""
    return {key[len(prefix):]: value for key, value in arrays.items() if key.startswith(prefix)}


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
    own = below(arrays, prefix + "/")
    inner = {name: NESTED[name] for name in NESTED if below(own, name + "/")}
    values = {name: value if value.ndim else value.item() for name, value in own.items() if "/" not in name}
    return kind(**values, **{name: _restored(part, own, name) for name, part in inner.items()})


def _restored_list(kind, arrays, prefix):
    return [_restored(kind, arrays, f"{prefix}/{i}") for i in range(int(arrays[f"{prefix}/count"]))]
