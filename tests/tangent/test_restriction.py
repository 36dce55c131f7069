"""An increment restricted to few nodes: its residual and tangent there are those of the whole, and what it saves."""

from dataclasses import replace

import numpy as np
import pytest
from pressed_block import prepared, scene
from scipy.sparse import csr_matrix

from hybrid.setup.build import build
from hybrid.soil import restriction as of_soil
from hybrid.step import iteration, restriction, sticking
from hybrid.study.precision.problems import anchor

CLOSE = {"rel": 1e-11, "abs": 1e-9}     # sums of points in another order


def halves(geometry, seed=3):
    """(Step, its Evaluation, nodes) of a sphere in sand, and every third node."""
    step, trial = prepared(scene(geometry, "drucker-prager", 0.3))
    nodes = np.random.default_rng(seed).random(step.model.soil.grid.node_count) < 0.3
    return step, step.evaluate(trial), nodes


@pytest.mark.parametrize("fbar", [False, True])
def test_residual_and_tangent_are_those_of_the_whole(geometry, fbar):
    described = scene(geometry, "drucker-prager", 0.3)
    step, trial = prepared(replace(described, soil=replace(described.soil, fbar=fbar)))
    nodes = np.random.default_rng(3).random(step.model.soil.grid.node_count) < 0.3
    whole = step.evaluate(trial)
    part = restriction.restricted(step, nodes, whole)
    few = part.evaluate(trial)
    assert len(part.bodies[0].pair.points) < len(step.bodies[0].pair.points)
    mine = step.pattern.dof[part.pattern.free]
    assert 0 < part.pattern.size < step.pattern.size and len(part.soil.points) < len(step.soil.points)
    assert few.soil == pytest.approx(whole.soil[mine], **CLOSE) and few.body == pytest.approx(whole.body, **CLOSE)
    step.assemble(whole)
    part.assemble(few)
    for name, at in (("uw", np.s_[mine]), ("wu", np.s_[:, mine]), ("ww", np.s_[:])):
        assert getattr(part.system, name) == pytest.approx(getattr(step.system, name)[at], rel=1e-10, abs=1e-3), name
    K, own = (csr_matrix((s.system.values, s.pattern.indices, s.pattern.indptr)) for s in (step, part))
    difference = np.abs((K[mine][:, mine] - own).toarray()).max()
    assert difference < 1e-10 * np.abs(own.data).max()


def test_a_soil_without_some_of_its_points_would_be_seen(geometry, monkeypatch):
    step, whole, nodes = halves(geometry)
    near = of_soil._near
    monkeypatch.setattr(of_soil, "_near", lambda *args: near(*args) & (np.arange(len(args[0])) % 2 == 0))
    part = restriction.restricted(step, nodes, whole)
    assert part.evaluate(whole.unknowns).soil != pytest.approx(whole.soil[step.pattern.dof[part.pattern.free]], rel=1e-3)


def test_nodes_with_most_of_the_residual_are_solved_for(geometry, monkeypatch):
    step, whole, _ = halves(geometry)
    monkeypatch.setattr(restriction, "FEW", 2.0)
    nodes = restriction.rough_nodes(step, whole)
    size = np.zeros(step.pattern.free.shape)
    size[step.pattern.free] = whole.soil
    assert nodes[np.argmax(np.linalg.norm(size, axis=1))] and not nodes.all()
    part = restriction.restricted(step, nodes, whole)
    new = iteration.smoothed(step, whole, iteration.Updates(iteration.PATIENCE))
    assert part.evaluate(new.unknowns).error < iteration.SMOOTH * part.evaluate(whole.unknowns).error


def test_what_cannot_be_restricted_is_left(geometry, monkeypatch):
    elastic, trial = prepared(scene(geometry, "hencky", 0.3))
    step, whole, _ = halves(geometry)
    monkeypatch.setattr(restriction, "FEW", 2.0)
    assert restriction.rough_nodes(step, whole) is not None
    assert restriction.rough_nodes(elastic, elastic.evaluate(trial)) is None
    monkeypatch.setattr(restriction, "FEW", 0.0)
    assert restriction.rough_nodes(step, whole) is None and iteration.smoothed(step, whole, None) is whole
    monkeypatch.setattr(restriction, "FEW", 2.0)
    monkeypatch.setattr(of_soil, "can_be_restricted", lambda soil: False)
    assert restriction.rough_nodes(step, whole) is None


@pytest.mark.slow
def test_sand_before_an_anchor_takes_fewer_iterations(monkeypatch):
    """And comes to the same place. Of the two remedies, this one alone: points held in stick do as much here."""
    monkeypatch.setattr(sticking, "reversing", lambda *given: None)

    def most():
        simulation = build(anchor.scene(h=0.3, drag=0.5))
        steps = simulation.steps()
        return max(next(steps).iterations for _ in range(20)), simulation.state.bodies[0].position

    iterations, position = most()
    monkeypatch.setattr(iteration, "SLOW", np.inf)
    without, expected = most()
    assert position == pytest.approx(expected, abs=1e-4)
    assert iterations < 0.7 * without
