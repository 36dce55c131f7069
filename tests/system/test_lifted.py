"""A bar that lies on the ground is lifted at one end without inertia: it turns about its other end, which friction holds.

In the first guess of a step it slips on all that is left of its base, and nothing but that friction holds it along the
ground (`hybrid.step.sticking`).
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from put_on_soil import put_on_soil

from hybrid.runtime.errors import StepError
from hybrid.scene import Material, Motion
from hybrid.setup.build import build
from hybrid.step import sticking
from hybrid.study.scenes import box

LENGTH, WIDTH, HEIGHT, DENSITY, RATE = 2.0, 0.4, 0.2, 2000.0, 0.01     # [m], [kg/m³], [m] a step
WEIGHT = LENGTH * WIDTH * HEIGHT * DENSITY * 9.81
HELD = {"held": True, "geostatic": False}


def lifted(steps=6, **soil):
    """Simulation of the bar; soil: values of that table."""
    scene = put_on_soil(
        box(LENGTH, WIDTH, HEIGHT, size=0.2, density=DENSITY, position=(0.0, 0.0, 0.0), rest_on=0.0, friction=0.5),
        size=0.25, x=(-2.0, 2.0), y=(-1.0, 1.0), z=(-0.5, 0.25), steps=steps,
        material=Material(law="hencky", young=1e7, poisson=0.3, density=1800.0), **soil)
    end = Motion(component="z", point=(0.5 * LENGTH, 0.0, 0.5 * HEIGHT), velocity=RATE)
    return build(replace(scene, stages=(replace(scene.stages[0], motions=(end,)),)))


def lift(**values):
    """(iterations, [m] by which its centre is away along the ground from where it turns about its end, force [N])."""
    records = list(lifted(**values).steps())
    body, angle = records[-1].bodies[0], len(records) * RATE / LENGTH
    away = body.position[:2] - [0.5 * LENGTH * (np.cos(angle) - 1) - 0.5 * HEIGHT * np.sin(angle), 0.0]
    return sum(record.iterations for record in records), np.linalg.norm(away), body.contact_force


@pytest.mark.parametrize("soil", [HELD, {}], ids=["held", "elastic"])
def test_a_bar_lifted_at_one_end_turns_about_the_other(soil):
    iterations, away, force = lift(**soil)
    assert iterations < 30 and away < 2e-3
    assert force == pytest.approx([0.0, 0.0, 0.5 * WEIGHT], abs=0.02 * WEIGHT)


def test_else_updates_carry_it_away(monkeypatch):
    """And lead back: there is no first step."""
    monkeypatch.setattr(sticking, "drifting", lambda *given: None)
    with pytest.raises(StepError, match="residual"):
        lift(**HELD)


def test_a_box_turned_about_the_vertical_slips_on_all_of_its_base():
    """About its middle, from the first step on: points held in stick would lead it away."""
    scene = put_on_soil(box(1.0, 1.0, 0.5, size=2.0, density=DENSITY, position=(0.0, 0.0, 0.0), rest_on=0.0, friction=0.4),
                        size=0.25, x=(-1.0, 1.0), y=(-1.0, 1.0), z=(-0.5, 0.25), steps=3,
                        material=Material(law="hencky", young=1e7, poisson=0.3, density=1800.0))
    turn = Motion(component="rz", velocity=0.1)
    records = list(build(replace(scene, stages=(replace(scene.stages[0], motions=(turn,)),))).steps())
    assert sum(record.iterations for record in records) < 20 and all(record.increments == 1 for record in records)
    assert np.abs(records[-1].bodies[0].position[:2]).max() < 1e-4
    assert records[-1].bodies[0].contact_moment[2] == pytest.approx(-0.4 * 1e3 * 9.81 * 0.43, rel=0.05)


def terms(slip, shear, normal=(0.0, 0.0, 1.0), free=(True,) * 6, drive=0.0, driven=0, line=None, beside=False):
    """What `drifting` reads of BodyTerms."""
    body = SimpleNamespace(free=np.array(free), drive=np.eye(6)[driven] * drive, line=line)
    contact = SimpleNamespace(active=10 + np.arange(len(slip)), slip=np.array(slip), shear=np.array(shear),
                              normal=np.array(normal if np.ndim(normal) == 2 else [normal] * len(slip)))
    return SimpleNamespace(step=SimpleNamespace(body=body), contact=contact, beside=beside)


def drifting(body, inertia=False, joints=(), guided=()):
    model = SimpleNamespace(scheme=SimpleNamespace(inertia=inertia), joints=joints,
                            guides=[SimpleNamespace(guide=SimpleNamespace(component=axis)) for axis in guided])
    found = sticking.drifting(SimpleNamespace(model=model), SimpleNamespace(bodies=[body]))
    return None if found is None else found.bodies[0].tolist()


SHEAR = [[-3.0, 0.1, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]


def test_the_stronger_of_points_that_slip_against_one_another_are_held():
    assert drifting(terms([True] * 3, SHEAR)) == [10, 12]
    assert drifting(terms([True] * 3, SHEAR), guided=[2]) == [10, 12]

    assert drifting(terms([True] * 3, SHEAR, drive=0.1, driven=3)) == [10, 12]     # tilted, it drags its base along


@pytest.mark.parametrize("values, others", [
    ({"slip": [True, False, True]}, {}), ({"slip": [False] * 3}, {}), ({"drive": 0.1}, {}),
    ({"drive": 0.1, "driven": 5}, {}),
    ({"line": "chain"}, {}),
    ({"beside": True}, {}), ({"free": (False, False, *[True] * 4)}, {}), ({}, {"inertia": True}), ({}, {"joints": ("pin",)}),
    ({}, {"guided": [2, 0]}), ({}, {"guided": [5]}), ({"normal": [[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]]}, {})])
def test_bodies_that_something_holds_or_draws_along_are_left_alone(values, others):
    assert drifting(terms(**{"slip": [True] * 3, "shear": SHEAR, **values}), **others) is None


def test_a_body_that_touches_nothing_is_left_alone():
    assert drifting(terms([], np.zeros((0, 3)), normal=np.zeros((0, 3)))) is None
