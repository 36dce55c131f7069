"""Which solver a tangent goes to, in which order, and for how many iterations."""

import math

import numpy as np
import pytest

from hybrid.linalg import solver_choice
from hybrid.linalg.solver_choice import (
    ASKED,
    DIRECT,
    ILU0,
    ILU0_SHIFTED,
    LEAST,
    MARGIN,
    MOST,
    RETRY,
    SSOR,
    SolverChoice,
)
from hybrid.runtime.memory import available_memory, direct_factor_memory


def order(choice, unknowns=10_000, symmetric=True):
    return [solver for solver, _ in choice.begin(unknowns, 1, symmetric)]


@pytest.mark.parametrize("symmetric, first", [(True, SSOR), (False, ILU0)])
def test_a_solver_that_takes_few_iterations_stays(symmetric, first):
    choice = SolverChoice("auto")
    for _ in range(3 * RETRY):
        assert order(choice, symmetric=symmetric)[0] == first
        choice.solved(first, 12, 1e-3)


def test_the_first_tangent_tries_all_solvers_and_no_one_for_long():
    (first, second, third, last) = SolverChoice("auto").begin(10_000, 1, True)
    assert [first[0], second[0], third[0], last[0]] == [SSOR, ILU0, ILU0_SHIFTED, DIRECT]
    assert first[1] == LEAST <= second[1] < 2 * LEAST and third[1] == int(MARGIN * (300 + 15 + 15)) < last[1] == MOST


def test_a_solver_that_failed_is_left_out_until_all_are_tried_again():
    choice = SolverChoice("auto")
    choice.begin(10_000, 1, True)
    choice.failed(SSOR)
    choice.failed(ILU0)
    for _ in range(RETRY - 1):
        choice.solved(ILU0_SHIFTED, 150, 1e-3)
        assert order(choice) == [ILU0_SHIFTED, DIRECT, SSOR, ILU0]     # the last two if that finds the matrix singular
    assert order(choice) == [SSOR, ILU0, ILU0_SHIFTED, DIRECT]


@pytest.mark.parametrize("plane, tangents", [(False, [4, 7, 13, 25, 25, 25]), (True, [8, 16, 31, 50, 50, 50])])
def test_all_solvers_that_failed_are_tried_again_soon_and_then_ever_later(plane, tangents):
    """Once factors have cost SOON iterations, 2, 4, ... times as many, of 330 each in space and 130 in a plane; after SOON
    again once one of them has worked."""
    choice = SolverChoice("auto", plane)

    def tangents_until_tried():
        for solver in (SSOR, ILU0, ILU0_SHIFTED):
            choice.failed(solver)
        choice.solved(DIRECT, 1, 1e-3)
        count = 1
        while order(choice)[0] == DIRECT:
            choice.solved(DIRECT, 1, 1e-3)
            count += 1
        return count

    choice.begin(10_000, 1, True)
    waited = [tangents_until_tried() for _ in range(6)]
    assert waited == tangents
    choice.solved(SSOR, 12, 1e-3)
    assert order(choice)[0] == SSOR and tangents_until_tried() == tangents[0]


def test_a_slow_solver_is_compared_with_one_that_was_not_tried():
    """Sweeps with 100 iterations a tangent lose to the prior of the next one, with 40 they do not."""
    for iterations, first in ((40, SSOR), (100, ILU0)):
        choice = SolverChoice("auto")
        choice.begin(10_000, 1, True)
        choice.solved(SSOR, iterations, 1e-3)
        assert order(choice)[0] == first


def test_a_direct_factor_is_taken_where_iterations_cost_more():
    """In a plane it costs a fifth of one in space; the more right-hand sides a tangent has, the sooner it pays."""
    for plane, solutions, first in ((False, 1, ILU0_SHIFTED), (True, 1, DIRECT), (False, 4, DIRECT)):
        choice = SolverChoice("auto", plane)
        for _ in range(8):
            order(choice)
            choice.failed(SSOR)
            choice.failed(ILU0)
            for _ in range(solutions):
                choice.solved(ILU0_SHIFTED, 250, 1e-3)
        assert order(choice)[0] == first, (plane, solutions)


