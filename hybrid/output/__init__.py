"""Observers of a run: they read the simulation after each accepted step and write files; never the reverse.

An observer has three methods, called by the time loop:

    start(simulation)              before the first step of this session, also when a run is resumed
    accepted(record, simulation)   after every accepted outer step; record is a `hybrid.output.record.Record`
    finish(summary, simulation)    once, at the end, failed or interrupted: summary["outcome"] tells which
"""

import os
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic(path):
    """Give a temporary name beside `path` and move it into place only if the block succeeds.

    A reader, or a run that is cut short, therefore sees the old file or the new one and never half of either.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def standard(folder, progress=True, announce=False):
    """The observers of `hybrid run`, in the order they must be called: everything a scene's folder holds.

    folder: where files go (made if missing). progress: show the live line when stderr is a terminal.
    announce: print one closing line even when it is not.
    """
    from hybrid.output.checkpoint import Checkpoints
    from hybrid.output.history import History
    from hybrid.output.pictures import Pictures
    from hybrid.output.progress import Progress
    from hybrid.output.summary import Summary
    from hybrid.output.vtk import Frames

    # Summary and Pictures read history.csv, so History comes first; Progress last, to time the writing too.
    observers = [History(folder), Frames(folder), Checkpoints(folder), Pictures(folder), Summary(folder)]
    return observers + [Progress(announce=announce, live=progress)]
