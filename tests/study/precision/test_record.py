"""Records of the study of precision: their times, and their file."""

from hybrid.study.precision import record
from hybrid.study.precision.record import Record


def test_time_is_the_least_and_spread_the_range_over_it():
    r = Record("p", "a", "1", {}, {"e": 0.1}, (1.0, 4.0, 2.0), 1, 1)
    assert (r.time, r.spread, r.work) == (1.0, 3.0, 1)
    assert Record("p", "a", "1", {}, {"e": 0.1}, (1.0,), 1, 1).spread == 0.0


def test_records_are_read_as_they_were_written(tmp_path):
    records = [Record("p", "a", "1", {"cells": 4}, {"e": 0.1}, (1.0, 2.0), 3, 4), Record("p", "a", "2", reason="no")]
    record.save(tmp_path / "new" / "records.json", {"commit": None}, records)
    assert record.load(tmp_path / "new" / "records.json") == ({"commit": None}, records)
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["records.json"]
