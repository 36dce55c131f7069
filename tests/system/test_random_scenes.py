"""Random scenes with nothing set but the physics: a few seeds of each family, all of them right.

The families and their aims: hybrid/study/random. `hybrid study random` runs all seeds.
"""

import pytest

from hybrid.study.random import runner

FAST = [("sphere", 0), ("sphere", 4), ("cylinder", 0), ("cylinder", 3), ("platen", 2), ("platen", 6), ("pipe", 0),
        ("collapse", 1), ("tumbling", 1)]
SLOW = [*((name, seed) for name in ("sphere", "cylinder") for seed in range(5, 25)),
        *(("platen", n) for n in (0, 1, 3, 4, 5, 7)),
        *(("collapse", n) for n in range(2, 10)), ("slab", 1), ("slab", 2), ("hertz", 0)]


@pytest.mark.parametrize("name, seed", [*FAST, *(pytest.param(*run, marks=pytest.mark.slow) for run in SLOW)])
def test_a_scene_is_right_by_default(name, seed):
    found = runner.measure(name, seed)
    assert found.kind == "right", found
