"""A checkpoint of several processes: each writes its own points, the first one a list of these parts; none has all points.

| file                     | has                                                                              |
|--------------------------|----------------------------------------------------------------------------------|
| checkpoint_000010_r2.npz | points and contacts of process 2 after step 10, with their numbers in the run     |
| checkpoint.npz           | the names of the parts, and all else: bodies, works, scene                        |

The list is written when all parts are on disk, and parts that it does not name are then removed. So a kill at any moment
leaves a whole checkpoint, this one or the one before. Any number of processes may go on from it, and from that of one
process: each reads part by part, array by array, and keeps its own points.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from hybrid.output.checkpoint_file import CheckpointError, flattened, opened, restored
from hybrid.runtime import ranks
from hybrid.soil.parcels import behind_together, named, placed, together, without_numbers
from hybrid.state import PointConstants, Population

OF_POINTS = re.compile(r"number|points/|contacts/\d+/|ground/(constants/|rows|behind/)")     # names of arrays of a part
BEHIND = "ground/behind/constants/number"


def name(step, rank):
    """Name of the part of a process after a step."""
    return f"checkpoint_{step:06d}_r{rank}.npz"


def partial(folder):
    """Temporary name of the part of this process, the same for all steps, for which space is kept."""
    return Path(folder) / f".checkpoint_r{ranks.rank()}.npz.partial"


def remove(folder, names=()):
    """Delete all parts but those with `names`."""
    for path in Path(folder).glob("checkpoint_*_r*.npz"):
        if path.name not in names:
            path.unlink(missing_ok=True)


def size(path):
    """Bytes of the checkpoint at `path` with its parts."""
    return sum(each.stat().st_size for each in [path, *_parts(path)])


def arrays(state, number):
    """({name: array} of the part of this process, {name: array} of all else) for a State on points with `number` (n,)."""
    ground = state.ground and replace(state.ground, constants=replace(state.ground.constants, number=None))
    every = {"number": number, **flattened(replace(state, contacts=named(state.contacts, number), ground=ground))}
    return tuple({key: value for key, value in every.items() if bool(OF_POINTS.match(key)) is mine}
                 for mine in (True, False))


def share(path, keeps):
    """(State, numbers (n,) of its points, increasing) of a checkpoint at `path`, with the points that `keeps` chooses by
    their numbers (m,) in the run, (m,) bool. Contacts are named (`hybrid.soil.parcels`), points left behind have numbers
    too."""
    with opened(path) as file:
        others = {key: file[key] for key in file.files if not OF_POINTS.match(key)}
    found = [restored_part({**others, **_rows(each, keeps, others)}) for each in _parts(path) or [Path(path)]]
    here, contacts = together([(population, state.contacts) for state, population in found])
    state, ground = found[0][0], found[0][0].ground
    if ground is not None:
        behind = behind_together([one.ground.behind for one, _ in found])
        ground = replace(ground, constants=here.constants, rows=here.rows, behind=behind)
    return replace(state, points=here.points, contacts=contacts, ground=ground), here.constants.number


def whole(path):
    """The State of a run by one process, from all parts."""
    state, number = share(path, lambda numbers: np.ones(len(numbers), bool))
    ground = state.ground and replace(state.ground, constants=replace(state.ground.constants, number=None),
                                      behind=without_numbers(state.ground.behind))
    return replace(state, contacts=placed(state.contacts, number), ground=ground)


def _parts(path):
    """Paths of the parts that a checkpoint lists, none of one by one process."""
    with opened(path) as file:
        return [Path(path).with_name(str(each)) for each in file["parts"]] if "parts" in file.files else []


def restored_part(arrays):
    """(State, Population of its points) of the arrays of a part and all else."""
    state, number = restored(arrays), arrays["number"]
    n = len(number)
    if state.ground is None:    # the scene gives constants
        return state, Population(state.points, PointConstants(np.zeros((n, 0)), np.zeros((n, 0)), np.zeros(n), np.zeros(n),
                                                              number=number), np.zeros((n, 0)))
    return state, Population(state.points, replace(state.ground.constants, number=number), state.ground.rows)


def _rows(path, keeps, others):
    """{name: rows of points that `keeps` chooses} of the arrays of points in a file, with their numbers."""
    with opened(path) as file:
        for key in ("run", "state/step"):
            if file[key] != others[key]:
                raise CheckpointError(f"{path} belongs to another checkpoint ({key} {file[key]}, listed {others[key]}): "
                                      "start a new run, with --overwrite")
        names = [key for key in file.files if OF_POINTS.match(key)]
        number = file["number"] if "number" in names else np.arange(len(file["points/position"]))
        kept = dict.fromkeys(("points/", "ground/constants/", "ground/rows"), keeps(number))
        found = {"number": number[kept["points/"]]}
        if "ground/behind/rows" in names:
            behind = file[BEHIND] if BEHIND in names else len(number) + np.arange(len(file["ground/behind/rows"]))
            kept["ground/behind/"] = keeps(behind)
            found[BEHIND] = behind[kept["ground/behind/"]]
        kept |= {key.removesuffix("point"): keeps(file[key]) for key in names if re.fullmatch(r"contacts/\d+/point", key)}
        return {key: file[key][kept[OF_POINTS.match(key)[0]]] for key in names if key not in ("number", BEHIND)} | found
