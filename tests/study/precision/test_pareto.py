"""The Pareto front of records, and the median and spread of their times."""

from hybrid.study.precision import pareto
from hybrid.study.precision.record import Record


def records():
    return [Record("p", "a", "1", {}, {"e": 0.1}, (1.0,), 1, 1),
            Record("p", "a", "2", {}, {"e": 0.01}, (4.0,), 1, 2),
            Record("p", "b", "1", {}, {"e": 0.05}, (8.0,), 1, 9),
            Record("p", "b", "2", {}, {"e": 0.001}, (9.0,), 1, 10),
            Record("p", "c", "1", {}, reason="no"), Record("p", "d", "1", {}, {"e": float("nan")}, (0.1,), 1, 1)]


def test_front_and_excess():
    best = pareto.front(records(), "e")
    assert [(r.curve, r.setting) for r in best] == [("a", "1"), ("a", "2"), ("b", "2")]
    assert pareto.excess(records()[2], records(), "e") == 2.0 and pareto.excess(records()[1], records(), "e") == 1.0
    assert pareto.excess(records()[4], records(), "e") == pareto.excess(records()[5], records(), "e") == float("inf")
