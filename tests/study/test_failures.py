"""Every case of failure: what its quick settings give is what the records that ship say, and nothing of the default
fails silently."""

import re

import pytest

from hybrid.study import cases, failure, outcome

RECORDED = {o.key: o for o in outcome.load(failure.RECORDED)[1]} if failure.RECORDED.is_file() else {}


@pytest.mark.parametrize("name", failure.CASES)
def test_the_plain_method_fails_and_the_remedy_holds_as_recorded(name):
    module = cases.case(name)
    seen = [cases.observe(*run) for run in cases.runs([name], quick=True)]
    assert {o.key: o.kind for o in seen} == {o.key: RECORDED[o.key].kind for o in seen}
    plain, *remedies = module.METHODS
    assert any(o.method == plain and o.kind in ("said", "silent") for o in seen)
    for o in seen:
        assert o.kind != "said" or re.search(module.SAYS, o.message), o.message
        assert o.method not in remedies or o.kind in ("right", "degraded", "said"), o


@pytest.mark.parametrize("name", failure.CASES)
def test_a_case_says_what_it_is(name):
    module = cases.case(name)
    assert module.__doc__ and module.TITLE and module.DEFAULT in module.METHODS and 0 < module.RIGHT <= module.WRONG
    assert set(map(tuple, module.settings(True))) <= set(map(tuple, module.settings(False)))
    assert {len(setting) for setting in module.settings(False)} == {len(module.PARAMETERS)}


def test_the_records_hold_every_run_and_no_silent_failure_of_a_default():
    assert set(RECORDED) == set(cases.runs(failure.CASES))
    assert not [o for o in RECORDED.values()
                if o.kind == "silent" and o.method == cases.case(o.case).DEFAULT]
    for o in RECORDED.values():
        assert o.kind != "said" or re.search(cases.case(o.case).SAYS, o.message), o
