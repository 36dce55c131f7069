"""Which solver a tangent goes to first."""

import pytest

from hybrid.linalg import solver_choice
from hybrid.linalg.solver_choice import RETRY, SolverChoice
from hybrid.runtime.memory import available_memory, direct_factor_memory

DIRECT = 3


def test_the_solver_that_was_needed_comes_first_until_the_order_is_tried_again():
    choice = SolverChoice("auto")
    assert choice.begin(1000, DIRECT) == 0
    choice.solved(DIRECT, 0, DIRECT)
    for _ in range(RETRY):
        assert choice.begin(1000, DIRECT) == DIRECT
        choice.solved(DIRECT, DIRECT, DIRECT)
    assert choice.begin(1000, DIRECT) == 0      # and the iterative solvers converge again
    choice.solved(0, 0, DIRECT)
    assert choice.begin(1000, DIRECT) == 0 and not choice.direct


@pytest.mark.parametrize("number, first", [(0, 0), (1, 0), (2, 2), (3, 3)])
def test_the_second_of_the_preconditioners_is_not_remembered(number, first):
    """The order of linear = "krylov" stays as it is."""
    choice = SolverChoice("auto")
    choice.solved(number, 0, DIRECT)
    assert choice.begin(1000, DIRECT) == first


def test_a_solver_that_fails_later_is_forgotten():
    choice = SolverChoice("auto")
    choice.solved(2, 0, DIRECT)
    choice.solved(DIRECT, 2, DIRECT)
    assert choice.begin(1000, DIRECT) == DIRECT and choice.direct
    choice.solved(0, DIRECT, DIRECT)
    assert choice.begin(1000, DIRECT) == 0 and not choice.direct


def test_a_factor_is_taken_while_it_fits(monkeypatch):
    choice = SolverChoice("auto")
    choice.solved(DIRECT, 0, DIRECT)
    monkeypatch.setattr(solver_choice, "available_memory", lambda: 2**30)
    assert not choice.refusal(20_000) and "limit 819 MiB" in choice.refusal(50_000)
    assert choice.begin(50_000, DIRECT) == 0 and choice.begin(20_000, DIRECT) == DIRECT
    assert not SolverChoice("auto", plane=True).refusal(50_000) and not SolverChoice("direct").refusal(50_000)


def test_memory_of_a_factor():
    """As MUMPS reports it: 483 MB for 17 859 unknowns in space, 128 MB for 28 800 in a plane."""
    assert direct_factor_memory(17_859) == pytest.approx(483e6, rel=0.2)
    assert direct_factor_memory(28_800, plane=True) == pytest.approx(128e6, rel=0.2)
    assert available_memory() > 2**20
