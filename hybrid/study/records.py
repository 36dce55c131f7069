"""Runs of studies and the files of what they have measured: the stamp of machine and versions, and a row for each run, as
JSON."""

import json
from dataclasses import asdict
from pathlib import Path

from hybrid.bench.stamp import stamp as stamp_now
from hybrid.output import atomic
from hybrid.runtime.errors import SceneError


def chosen(names, known, study, kind):
    """List of `names`, all that are `known` if none; SceneError for an unknown name of this `kind` of a `study`."""
    if unknown := [name for name in names if name not in known]:
        raise SceneError(f"study {study} {unknown[0]}: no such {kind}; there are {', '.join(known)}")
    return list(names) or list(known)


def begin(out, quick, resume, load):
    """(Path of the records in the folder `out`, stamp of a study, rows that the folder has if it is to `resume`)."""
    path = Path(out) / "records.json"
    return path, {"quick": quick, **stamp_now()}, load(path)[1] if resume and path.is_file() else []


def record_runs(keys, measure, file, report, out, quick, resume, log):
    """Rows of all runs: those that the folder `out` has, and what `measure` gives of the other `keys`, kept after each; then
    figures of them. file: module that can `load` and `save` them; report: that has the `line` of one and can `draw` all."""
    path, marks, rows = begin(out, quick, resume, file.load)
    known = {row.key for row in rows}
    for key in keys:
        if key not in known:
            rows.append(measure(*key))
            file.save(path, marks, rows)
            log(report.line(rows[-1]))
    for figure in report.draw(path, out):
        log(figure)
    return rows


def save_rows(path, stamp, rows, name="records"):
    """Write dataclasses `rows` under this `name`, one a line, and the stamp."""
    lines = ",\n".join(json.dumps(asdict(row), ensure_ascii=False) for row in rows)
    with atomic(path) as partial:   # an interrupted study keeps its rows
        partial.write_text(f'{{"stamp": {json.dumps(stamp)},\n"{name}": [\n{lines}\n]}}\n', encoding="utf-8")


def load_rows(path, kind, name="records"):
    """(stamp, rows): dataclasses of this `kind` from the file that has them under this `name`; lists become tuples."""
    written = json.loads(Path(path).read_text(encoding="utf-8"))
    return written["stamp"], [kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in row.items()})
                              for row in written[name]]
