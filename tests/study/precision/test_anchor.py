"""The short anchor drag of a study: how its error is measured, and that the grid of the reference comes nearest to
it."""

import json

import numpy as np
import pytest
from problem_checks import check

from hybrid.runtime.errors import StepError
from hybrid.step import iteration
from hybrid.study.precision.problems import anchor

REFERENCE = json.loads(anchor.REFERENCE.read_text(encoding="utf-8"))


def course():
    """The reference's own: times, places, tensions."""
    return [np.array(REFERENCE[key]) for key in ("time [s]", "place [m]", "tension [N]")]


def test_contract():
    check(anchor.PROBLEM, anchor.scene)


def test_every_scene_is_a_scene():
    for settings in anchor.curves(False).values():
        for _, values in settings:
            made = anchor.scene(**values)
            assert sum(stage.steps for stage in made.stages) * made.time.step == pytest.approx(1.6)


def test_the_reference_spans_the_drag():
    time, place, tension = course()
    assert time[-1] == pytest.approx(anchor.DRAG) and len(time) == len(place) == len(tension) == 30
    assert (tension >= 0).all() and np.ptp(place[:, 0]) > 0.2


def test_the_reference_has_no_error_of_its_own():
    time, place, tension = course()
    assert anchor.missed(time, place, tension, REFERENCE) == {"trajectory": 0.0, "tension": 0.0}
    every_other = slice(1, None, 2)
    found = anchor.missed(time[every_other], place[every_other], tension[every_other], REFERENCE)
    assert found["trajectory"] < 1e-12 and found["tension"] < 0.1


def test_a_wrong_course_is_found():
    """3 cm aside of a way of 30 cm, and a tenth of the tension too much."""
    time, place, tension = course()
    found = anchor.missed(time, place + (0.0, 0.03, 0.0), 1.1 * tension, REFERENCE)
    assert found == pytest.approx({"trajectory": 0.1, "tension": 0.1})


def test_a_failure_is_raised(monkeypatch):
    monkeypatch.setattr(iteration, "MOST", 0)
    with pytest.raises(StepError):
        anchor.solve(h=0.4, solver={"tolerance": 1e-12})


@pytest.mark.slow
def test_errors_fall_with_the_cells():
    """Measured: 0.18 and 0.11 of the trajectory, 0.27 and 0.13 of the tension; what is left is that of the step."""
    coarse, fine = (anchor.solve(h=h).errors for h in (0.3, 0.2))
    assert all(fine[name] < 0.8 * coarse[name] for name in anchor.PROBLEM.errors)
