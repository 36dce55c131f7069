"""Levels and targets of `accuracy` as they are fitted to records; those that ship fit the records that ship."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from hybrid.scene import accuracy
from hybrid.scene.accuracy import Settings
from hybrid.study.precision import fit_accuracy, record, report
from hybrid.study.precision.record import Record


def records():
    def swept(problem, curve, errors):
        return [Record(problem, curve, tolerance, {}, {"e": error}, (1.0,), 1, 1)
                for tolerance, error in errors.items()]

    easy = {"1e-6": 0.1, "1e-4": 0.1001, "1e-3": 0.102, "1e-2": 0.2}
    return [*swept("a", "Newton tolerance", easy),
            *swept("b", "Newton tolerance", {"1e-8": 1.0, "1e-3": 1.04, "1e-2": 1.2}),
            *swept("a", "Krylov tolerance", {"1e-5": 0.1, "1e-2": 0.1})]


def test_the_loosest_tolerance_that_leaves_every_error_alone():
    assert fit_accuracy.loosest(records(), 0.005) == 1e-8
    assert fit_accuracy.loosest(records(), 0.05) == 1e-3
    assert fit_accuracy.loosest(records(), 0.3) == 1e-3   # of both problems the stricter one
    assert fit_accuracy.loosest(records(), 0.005, "Krylov tolerance") == 1e-2
    with pytest.raises(ValueError, match="no records of the curve 'h'"):
        fit_accuracy.loosest(records(), 0.1, "h")


def test_a_failure_ends_what_is_allowed():
    failed = Record("a", "Newton tolerance", "1e-4", {}, reason="no")
    kept = [r for r in records() if r.key != failed.key] + [failed]
    assert fit_accuracy.loosest(kept, 0.05) == 1e-6
    too_tight = Record("a", "Newton tolerance", "1e-16", {}, reason="no")
    assert fit_accuracy.loosest([*records(), too_tight], 0.05) == 1e-3


def test_the_levels_that_ship_are_those_of_the_records_that_ship():
    assert accuracy.levels() == fit_accuracy.levels(record.load(report.RECORDED)[1])


def test_levels_are_read_as_they_were_written(tmp_path, monkeypatch):
    path = tmp_path / "accuracy.json"
    fit_accuracy.write(records(), path)
    assert set(json.loads(path.read_text())["levels"]) == {"draft", "standard", "reference"}
    monkeypatch.setattr(accuracy, "WRITTEN", path)
    assert accuracy.levels() == fit_accuracy.levels(records())
    assert SimpleNamespace(**vars(accuracy.levels()["draft"])).size == 2.0


def test_the_problems_that_ship_are_those_of_the_records_that_ship():
    recorded = fit_accuracy.references(record.load(report.RECORDED)[1])
    assert accuracy.problems() == recorded
    assert set(recorded) == {name for name, problem in report.PROBLEMS.items() if problem.length}


def test_records_that_differ_in_steps_or_name_a_peer_do_not_count():
    def run(curve, error, newton=1, source="", **values):
        return Record("column", curve, "x", {"cells": 4, **values}, {"stress": error}, (1.0,), newton, 4, source=source)

    kept = run("a", 0.0401), run("c", 0.0102, 3, soil={"ghost": 0.1}), run("d", 0.0101, 4)
    out = run("b", 1e-3, steps=1), run("e", 1e-4, source="another program"), run("f", 0.02, 5)
    out += (run("g", 0.001, 2, solver={"linear": "direct"}),)
    settings = fit_accuracy.references([*kept, *out])["column"].settings
    assert settings == (Settings(0.041, "a, x", 4), Settings(0.011, "c, x", 4, {"ghost": 0.1}))


def test_the_penalty_is_given_by_length():
    def pressed(penalty):
        return Record("footing", "a", f"{penalty}", {"across": 1, "body": {"penalty": penalty}},
                      {"Nc, φ = 20°": 0.001}, (1.0,), 1, 4)

    half = fit_accuracy.references([pressed(2.0), pressed(100.0)])["footing"].settings        # soft springs by chance
    assert half == (Settings(0.015, "a, 100.0", 1, body={"penalty": 100.0}),)    # smaller errors are not certain
    record = Record("platen", "a", "x", {"cell": 0.2, "penalty": 50.0}, {"force": 0.1}, (1.0,), 1, 4)
    cube = fit_accuracy.references([record])["platen"].settings
    assert cube == (Settings(0.1, "a, x", 4.0, body={"penalty": 40.0}),)


def test_the_page_states_the_errors_that_can_be_asked_for():
    page = (Path(__file__).parents[3] / "demos/precision/README.md").read_text(encoding="utf-8")
    for name, reference in accuracy.problems().items():
        errors = [settings.error for settings in reference.settings]
        assert f"| {name} | {reference.length} | {max(errors):.2g} to {min(errors):.2g} |" in page
