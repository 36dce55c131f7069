"""Records of the study of random scenes: one for each seed of a family, kept as JSON."""

from dataclasses import dataclass, field
from functools import partial

from hybrid.study.records import load_rows, save_rows

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


# save(path, stamp, records); load(path) gives (stamp, records)
save, load = save_rows, partial(load_rows, kind=Record)
