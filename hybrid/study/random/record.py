"""Records of the study of random scenes: one for each seed of a family, kept as JSON."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

from hybrid.output import atomic

# From best to worst. "missed": an error above its aim, which the program reported by a message or not ("silent").
KINDS = ("right", "missed", "silent", "failed")


@dataclass(frozen=True)
class Record:
    """A run of scene number `seed` of a family.

    values: those of the scene; errors: by name [-], empty if the run failed; kind: one of KINDS; missed: names of the
    errors above their aims; reason: why the run failed, else empty; messages: of the program; newton: iterations;
    seconds: wall time, with the start.
    """

    family: str
    seed: int
    values: dict
    kind: str
    errors: dict = field(default_factory=dict)
    missed: tuple = ()
    reason: str = ""
    messages: tuple = ()
    newton: int = 0
    seconds: float = 0.0

    @property
    def key(self):
        """(family, seed): identifies the scene."""
        return self.family, self.seed


def save(path, stamp, records):
    """Write records and the stamp of machine and versions."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = ",\n".join(json.dumps(asdict(record), ensure_ascii=False) for record in records)
    with atomic(path) as partial:   # an interrupted study keeps its records
        partial.write_text(f'{{"stamp": {json.dumps(stamp)},\n"records": [\n{rows}\n]}}\n', encoding="utf-8")


def load(path):
    """(stamp, records) of a file."""
    written = json.loads(Path(path).read_text(encoding="utf-8"))
    return written["stamp"], [Record(**{**row, "missed": tuple(row["missed"]), "messages": tuple(row["messages"])})
                              for row in written["records"]]
