"""Probable causes of a failed step and remedies that fit its scene; warnings of long plastic increments."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.failure_hints import (
    _unbalanced,
    accuracy_remedies,
    advice,
    either,
    overstretched_domains,
    probable_causes,
    remedies,
)
from hybrid.monitors.judged_increments import JudgedIncrements
from hybrid.monitors.plastic_increment import LIMIT, PlasticIncrement
from hybrid.scene import Faces, Load, Material, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.soil.domains import cells_wide
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import box, soil_scene


def test_width_of_a_domain_in_cells():
    """A rotated and stretched domain, in cells of two sizes; 0 along a collapsed axis."""
    axes = np.array([0.0, 1.0, 3.0]), np.zeros(1), np.array([0.0, 1.0, 2.0])
    quarter = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [3.0, 0.0, 0.0]])    # x goes to z, three times as long
    found = cells_wide(np.full((2, 3), 0.25), np.array([np.eye(3), quarter]),
                       np.array([[0.5, 0.0, 0.5], [2.0, 0.0, 0.5]]), axes)
    np.testing.assert_allclose(found, [[0.5, 0.0, 0.5], [0.25, 0.0, 1.5]])
    half, turn = np.array([[0.25, 0.1, 0.05]]), np.array([[[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]])
    np.testing.assert_allclose(cells_wide(half, turn, np.array([[0.5, 0.0, 0.5]]), axes), [[0.1, 0.0, 0.5]])


@pytest.mark.parametrize("dilation, inertia, advised", [(0.0, False, True), (30.0, False, False), (0.0, True, False)])
def test_sand_that_hardly_dilates_is_a_cause_without_inertia(dilation, inertia, advised):
    sand = Material(law="mohr-coulomb", young=2e7, poisson=0.3, density=1700.0, friction_angle=33.0, cohesion=100.0,
                    dilation_angle=dilation)
    described = soil_scene(time=Time(step=1.0, inertia=inertia))
    model = build(replace(described, soil=replace(described.soil, material=sand))).model
    changes = remedies(model, "the residual stalls", (1e-3,), 1e-4)
    assert any("dilation_angle nearer" in change for change in changes) == advised


@pytest.mark.parametrize("stretch, warned", [(1.0, False), (1.7, False), (1.9, True)])
def test_stretched_domains_are_reported(stretch, warned):
    """With two points a cell from 0.9 of a cell on; not where there is inertia."""
    simulation = build(soil_scene(time=Time(step=1.0, inertia=False)))
    points = simulation.state.points
    points.deformation[0, 2, 2] = stretch
    texts = overstretched_domains(simulation.model, points)
    assert bool(texts) == warned and all(re.search(r"wide, limit 0.9.*soil\.points_per_axis", text) for text in texts)
    assert not overstretched_domains(build(soil_scene()).model, points)


def test_round_off_grows_with_stiffness_and_size():
    """A tenth of it is what cubes of 0.1 m make: K = E/3 < E at ν = 0, E 0.01 m² times 2e-16, by the root of their
    number."""
    soil = build(soil_scene()).model.soil
    assert soil.roundoff_force(100) == pytest.approx(10 * 2.2e-16 * 1e6 * 0.01 * 10, rel=0.01)
    stiffer = build(soil_scene(young=1e9)).model.soil
    assert stiffer.roundoff_force(400) == pytest.approx(2e3 * soil.roundoff_force(100))


def test_long_plastic_increments_are_reported_once():
    monitor = PlasticIncrement(None, None)

    def notes(step, added):
        report = SimpleNamespace(plastic_increment=added)
        return monitor.notes(StepView(None, SimpleNamespace(time=float(step), step=step), None, report, {}))

    assert notes(1, LIMIT) == ()
    (text,) = notes(2, 0.15)
    assert "0.15" in text and f"limit {LIMIT:g}" in text and "stage.steps" in text and "stage.load" not in text
    assert notes(3, 1.0) == ()


def test_a_weight_that_yields_in_the_first_step_is_to_be_let_down():
    """More steps are no remedy for what acts at once."""
    view = StepView(None, SimpleNamespace(time=1.0, step=1), None, SimpleNamespace(plastic_increment=2 * LIMIT), {})
    (text,) = PlasticIncrement(None, None).notes(view)
    assert "stage.load" in text


def quasi_static(**more):
    return build(soil_scene(time=Time(step=1.0, inertia=False), **more)).model


def test_remedies_fit_the_scene():
    """No penalty without bodies, no damping and no time.accuracy without inertia, no direct solver where it is used."""
    stalled = {"reason": "residual 1e-3 after 15 iterations", "errors": (1.0, 1e-3, 1e-3, 1e-3), "tolerance": 1e-6}
    assert remedies(quasi_static(), **stalled) == ("a smaller time.step with more stage.steps",)
    dynamic = remedies(build(soil_scene(time=Time(step=0.01, scheme="newmark"))).model, **stalled)
    assert dynamic[0] == "a smaller time.step" and "damps" in dynamic[-1] and len(dynamic) == 2
    assert remedies(build(soil_scene()).model, **stalled) == ("a smaller time.step",)
    with_body = build(soil_scene([box(0.2, 0.2, 0.2, rest_on=0.0)])).model
    assert "a lower body.penalty" in remedies(with_body, **stalled)
    singular = remedies(quasi_static(), "linear solver: ..., and the direct factor finds the matrix singular")
    assert singular[0] == "time.inertia = true"
    large = remedies(build(soil_scene(solver=Solver())).model, "linear solver: a direct factor does not fit: ...")
    assert large[0].startswith("larger cells")
    assert remedies(build(soil_scene(solver=Solver())).model, "linear solver: ...") == ("a smaller time.step",)
    direct = remedies(quasi_static(solver=Solver(linear="direct")), "linear solver: no convergence")
    assert direct == ("a smaller time.step with more stage.steps", "time.inertia = true")
    body = quasi_static(bodies=[box(0.2, 0.2, 0.2, rest_on=0.0)])
    assert any("body.held" in change for change in remedies(body, "linear solver: a diagonal block is singular"))
    held = quasi_static(bodies=[box(0.2, 0.2, 0.2, rest_on=0.0, held=("x", "y", "z", "rx", "ry", "rz"))])
    changes = remedies(held, "linear solver: a diagonal block is singular")
    assert any("body.friction" in change for change in changes) and not any("body.held" in change for change in changes)
    assert accuracy_remedies(build(soil_scene()).model)[0] == "a larger time.accuracy"


def test_the_remedy_that_works_comes_first():
    """By how the residual went: where it was close to the tolerance, a looser one."""
    model, reason = build(soil_scene()).model, "residual 1e-3 after 15 iterations"
    assert remedies(model, reason, (1.0, 1e-1, 1e-2, 1e-3), 1e-6)[0] == "a smaller time.step"
    assert "solver.tolerance" in remedies(model, reason, (1.0, 5e-5, 5e-5, 5e-5), 1e-6)[0]
    assert remedies(model, "box rotates by 3 rad in 1 s, limit 2 rad") == ("a smaller time.step",)
    assert either(("a",)) == "a" and either(("a", "b")) == "a or b" and either(("a", "b", "c")) == "a, b, or c"


def started(**more):
    """(Step of a quasi-static scene with a box, its Evaluation at rest, Workspace)."""
    body = box(0.2, 0.2, 0.2, held=("x", "y", "rx", "ry", "rz"), position=(0.4, 0.4, 0.0), **more)
    simulation = build(soil_scene([body], time=Time(step=1.0, inertia=False), gravity=(0.0, 0.0, -9.81)))
    workspace = Workspace(simulation.model)
    step = begin(simulation.model, simulation.state, 1.0, False, workspace)
    return step, step.evaluate(step.at_rest()), workspace


def test_soil_that_yields_may_also_carry_too_little():
    assert loaded(None).endswith("Without inertia a step also fails where the load exceeds what the soil can carry")


def test_lost_contact_is_named_as_the_cause():
    """Without inertia, and only where no body has contact; round-off of the stiffness is then no cause."""
    step, evaluation, workspace = started(rest_on=0.1)
    causes = probable_causes(step, evaluation)
    assert causes[0].startswith("No point of the soil touches body any more") and "body.rest_on" in causes[0]
    assert "time.inertia = true" in causes[0] and not any("round-off" in cause for cause in causes)
    outcome = SimpleNamespace(evaluation=evaluation, reason="residual 1.00e+00 after 15 iterations", errors=(1.0, 1.0))
    text = advice(step, outcome, Solver())
    assert text.startswith("No point") and "Otherwise use a smaller time.step with more stage.steps" in text
    assert "time.accuracy" not in text and "what the soil can carry" not in text     # elastic
    workspace.destroy()
    step, evaluation, workspace = started(rest_on=-0.004)
    assert not any("No point" in cause for cause in probable_causes(step, evaluation))
    workspace.destroy()


def test_many_judged_increments_are_reported_once():
    """Five, and a tenth of all: not before."""
    model = SimpleNamespace(solver=Solver(tolerance=1e-6))
    monitor = JudgedIncrements(model, None)

    def notes(judged, increments):
        report = SimpleNamespace(judged=judged, increments=increments)
        return monitor.notes(StepView(model, SimpleNamespace(time=2.0), None, report, {}))

    assert notes(4, 4) == () and notes(0, 37) == ()
    assert notes(1, 110) == ()          # 5 of 151
    (text,) = notes(11, 9)
    assert "16 of 160 increments" in text and "solver.tolerance = 1e-06" in text and "looser" in text
    assert notes(10, 10) == ()


@pytest.mark.parametrize("adhesion, friction, slips, inertia, reported", [
    (1.0, np.inf, True, False, True), (0.5, np.inf, True, False, False), (1.0, np.inf, False, False, False),
    (1.0, np.inf, True, True, False), (None, 0.3, True, False, False), (1.0, 0.3, True, False, False),
    (1.0, 0.6, True, False, True)])
def test_clay_that_slips_at_its_own_strength_is_a_cause_and_a_softer_penalty_the_remedy(
        adhesion, friction, slips, inertia, reported):
    """A skirt with α = 1 on cells of 0.1 m stops with steps of any length; with a tenth of the penalty it takes all of
    them. A point pressed by 20 N that bears 10 N of shear is not at its strength where friction of 0.3 is reached."""
    body = SimpleNamespace(name="skirt", penalty=200.0, friction=friction, interface=SimpleNamespace(adhesion=adhesion))
    model = SimpleNamespace(
        scheme=SimpleNamespace(inertia=inertia), bodies=[body], soil=SimpleNamespace(
            ghost_factor=0.3, roundoff_force=lambda count: 0.0, grid=SimpleNamespace(count_unknowns=lambda free: 1)))
    step = SimpleNamespace(model=model, soil=SimpleNamespace(mass=np.ones(2)),
                           pattern=SimpleNamespace(free=np.ones((2, 3), bool)), state=SimpleNamespace(time=1.0))
    contact = _Contact(slip=np.array([slips, False]), active=np.array([0, 2]), pressure=np.array([20.0, 20.0]))
    pair = SimpleNamespace(points=SimpleNamespace(limits=SimpleNamespace(shear=np.full(3, 10.0))))
    terms = SimpleNamespace(step=SimpleNamespace(body=body, pair=pair), contact=contact)
    evaluation = SimpleNamespace(contacts=[contact], bodies=[terms], norms={"soil [N]": 1.0})
    causes = probable_causes(step, evaluation)
    assert bool(causes) == reported and all("skirt" in text and "body.penalty = 20 /m" in text for text in causes)


class _Contact(SimpleNamespace):
    """Contact points with a mask of those that slip."""

    def __len__(self):
        return len(self.slip)


def loaded(force, gravity=(1.0, 1.0), time=Time(step=1.0, inertia=False), after=0,
           reason="residual 1.00e+00 after 15 iterations", elastic=False, moment=None, **more):
    """Text about a step of a scene of clay, or elastic, whose body a `force` and a `moment` of the stage push, and that has
    made `after` steps."""
    given = soil_scene([box(0.2, 0.2, 0.2, **{"rest_on": -0.004, "position": (0.4, 0.4, 0.0)} | more)], time=time,
                       gravity=(0.0, 0.0, -9.81))
    loads = (Load(force=force, moment=moment),) if force or moment else ()
    if not elastic:
        clay = replace(given.soil.material, law="von-mises", strength=1e4)
        given = replace(given, soil=replace(given.soil, material=clay))
    given = replace(given, stages=(replace(given.stages[0], steps=4, loads=loads, gravity=gravity),))
    simulation = build(given)
    state, workspace = replace(simulation.state, time=1.0 * after, step=after), Workspace(simulation.model)
    step = begin(simulation.stage_model(0, 0.0), state, 1.0, False, workspace)
    outcome = SimpleNamespace(evaluation=step.evaluate(step.at_rest()), reason=reason, errors=(1.0, 1.0))
    text = advice(step, outcome, Solver())
    workspace.destroy()
    return text


GROWING = ((0.0, 0.0, 0.0, -180e3), (4.0, 60e3, 0.0, -180e3))


def test_a_load_that_grows_is_the_first_cause_with_the_value_it_had_reached():
    text = loaded(GROWING, after=2)
    assert text.startswith("The load exceeds what the soil can carry: that on body had reached fx = 30, fz = -180 kN at "
                           "t = 2 s")
    assert "Otherwise use a smaller time.step with more stage.steps" in text and text.count("what the soil can carry") == 1
    assert "had reached 0 N" in loaded(((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 0.0, -180e3)))
    assert loaded(None, moment=((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 6e3, 0.0)), after=2).startswith(
        "The load exceeds what the soil can carry: that on body had reached my = 3 kN m at t = 2 s")
    assert "had reached fx = 30, fz = -180 kN, mx = 8 N m at" in loaded(GROWING, moment=(8.0, 0.0, 0.0), after=2)
    assert "had reached" not in loaded(GROWING, time=Time(step=0.01))
    assert "had reached" not in loaded(GROWING, held=("x", "y", "z"))


def test_elastic_soil_carries_every_load_but_those_along_it():
    """Only friction is exceeded there."""
    for force in (((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 0.0, -180e3)), (0.0, 0.0, -180e3), None):
        assert "the soil can carry" not in loaded(force, elastic=True) and "had reached" not in loaded(force, elastic=True)
    assert "had reached" not in loaded(None, gravity=(0.0, 1.2), after=2, elastic=True)
    assert "had reached" not in loaded(GROWING, after=2, elastic=True, held=("x",))
    assert loaded(GROWING, after=2, elastic=True).startswith(
        "The load exceeds what friction on the elastic soil can carry: that on body had reached fx = 30")
    text = loaded((0.0, 0.0, -180e3), elastic=True)
    assert "acts at once, and the first step may not find its equilibrium: let the load grow" in text
    assert "how much is carried" not in text


def test_a_load_that_acts_at_once_upwards_may_have_the_wrong_sign():
    text = loaded((0.0, 0.0, 200e3))
    assert "It pulls body up: z points up, so that fz = 200000 N should be negative if it presses down" in text
    assert "It pulls" not in loaded((0.0, 0.0, 30.0)) and "It pulls" not in loaded((0.0, 0.0, -200e3))


def test_gravity_that_grows_is_named_with_the_share_reached():
    assert loaded(None, gravity=(0.0, 1.2), after=2).startswith(
        "The load exceeds what the soil can carry: gravity had reached 0.6 of the whole")


def test_a_load_that_acts_at_once_should_grow():
    """Shorter increments of it are all the same; one that has been carried before is no cause."""
    text = loaded((30e3, 0.0, -180e3))
    assert text.startswith("The load on body, fx = 30, fz = -180 kN, acts at once")
    assert "force = [[0, 0, 0, 0], [T, 30000, 0, -180000]]" in text
    assert "time.step with" not in text and "a lower body.penalty" in text
    assert "acts at once" not in loaded((30e3, 0.0, -180e3), after=1)


def test_a_body_that_a_sudden_load_throws_off_is_told_to_let_it_grow_first():
    """As a singular matrix it is no sign of a load that the soil cannot carry where that grows."""
    singular = "linear solver: the direct factor finds the matrix singular"
    text = loaded((30e3, 0.0, -180e3), reason=singular, rest_on=0.1)
    assert text.startswith("The load on body") and "No point of the soil touches" in text
    assert "shorter increments" not in text
    assert "a smaller time.step" not in text
    assert "had reached" not in loaded(GROWING, reason=singular)


def test_a_load_that_lifts_a_body_off_is_the_one_cause_and_no_overload():
    """Not where soil above the body holds it down, or where its weight does."""
    text = loaded(((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 0.0, 4e3)), rest_on=0.1)
    assert text.startswith("The load on body, fz = 1 kN, is larger than its weight, 78.5 N, and lifts it off the soil")
    assert "Change its sign" in text
    assert "No point" not in text and "exceeds what the soil can carry" not in text
    assert "exceeds what the soil can carry: that on body" in loaded(((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 0.0, 4e3)))
    assert "No point" in loaded(((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 0.0, 40.0)), rest_on=0.1)


def test_a_held_body_beside_soil_is_told_to_reach_into_it():
    """A wall that just touches sand has no contact yet, and no freedom that rest_on or shorter steps could help."""
    text = loaded(None, rest_on=0.1, held=("x", "y", "z", "rx", "ry", "rz"))
    assert "body, held or driven, so that soil that leans on it has no support" in text and "0.002 m (body.position)" in text
    assert "body.rest_on" not in text


@pytest.mark.parametrize("table, offered",
                         [({"friction": 0.4, "tangential": 3.0}, True), ({"friction": 0.4}, False), ({}, False)])
def test_softer_tangential_springs_are_offered_where_contact_sticks(table, offered):
    model = quasi_static(bodies=[box(0.2, 0.2, 0.2, rest_on=0.0, **table)])
    assert any("body.tangential = 0.3" in change
               for change in remedies(model, "residual 1e-3 after 15 iterations", (1.0, 1e-2), 1e-6)) == offered


def test_soil_out_of_balance_at_the_start_is_the_cause():
    """Free at its sides, as on two bodies that carry it; not where it is held, or once the run has begun."""
    clay = Material(law="von-mises", young=1e6, poisson=0.3, density=1800.0, strength=1e4)

    def described(**values):
        one = soil_scene(gravity=(0.0, 0.0, -9.81), geostatic=True, time=Time(step=1.0, inertia=False), **values)
        return replace(one, soil=replace(one.soil, material=clay))

    for faces, told in (({"faces": Faces(x_min="free", x_max="free", z_min="fixed")}, True), ({}, False)):
        simulation = build(described(**faces))
        step = begin(simulation.model, simulation.state, 1.0, False, Workspace(simulation.model))
        assert any("turn gravity on in a first stage" in text for text in _unbalanced(step)) == told
    simulation.state.time = 1.0
    assert not list(_unbalanced(begin(simulation.model, simulation.state, 1.0, False, Workspace(simulation.model))))


@pytest.mark.parametrize("cohesion, geostatic, named", [(0.0, False, True), (200.0, False, False)])
def test_sand_without_cohesion_and_stress_is_told_to_have_some(cohesion, geostatic, named):
    """A thousandth of the stress under 0.4 m of 1600 kg/m³."""
    scene = soil_scene(gravity=(0.0, 0.0, -9.81), time=Time(1.0, inertia=False), geostatic=geostatic)
    sand = Material(law="mohr-coulomb", young=2e7, poisson=0.3, density=1600.0, friction_angle=30.0, dilation_angle=0.0,
                    cohesion=cohesion)
    turned_on = (Stage("fill", 2, gravity=(0.0, 1.0)),)
    simulation = build(replace(scene, soil=replace(scene.soil, material=sand), stages=turned_on))
    step = begin(simulation.model, simulation.state, 1.0, False, Workspace(simulation.model))
    causes = [text for text in probable_causes(step, step.evaluate(step.at_rest())) if "Sand without cohesion" in text]
    assert len(causes) == named and all("soil.material.cohesion = 5 Pa" in text for text in causes)
