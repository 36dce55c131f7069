"""Laws given from Python: the demo, what is refused at the start, and points that have no stress in a step."""

from dataclasses import replace

import numpy as np
import pytest
from demo_scripts import demo

import hybrid
from hybrid.laws.hencky import Hencky
from hybrid.runtime.errors import LawError, SceneError, StepError
from hybrid.scene import Material
from hybrid.setup.build import build
from hybrid.study.scenes import elastic, soil_scene

DEMO = demo("user_law")


def scene(**material):
    """Three steps of a block of soil that falls onto its rollers."""
    described = soil_scene(gravity=(0.0, 0.0, -9.81), steps=3)
    return replace(described, soil=replace(described.soil, material=Material(**material)))


USER = scene(law="user", density=1800.0)


def test_clay_of_the_demo_has_the_force_of_its_closed_form():
    assert DEMO.check() < 1e-8
    simulation = build(DEMO.oedometer(4), law=DEMO.clay)
    *_, last = simulation.steps()
    points = simulation.state.points
    strain = -np.log(points.deformation[:, 2, 2])
    assert np.ptp(strain) < 1e-8 and points.plastic_strain.min() > 0.03
    assert last.bodies[0].contact_force[2] == pytest.approx(DEMO.closed_form(strain.mean()), rel=1e-5)
    assert simulation.sheet()["modelled"]["soil law"] == "user, HyperbolicClay"


def test_a_user_law_equal_to_one_of_the_package_gives_the_same_run():
    own = build(USER, law=lambda points, stress: Hencky(np.full(len(points), 1e6), 0.2))
    theirs = build(scene(density=1800.0, **elastic(1e6, 0.2)))
    for _ in zip(own.steps(), theirs.steps()):
        pass
    np.testing.assert_allclose(own.state.points.position, theirs.state.points.position, rtol=1e-14, atol=1e-15)


def test_the_law_gets_positions_and_initial_stress():
    given = []

    def law(points, stress):
        given.append((points.position.copy(), stress))
        return Hencky(np.full(len(points), 1e6), 0.2)

    described = replace(USER, soil=replace(USER.soil, geostatic=True, k0=0.6))
    points = build(described, law=law).state.points
    (position, stress), = given
    np.testing.assert_array_equal(position, points.position)
    np.testing.assert_allclose(stress[:, 2], 1800 * 9.81 * position[:, 2], rtol=1e-12)
    np.testing.assert_allclose(np.diagonal(points.stress, axis1=1, axis2=2), stress, rtol=1e-12)


@pytest.mark.parametrize("described, law, error, words", [
    (USER, None, SceneError, "belong together"),
    (scene(density=1800.0, **elastic(1e6)), DEMO.clay, SceneError, "but law = 'hencky' and one is given"),
    (USER, lambda points, stress: None, LawError, "NoneType has no young"),
    (USER, lambda points, stress: Hencky(1e6, 0.2), LawError, r"young of a law has shape \(1,\)"),
    (USER, lambda points, stress: Hencky(np.zeros(len(points)), 0.2), LawError, "must be positive"),
])
def test_what_is_refused_at_the_start(described, law, error, words):
    with pytest.raises(error, match=words):
        build(described, law=law)


def test_a_run_takes_a_law_too(tmp_path):
    with pytest.raises(SceneError, match=r"run\(scene, law=...\)"):
        hybrid.run(USER, out=tmp_path, quiet=True)
    simulation = hybrid.run(USER, out=tmp_path, quiet=True,
                            law=lambda points, stress: Hencky(np.full(len(points), 1e6), 0.2))
    assert simulation.state.step == 3


class Brittle(Hencky):
    """Has no stress beyond an elongation or shortening along any axis, at points of odd number."""

    LIMIT = 2e-4

    def respond(self, strain, plastic_strain):
        response = super().respond(strain)
        odd = np.arange(len(strain)) % 2 == 1
        return replace(response, failed=odd & (np.abs(strain).max(axis=1) > self.LIMIT))


def test_points_without_a_stress_reject_the_step_and_are_named():
    """A wrong stress is always reported: the increment is halved, then the run stops and names the points."""
    simulation = build(USER, law=lambda points, stress: Brittle(np.full(len(points), 1e6), 0.2))
    with pytest.raises(StepError, match=r"leaves the soil's law without a stress at points \d+, .* and \d+ more"):
        list(simulation.steps())
    assert np.isfinite(simulation.state.points.stress).all()
    assert np.abs(np.log(np.linalg.eigvalsh(simulation.state.points.b_elastic)) / 2)[1::2].max() <= Brittle.LIMIT


def test_halving_cures_what_fails_at_long_increments():
    """Two refusals are two rejections; the step is then made in shorter increments."""
    class Moody(Hencky):
        refusals = 0

        def respond(self, strain, plastic_strain):
            self.refusals -= 1
            return replace(super().respond(strain), failed=(np.arange(len(strain)) == 7) & (self.refusals >= 0))

    simulation = build(USER, law=lambda points, stress: Moody(np.full(len(points), 1e6), 0.2))
    simulation.model.soil.law.law.refusals = 2
    record = next(simulation.steps())
    assert (record.rejections, record.increments, record.step) == (2, 3, 1)
