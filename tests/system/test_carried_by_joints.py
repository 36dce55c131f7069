"""Bodies that touch nothing and are carried by others through joints, without inertia: a mast on a strip footing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.body.joints import Joint as Constraint
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import StepError
from hybrid.scene import Body, Joint, Load, Material, Stage
from hybrid.setup.build import build
from hybrid.step import assemblies, body_terms
from hybrid.step.equations import Step
from tests.helpers.put_on_soil import put_on_soil

CLAY = Material(law="von-mises", young=5e6, poisson=0.49, density=1800.0, strength=1e4)
STEPS = 4


def block(name, length, height, centre):
    """A block whose middle is at `centre` (x, z) [m]."""
    return Body(geometry=GEOMETRY / "box.geo", name=name, density=500.0, position=(centre[0], 0.5, centre[1]),
                parameters={"length": length, "width": 1.0, "height": height, "size": 20.0})


def loaded(gravity, kind="weld", force=5e3):
    """(Newton iterations of each step, settlement [m]) of a footing that carries a mast, under a `force` [N] in its
    middle."""
    footing, mast = block("footing", 2.0, 0.5, (0.06, 0.25)), block("mast", 0.4, 0.5, (0.06, 1.0))
    axis = {"axis": (0.0, 1.0, 0.0)} if kind == "hinge" else {}
    joint = Joint(name="foot", kind=kind, bodies=("mast", "footing"), point=(0.0, 0.0, -0.25), **axis)
    scene = put_on_soil(footing, size=0.25, x=(-4.0, 4.0), z=(-2.0, 0.5), material=CLAY, steps=STEPS)
    load = Load(body="footing", force=((0.0, 0.0, 0.0, 0.0), (float(STEPS), 0.0, 0.0, -force)))
    scene = replace(scene, bodies=(footing, mast), joints=(joint,), gravity=(0.0, 0.0, -gravity),
                    stages=(Stage("press", STEPS, loads=(load,)),))
    records = list(build(scene).steps())
    return [record.iterations for record in records], 0.25 - records[-1].bodies[0].position[2]


@pytest.mark.parametrize("kind", ["weld", "ball"])
@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_a_mast_on_a_footing_costs_no_iterations(gravity, kind):
    iterations, settlement = loaded(gravity, kind)
    assert max(iterations) <= 5 and settlement > 0.0


def test_the_stiffness_of_unsupported_bodies_would_hold_it_back(monkeypatch):
    """The broken variant: the mast counts as a body that has left the soil."""
    few, settlement = loaded(9.81, force=2e3)
    monkeypatch.setattr(assemblies, "supported_by_joints", lambda joints, supported: [False] * len(supported))
    many, same = loaded(9.81, force=2e3)
    assert sum(many) > 2 * sum(few)
    assert settlement == pytest.approx(same, rel=0.01)


def hanging(kind):
    """Positions (3,) [m] of a block of 2.45 kN, 1.25 m below the point from which a rod or line of 1 m holds it, in steps in
    which a force across grows to 500 N."""
    box = Body(geometry=GEOMETRY / "box.geo", name="box", density=1000.0, position=(0.0, 0.5, 3.0), held=("rz",),
               parameters={"length": 0.5, "width": 1.0, "height": 0.5, "size": 5.0})
    scene = put_on_soil(box, size=1.0, x=(-2.0, 2.0), z=(-2.0, 1.0), material=CLAY, steps=5)
    rope = Joint(name="rope", kind=kind, bodies=("box",), point=(0.0, 0.0, 0.25), end=(0.0, 0.5, 4.25))
    load = Load(force=((0.0, 0.0, 0.0, 0.0), (5.0, 500.0, 0.0, 0.0)))
    scene = replace(scene, bodies=(box,), joints=(rope,), gravity=(0.0, 0.0, -9.81), soil=replace(scene.soil, held=True),
                    stages=(Stage("push", 5, loads=(load,)),))
    return [record.bodies[0].position for record in build(scene).steps()]


@pytest.mark.parametrize("kind", ["rod", "line"])
def test_a_block_on_a_rod_hangs_in_the_direction_of_its_load(kind, monkeypatch):
    """x = (L + h/2) sin θ, tan θ = F/W; with the stiffness of a cell it would hardly move, which is the broken variant."""
    for step, position in enumerate(hanging(kind), 1):
        angle = np.arctan(100.0 * step / (9.81 * 250.0))
        np.testing.assert_allclose(position, [1.25 * np.sin(angle), 0.5, 4.25 - 1.25 * np.cos(angle)], atol=1e-4)
    monkeypatch.setattr(assemblies, "supported_by_joints", lambda joints, supported: [False] * len(supported))
    with pytest.raises(StepError, match="box"):
        hanging(kind)


def test_a_body_on_which_nothing_acts_has_no_scale_of_its_own(monkeypatch):
    """The broken variant: round-off of the joint's force is compared with itself."""
    monkeypatch.setattr(assemblies, "FAINT", 0.0)
    with pytest.raises(StepError, match="mast"):
        loaded(0.0)


@pytest.mark.parametrize("links, carried", [
    ([], [True, False, False]), ([(1, 0)], [True, True, False]), ([(1, 2), (0, 1)], [True, True, True]),
    ([(2, None)], [True, False, True]),
])
def test_support_and_forces_are_those_of_all_that_joints_connect(links, carried):
    """Over any number of others, and from the ground."""
    ends = [(i, [[0.0] * 3] * 2) for i in links]
    joints = [Constraint("joint", bodies, points, at_point=True) for bodies, points in ends]
    assert assemblies.supported_by_joints(joints, [True, False, False]) == carried
    forces = assemblies.least_forces(joints, [4.0, 0.0, 0.0])
    on_one = {0}.union(*(set(pair) for pair in links if None not in pair)) if links else {0}
    assert forces == [4.0 * assemblies.FAINT * (i in on_one) for i in range(3)]
    slack = [replace(joint, at_point=False) for joint in joints]
    assert assemblies.least_forces(slack, [4.0, 0.0, 0.0]) == [4.0 * assemblies.FAINT, 0.0, 0.0]


@pytest.mark.parametrize("carried, expected", [(False, 1.0), (True, body_terms.REST)])
def test_what_is_carried_without_any_force_has_hardly_a_stiffness_of_its_own(carried, expected):
    """Enough for an equation that can be solved where a ball leaves its rotation free."""
    still = SimpleNamespace(unsupported=True, beside=False, _pace=lambda: 0.0,
                            step=SimpleNamespace(scheme=SimpleNamespace(inertia=False)))
    assert body_terms.BodyTerms._against_nothing(still, 1e6, carried) == expected * 1e6


@pytest.mark.parametrize("error, within", [(0.5e-4, True), (1.0, False)])
def test_a_residual_within_round_off_counts_where_joints_are_within_the_tolerance(error, within):
    """Soil is held here; a hinge whose friction is off its bound is not solved."""
    step = SimpleNamespace(soil=None, pattern=SimpleNamespace(free=None), _body_errors=lambda bodies: [({}, 0.0)],
                           model=SimpleNamespace(soil=None, solver=SimpleNamespace(tolerance=1e-4)))
    evaluation = SimpleNamespace(bodies=(), norms={}, joints=SimpleNamespace(error=lambda: error))
    assert Step.within_rounding(step, evaluation) == within
