"""Settings that curves share, and those that a scene can take over from a run."""

from hybrid.study.precision import settings


def test_tolerances_extend_the_solver_table():
    values = {"cells": 4, "solver": {"linear": "direct"}}
    label, first = settings.newton_tolerances(**values)[0]
    assert label == "1e-02" and first == {"cells": 4, "solver": {"linear": "direct", "tolerance": 1e-2}}
    assert values["solver"] == {"linear": "direct"}
    label, first = settings.krylov_tolerances(cells=4)[-1]
    assert label == "1e-05" and first["solver"] == {"linear_tolerance": 1e-5}


def test_few_keeps_the_first_settings():
    assert settings.few({"a": [1, 2, 3], "b": [4]}, {"a": 2}) == {"a": [1, 2]}


def test_only_tables_of_a_scene_are_transferable():
    values = {"cells": 4, "soil": {"ghost": 0.1}}
    assert settings.transferable(values, 4, "cells") == {"cells": 4, "soil": {"ghost": 0.1}, "solver": {}, "body": {}}
    assert settings.transferable({**values, "steps": 3}, 4, "cells") is None
