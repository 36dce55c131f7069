"""Observers of a run: they read the simulation after each accepted step and write files, and never change it.

An observer has three methods, called by the simulation:

    start(simulation)              before the first step of this session, also when a run is resumed
    accepted(record, simulation)   after every accepted outer step; record is a `hybrid.output.record.Record`
    finish(summary, simulation)    once at the end; summary["outcome"] is completed, failed or interrupted
"""

import os
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic(path):
    """Give a temporary name beside `path` and move it into place only if the block succeeds.

    A reader therefore finds the old file or the new one, also after an interrupted run, and never a part of one.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def standard(folder, progress=True):
    """The observers of `hybrid run`, in the order in which they must be called; they write all files of a run.

    folder: of the results (made if missing). progress: tell on stderr how far the run is.
    """
    from hybrid.output.checkpoint import Checkpoints
    from hybrid.output.history import History
    from hybrid.output.pictures import Pictures
    from hybrid.output.progress import Progress
    from hybrid.output.summary import Summary
    from hybrid.output.vtk import Frames

    # Summary and Pictures read history.csv, so History comes first; Progress last, to time the writing too.
    observers = [History(folder), Frames(folder), Checkpoints(folder), Pictures(folder), Summary(folder)]
    return observers + [Progress(folder=folder)] * progress
