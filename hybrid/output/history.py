"""history.csv: one line for each accepted outer step, on disk as soon as the step is accepted."""

import csv
from pathlib import Path

import numpy as np

from hybrid.output import atomic

NAME = "history.csv"


class History:
    """Observer that appends `Record.row()` to history.csv in `folder`.

    A new run replaces an older file. A resumed run keeps the lines up to the step that it resumes from and appends to
    them, under the same header.
    """

    def __init__(self, folder):
        self.path = Path(folder) / NAME
        self.columns = []

    def start(self, simulation):
        step = simulation.state.step
        rows = [row for row in _complete_rows(self.path) if int(row["step"]) <= step] if step else []
        self.columns = list(rows[0]) if rows else []
        self._replace(rows)

    def accepted(self, record, simulation):
        row = record.row()
        if not row.keys() <= set(self.columns):
            # A phase or energy that is new in this step: earlier lines get an empty cell.
            rows = _complete_rows(self.path)
            self.columns += [name for name in row if name not in self.columns]
            self._replace(rows)
        with open(self.path, "a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, self.columns).writerow(row)

    def finish(self, summary, simulation):
        """Nothing to do: every line is already on disk."""

    def _replace(self, rows):
        with atomic(self.path) as partial, open(partial, "w", newline="", encoding="utf-8") as file:
            if self.columns:
                writer = csv.DictWriter(file, self.columns)
                writer.writeheader()
                writer.writerows(rows)


def _complete_rows(path):
    """Lines of the file as dicts of text; without lines that a crash left incomplete."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8", errors="replace") as file:
        lines = [line for line in file if line.endswith("\n")]
    return [row for row in csv.DictReader(lines)
            if None not in row.values() and None not in row and row.get("step", "").isdecimal()]


def count_steps(folder):
    """Number of accepted steps that history.csv of a folder has."""
    return len(_complete_rows(Path(folder) / NAME))


def read_history(folder):
    """Columns of history.csv as arrays of shape (steps,): text for `stage`, else floats (nan where empty).

    Raises FileNotFoundError when the folder holds no history. Empty dict when no step has been accepted.
    """
    path = Path(folder) / NAME
    if not path.exists():
        raise FileNotFoundError(f"no {NAME} in {path.parent}: give the folder of results of a run")
    rows = _complete_rows(path)
    if not rows:
        return {}
    columns = {}
    for name in rows[0]:
        texts = [row[name] for row in rows]
        values = texts if name == "stage" else [float(text or "nan") for text in texts]
        columns[name] = np.array(values)
    return columns


def body_names(history):
    """Names of the bodies in a history read by `read_history`, in the order of its columns."""
    ending = "_tension_N"
    return [name[: -len(ending)] for name in history if name.endswith(ending)]


def force_column(history, quantity):
    """Name of the column of a force: that of the whole body where part of it is modelled."""
    whole = f"{quantity}_whole_N"
    return whole if whole in history else f"{quantity}_N"
