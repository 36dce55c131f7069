"""Problems set up afresh: they set no option, the page quotes the record, and what takes seconds is right."""

import json

import pytest
from options import options_set

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Solver
from hybrid.study.random import afresh

PAGE = GEOMETRY.parent / "demos" / "random" / "README.md"
# physics that the random families do not have
INTERFACE = {"Body.adhesion", "Body.tension", "Scene.joints", "Soil.ground"}


@pytest.mark.parametrize("name", afresh.PROBLEMS)
def test_no_problem_sets_an_option(name):
    scene = afresh.PROBLEMS[name]().scene
    assert set(options_set(scene)) <= INTERFACE and scene.solver == Solver()


def test_the_page_quotes_the_record():
    rows = afresh.recorded()
    assert [row["name"] for row in rows] == [name for name in afresh.PROBLEMS if name in {row["name"] for row in rows}]
    assert "\n".join(afresh.table(rows)) in PAGE.read_text(encoding="utf-8")
    assert json.loads(afresh.PATH.read_text(encoding="utf-8"))["stamp"]


@pytest.mark.parametrize("name", ["block slides", "block sticks", "ball rolls", "oedometer", "wall", "wall drawn back",
                                  "bank, 26°", "buoyant pipe"])
def test_problems_of_seconds_are_right_and_nothing_is_reported(name):
    outcome = afresh.measure(name)
    assert abs(outcome.error) <= outcome.allowed and outcome.messages == ()
