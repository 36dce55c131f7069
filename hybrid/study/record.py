"""What a study measured: one record for each run, kept as JSON. Figures and tables are made from records only."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Found:
    """What a run of a problem gives: errors [-] by name, Newton iterations, unknowns, wall time [s] of its steps."""

    errors: dict[str, float]
    newton: int
    unknowns: int
    seconds: float


@dataclass(frozen=True)
class Record:
    """A run, repeated: `setting` of a `curve` of a `problem`.

    values: what the setting stands for, as given to the problem; errors: by name, empty where it failed; seconds: wall
    time of the steps of every repeat, without start-up; reason: why it failed, empty where it did not. A peer's record
    names its `source`: AMPLE had another machine, Kratos had this one.
    """

    problem: str
    curve: str
    setting: str
    values: dict = field(default_factory=dict)
    errors: dict = field(default_factory=dict)
    seconds: tuple = ()
    newton: int = 0
    unknowns: int = 0
    reason: str = ""
    source: str = ""

    @property
    def key(self):
        """Which run this is."""
        return self.problem, self.curve, self.setting

    @property
    def failed(self):
        return bool(self.reason)

    @property
    def time(self):
        """Median wall time [s], nan where none was taken."""
        return float(np.median(self.seconds)) if self.seconds else float("nan")

    @property
    def spread(self):
        """Half of the range of the repeats over their median."""
        return float(np.ptp(self.seconds) / 2 / self.time) if len(self.seconds) > 1 else 0.0

    @property
    def work(self):
        """Newton iterations times unknowns: a cost that no machine changes."""
        return self.newton * self.unknowns


def save(path, stamp, records):
    """Write records and what they were measured with."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"stamp": stamp, "records": [asdict(record) for record in records]}, indent=1)
    part = path.with_suffix(".part")    # an interrupted study keeps what it had
    part.write_text(text + "\n", encoding="utf-8")
    part.replace(path)


def load(path):
    """(stamp, records) of a file."""
    written = json.loads(Path(path).read_text(encoding="utf-8"))
    records = [Record(**{**row, "seconds": tuple(row["seconds"])}) for row in written["records"]]
    return written["stamp"], records
