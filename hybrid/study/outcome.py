"""What became of a run that was driven towards a failure, and the file that keeps it."""

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path

from hybrid.output import atomic

# From best to worst. "said": wrong or not there, and the program told so by itself.
KINDS = ("right", "degraded", "said", "silent")


@dataclass(frozen=True)
class Seen:
    """What a run shows. error: of what is known of it, in the case's measure, inf where nothing is left of it;
    told: what the program said by itself that bears on the failure."""

    error: float
    told: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """A run of a `case`: its method, its setting (the parameters' values), which of KINDS, error and message."""

    case: str
    method: str
    setting: tuple
    kind: str
    error: float
    message: str
    seconds: float

    @property
    def key(self):
        """Which run this is."""
        return self.case, self.method, self.setting


def judged(seen, right, wrong):
    """(kind, message) of what was Seen: an error up to `right` is right, up to `wrong` degraded."""
    message = "; ".join(seen.told)
    if math.isfinite(seen.error) and seen.error <= wrong:
        return ("right" if seen.error <= right else "degraded"), message
    return ("said" if seen.told else "silent"), message


def save(path, stamp, outcomes):
    """Write outcomes and what they were seen with."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"stamp": stamp, "outcomes": [asdict(outcome) for outcome in outcomes]}, indent=1)
    with atomic(path) as partial:   # an interrupted study keeps what it had
        partial.write_text(text + "\n", encoding="utf-8")


def load(path):
    """(stamp, outcomes) of a file."""
    written = json.loads(Path(path).read_text(encoding="utf-8"))
    return written["stamp"], [Outcome(**{**row, "setting": tuple(row["setting"])}) for row in written["outcomes"]]
