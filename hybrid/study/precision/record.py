"""Records of the study of precision: one for each run, kept as JSON. Figures and tables are made from records only."""

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from hybrid.study.records import load_rows, save_rows


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
    time of the steps of every repeat, without start-up; reason: why the run failed, else empty; source: name of another
    program, empty for this one. AMPLE was timed on another machine; Kratos, by wall time, on the same one.
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


# save(path, stamp, records); load(path) gives (stamp, records)
save, load = save_rows, partial(load_rows, kind=Record)
