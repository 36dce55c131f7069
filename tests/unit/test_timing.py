"""Wall time by phase: added up until it is collected, also when the phase fails."""

import pytest

from hybrid.runtime import timing


@pytest.fixture
def clock(monkeypatch):
    """A clock that goes on by a second each time it is read."""
    ticks = iter(range(100))
    monkeypatch.setattr(timing.time, "perf_counter", lambda: float(next(ticks)))
    timing.collect()


def test_phases_add_up_and_start_anew(clock):
    for name in ("soil", "contact", "soil"):
        with timing.phase(name):
            pass
    assert timing.collect() == {"soil": 2.0, "contact": 1.0}
    assert timing.collect() == {}


def test_a_phase_that_fails_is_counted(clock):
    with pytest.raises(ZeroDivisionError), timing.phase("soil"):
        1 / 0
    assert timing.collect() == {"soil": 1.0}
