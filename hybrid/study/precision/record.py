"""Records of the study of precision: one for each run, kept as JSON. Figures and tables are made from records only."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from hybrid.output import atomic


@dataclass(frozen=True)
class RunResult:
    """Result of one run of a problem: errors [-] by name, Newton iterations, unknowns, processor time [s] of the steps."""

    errors: dict[str, float]
    newton: int
    unknowns: int
    seconds: float


@dataclass(frozen=True)
class Record:
    """A run and its repeats, of one `setting` of a `curve` of a `problem`.

    values: arguments of the problem's `solve`; errors: by name, empty if the run failed; seconds: processor
    time of the steps of every repeat, without start-up; reason: why the run failed, else empty; source: name of another program,
    empty for this one. AMPLE was timed on another machine; Kratos, by wall time, on the same one.
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
        """(problem, curve, setting): identifies the run."""
        return self.problem, self.curve, self.setting

    @property
    def failed(self):
        return bool(self.reason)

    @property
    def time(self):
        """Least processor time [s], for what disturbs a run only makes it longer; nan if there is none."""
        return min(self.seconds) if self.seconds else float("nan")

    @property
    def spread(self):
        """Range of the repeats' times over the least."""
        return float(np.ptp(self.seconds) / self.time) if len(self.seconds) > 1 else 0.0

    @property
    def work(self):
        """Newton iterations times unknowns: a cost that does not depend on the machine."""
        return self.newton * self.unknowns


def save(path, stamp, records):
    """Write records and the stamp of machine and versions."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"stamp": stamp, "records": [asdict(record) for record in records]}, indent=1)
    with atomic(path) as partial:   # an interrupted study keeps its records
        partial.write_text(text + "\n", encoding="utf-8")


def load(path):
    """(stamp, records) of a file."""
    written = json.loads(Path(path).read_text(encoding="utf-8"))
    records = [Record(**{**row, "seconds": tuple(row["seconds"])}) for row in written["records"]]
    return written["stamp"], records
