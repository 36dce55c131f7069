"""Every failure mode: its quick settings have the recorded outcomes, and the default never fails silently."""

import re

import pytest

from hybrid.study.failure import outcome, report, runner
from hybrid.study.failure.registry import MODES

RECORDED = {o.key: o for o in outcome.load(report.RECORDED)[1]}


@pytest.mark.parametrize("name", MODES)
def test_the_plain_method_fails_and_the_remedies_hold_as_recorded(name):
    mode = MODES[name]
    outcomes = [runner.measure(*key) for key in runner.runs([name], quick=True)]
    assert {o.key: o.kind for o in outcomes} == {o.key: RECORDED[o.key].kind for o in outcomes}
    plain, *remedies = mode.methods
    assert any(o.method == plain and o.kind in ("reported", "silent") for o in outcomes)
    for o in outcomes:
        assert o.kind != "reported" or re.search(mode.message, o.message), o.message
        assert o.method not in remedies or o.kind in ("right", "degraded", "reported"), o


@pytest.mark.parametrize("name", MODES)
def test_a_mode_is_complete(name):
    mode = MODES[name]
    assert len(mode.solve.__doc__) > 200      # explains the failure
    assert mode.title and mode.measure and mode.default in mode.methods and 0 < mode.right <= mode.wrong
    assert set(mode.settings(True)) <= set(mode.settings())
    assert {len(setting) for setting in mode.settings()} == {len(mode.parameters)}


def test_the_records_hold_every_run_and_no_silent_failure_of_a_default():
    assert set(RECORDED) == set(runner.runs(MODES))
    assert not [o for o in RECORDED.values() if o.kind == "silent" and o.method == MODES[o.case].default]
    for o in RECORDED.values():
        assert o.kind != "reported" or re.search(MODES[o.case].message, o.message), o
