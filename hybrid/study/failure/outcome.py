"""Outcome of a run that was driven towards a failure, and the file that keeps outcomes."""

import math
from dataclasses import dataclass
from functools import partial

from hybrid.study.records import load_rows, save_rows

# From best to worst. Both of the last two have failed; "reported": a message or an error of the program states it.
KINDS = ("right", "degraded", "reported", "silent")


@dataclass(frozen=True)
class Observation:
    """Result of a run. error: deviation from the reference in the mode's measure, inf if the run left nothing to
    measure; messages: warnings of the model sheet and notes of the steps."""

    error: float
    messages: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """A run of a failure mode `case`: its method, its setting (values of the parameters), which of KINDS it is, its
    error, what it reported, and its wall time [s]."""

    case: str
    method: str
    setting: tuple
    kind: str
    error: float
    message: str
    seconds: float

    @property
    def key(self):
        """(case, method, setting): identifies the run."""
        return self.case, self.method, self.setting


def classify(observation, right, wrong):
    """(kind, message) of an Observation: an error up to `right` is right, up to `wrong` degraded."""
    message = "; ".join(observation.messages)
    if math.isfinite(observation.error) and observation.error <= wrong:
        return ("right" if observation.error <= right else "degraded"), message
    return ("reported" if observation.messages else "silent"), message


# save(path, stamp, outcomes); load(path) gives (stamp, outcomes)
save, load = partial(save_rows, name="outcomes"), partial(load_rows, kind=Outcome, name="outcomes")
