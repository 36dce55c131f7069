"""Numbers on demos/failure/README.md are those of the record."""

import re

import pytest

from hybrid.runtime.data import DEMOS
from hybrid.study.failure import outcome, report
from hybrid.study.failure.registry import MODES

RECORDED = {o.key: o for o in outcome.load(report.RECORDED)[1]}
PAGE = " ".join((DEMOS / "failure" / "README.md").read_text(encoding="utf-8").split())


def errors(case, method, *settings):
    """Errors [%] of a method, of a case, at all of its settings or some."""
    chosen = settings or [setting for setting, in MODES[case].settings()]
    return [100.0 * RECORDED[case, method, (setting,)].error for setting in chosen]


@pytest.mark.parametrize("text, found", [
    ("footing is {} % too strong with two cells under half its width, {} % with eight, {} to {} % with the defaults",
     lambda: errors("flow_locking", "no F-bar", 2, 8) + sorted(errors("flow_locking", "F-bar"))[::4]),
    ("with springs of ε_T/ε_N = 1e-3 it is {} to {} %",
     lambda: sorted(errors("stick_threshold", "ε_T/ε_N = 1e-3", 0.99, 1.0, 1.01))[::2]),
    ("spacings of corners thick is {} to {} % too large or too small, depending on its position, of 1.5 spacings {} %",
     lambda: errors("thin_wall", "corners (published)", 4.6, 2.6, 1.5)),
    (r"Newmark \(0.5625, 1\) at most {} and {} % of the oscillation remain",
     lambda: [max(errors("force_oscillation", method)) for method in ("generalised-alpha, ρ∞ = 0", "Newmark (0.5625, 1)")]),
    ("its velocity is correct to {} %, with Newmark's undamped scheme to {} %",
     lambda: [max(errors("light_body", method, 3.0, 10.0, 100.0, 1000.0, 1e5))
              for method in ("Newmark (0.5625, 1)", "Newmark")]),
    ("weight is applied in one step converges to 1e-6 and is {} % short",
     lambda: errors("plastic_step", "halved on failure", 1)),
    ("It keeps {} % of its speed with ten steps in the contact time T_c, {} % with three",
     lambda: [100.0 - error for error in errors("bounce_step", "generalised-alpha, ρ∞ = 0", 0.1, 0.3)]),
])
def test_a_number_is_that_of_the_record(text, found):
    """To the digits that it is given with."""
    written = re.search(text.replace("{}", r"([\d.]+)"), PAGE)
    assert written, text
    for number, error in zip(written.groups(), found(), strict=True):
        digits = len(number.partition(".")[2])
        assert float(number) == pytest.approx(error, abs=1.01 * 10.0 ** -digits)
