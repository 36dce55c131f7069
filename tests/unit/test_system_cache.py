"""What is kept from one set of nodes to the next."""

import numpy as np

from hybrid.linalg.system_cache import Systems
from hybrid.scene import Solver
from hybrid.setup.build import build
from hybrid.study.scenes import soil_scene


def made(linear):
    model = build(soil_scene(size=0.1, solver=Solver(linear=linear))).model
    active = ~model.soil.grid.fixed.all(axis=1)
    return Systems(model), active, np.zeros_like(active)


def test_a_change_of_small_support_keeps_the_pattern_and_a_change_of_active_nodes_does_not():
    systems, active, small = made("auto")
    first = systems.get(active, small)
    assert systems.get(active.copy(), small.copy()) == first
    small[np.flatnonzero(active)[7]] = True
    pattern, system = systems.get(active, small)
    assert pattern is first[0] and system is not first[1]
    active[np.flatnonzero(active)[3]] = False
    third = systems.get(active, small)
    assert third[0] is not pattern and third[1] is not system
    assert third[0].size < pattern.size


def test_small_support_does_not_matter_to_a_direct_factor():
    systems, active, small = made("direct")
    assert systems.get(active, ~small) == systems.get(active, small)


def test_the_choice_of_the_solver_outlives_pattern_and_model():
    systems, active, light = made("auto")
    choice = systems.choice
    systems.get(active, light)
    active[np.flatnonzero(active)[3]] = False
    systems.get(active, light)
    systems.renew(systems._model)
    assert systems.choice is choice
    systems.renew(made("direct")[0]._model)
    assert systems.choice is not choice and systems.choice.linear == "direct"