def test_a_run_that_is_continued_decides_as_if_it_had_not_stopped():
    choice, copy = SolverChoice("auto"), SolverChoice("auto")
    for choice_of_both, count in ((choice, 51), (choice, 140), (choice, 17)):
        first = order(choice_of_both)[0]
        choice.failed(first)
        choice.solved(ILU0_SHIFTED, count, 0.02)
    copy.restore(choice.memory())
    for count in range(2 * RETRY):
        assert choice.begin(10_000, 1, True) == copy.begin(10_000, 1, True)
        for one in (choice, copy):
            one.solved(ILU0_SHIFTED, count, 1e-2)
        np.testing.assert_array_equal(choice.memory(), copy.memory())


def test_a_factor_is_taken_while_it_fits(monkeypatch):
    """Where it does not, sweeps get all the iterations there are, after the others."""
    choice = SolverChoice("auto")
    monkeypatch.setattr(solver_choice, "available_memory", lambda: 2**30)
    assert not choice.refusal(20_000) and "limit 819 MiB" in choice.refusal(50_000)
    assert order(choice, 20_000)[-1] == DIRECT
    assert choice.begin(50_000, 0, True)[-2:] == [(ILU0_SHIFTED, MOST), (SSOR, MOST)]
    assert not SolverChoice("auto", plane=True).refusal(50_000) and not SolverChoice("direct").refusal(50_000)
    assert order(SolverChoice("direct"), 50_000) == [DIRECT]


def test_costs_of_a_factor_are_those_measured():
    """In iterations: 280, 320, 370, 375, 1 010 in space with 4 347, 6 902, 19 124, 22 450, 52 206 unknowns, 160 in a plane
    with 25 600."""
    for unknowns, plane, measured in ((4_347, False, 280), (6_902, False, 320), (19_124, False, 370), (22_450, False, 375),
                                      (52_206, False, 1010), (25_600, True, 160)):
        cost = SolverChoice("auto", plane)._costs(unknowns, 0, True)[DIRECT]
        assert abs(math.log(cost / measured)) < math.log(1.25)


def test_memory_of_a_factor():
    """As MUMPS reports it: 483 MB for 17 859 unknowns in space, 128 MB for 28 800 in a plane."""
    assert direct_factor_memory(17_859) == pytest.approx(483e6, rel=0.2)
    assert direct_factor_memory(28_800, plane=True) == pytest.approx(128e6, rel=0.2)
    assert available_memory() > 2**20


def test_memory_is_asked_for_now_and_then_and_always_where_a_factor_did_not_fit(monkeypatch):
    asked, left, choice = [], 2**40, SolverChoice("auto")
    monkeypatch.setattr(solver_choice, "available_memory", lambda: asked.append(left) or left)
    for _ in range(2 * ASKED):
        assert order(choice)[-1] == DIRECT
    assert len(asked) == 2
    order(choice, unknowns=11_000)
    assert len(asked) == 3
    left = 2**20
    assert order(choice, unknowns=12_000)[-1] == SSOR
    left = 2**40
    assert order(choice, unknowns=12_000)[-1] == DIRECT


def test_a_failure_is_told_by_the_last_iterative_solver_and_the_direct_factor(monkeypatch):
    choice, failures = SolverChoice("auto"), {ILU0: "a diagonal block is singular", ILU0_SHIFTED: "no convergence"}
    assert choice.describe(failures, 100) == "no convergence"
    assert choice.describe({**failures, DIRECT: "it is singular"}, 100) == "no convergence, and it is singular"
    monkeypatch.setattr(solver_choice, "available_memory", lambda: 0)
    assert choice.describe(failures, 100).startswith("no convergence, and a direct factor does not fit")
