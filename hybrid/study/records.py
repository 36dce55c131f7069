"""Files of what studies have measured: the stamp of machine and versions, and a row for each run, as JSON."""

import json
from dataclasses import asdict
from pathlib import Path

from hybrid.output import atomic


def save_rows(path, stamp, name, rows):
    """Write dataclasses `rows` under this `name`, one a line, and the stamp."""
    lines = ",\n".join(json.dumps(asdict(row), ensure_ascii=False) for row in rows)
    with atomic(path) as partial:   # an interrupted study keeps its rows
        partial.write_text(f'{{"stamp": {json.dumps(stamp)},\n"{name}": [\n{lines}\n]}}\n', encoding="utf-8")


def load_rows(path, kind, name):
    """(stamp, rows): dataclasses of this `kind` from the file that has them under this `name`; lists become tuples."""
    written = json.loads(Path(path).read_text(encoding="utf-8"))
    return written["stamp"], [kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in row.items()})
                              for row in written[name]]
