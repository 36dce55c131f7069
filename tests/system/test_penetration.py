"""Penetration by the height of a point domain is reported before the error of the force exceeds a tenth."""

import re

import pytest

from hybrid.study.failure.registry import MODES


@pytest.mark.parametrize("share, error, more, words", [
    (0.7, 0.01, {"penalty": 50.0}, None), (0.9, 0.2, {"penalty": 50.0}, "limit 1; .*twice: raise body.penalty"),
    (0.9, 0.01, {"penalty": 5000.0}, None), (0.9, 0.01, {}, None),
    (0.9, 0.3, {"penalty": 50.0, "contact": "corners"}, "limit 1; .*twice: raise body.penalty")])
def test_a_layer_squeezed_under_a_platen(share, error, more, words):
    """A second row of contact points touches from a share of 0.8 on, with ten times the penalty from 0.97 on. The
    derived one is 2000 /m.

    On faces the error is 0.23 and on corners 0.43: of the second row the faces that look at the platen press, and of
    the corners also those of the first row's lower side, which are in the same place."""
    mode = MODES["squeezed_layer"]
    found = mode.relevant(mode.solve(share, **more))
    assert len(found.messages) == (words is not None)
    assert found.error > error if words else found.error < error
    assert not words or re.search(words, found.messages[0])
