"""Newton's method where contact points jump between facets of a body: they are held to one of them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.body.surface import build_surface
from hybrid.contact import held_facets, soil_to_body
from hybrid.linalg.system_cache import CarriedTangent
from hybrid.runtime.data import DEMOS
from hybrid.runtime.errors import StepError
from hybrid.scene import Solver
from hybrid.scene.file import load_scene
from hybrid.setup.build import build
from hybrid.simulation import Simulation
from hybrid.step import contacts, iteration, newton, rejection, sticking
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import box, soil_scene


def ride(start, aside, mu, steps=25):
    """Records of a sphere on a slope of 30 degrees: demos/rolling_sphere.toml from `start` and `aside` [m] of its row,
    with plane facets that touch corners, on which stiff springs push it to and fro."""
    simulation = build(load_scene(DEMOS / "rolling_sphere.toml", [
        f"stage.0.steps={steps}", f"body.0.friction={mu}", "gravity=[4.905, 0.0, -8.4957]",
        f"body.0.position=[{0.6 + start}, {2.5625 + aside}, 0.0]", "body.0.contact=corners",
        "body.0.penalty=20.0", "body.0.tangential=2.0", "time.beta=0.5625", "time.gamma=1.0"]))
    (body,), (mesh,) = simulation.model.bodies, simulation.meshes
    plane = replace(body, surface=build_surface(mesh.points - body.mass.centre, mesh.contact))
    return list(Simulation(simulation.scene, replace(simulation.model, bodies=(plane,)), simulation.state,
                           simulation.meshes).steps())


MODEL = SimpleNamespace(solver=Solver(), soil=SimpleNamespace(law=SimpleNamespace(plastic=True)),
                        scheme=SimpleNamespace(inertia=True))
ROW = [0.125 * n / 16 for n in (7, 9, 11)]


def failures():
    """Number of rides over the row that fail."""
    failed = 0
    for start in ROW:
        try:
            ride(start, -0.06249, 0.3)
        except StepError as error:
            failed += 1
            assert "residual" in str(error)
    return failed


def test_a_sphere_that_rolls_over_a_row_of_corners_is_solved(monkeypatch):
    """The corners of the row lie under an edge between two facets, whose normals differ by 8 degrees: the tangential
    spring of each facet pushes them to the other one, with increments of any length. Friction reverses there, too."""
    monkeypatch.setattr(rejection, "friction_reverses", lambda step, evaluation: "")
    assert [sum(r.rejections for r in ride(start, -0.06249, 0.3)) for start in ROW] == [0, 0, 0]
    monkeypatch.setattr(newton, "HOLDS", 0)
    assert failures() >= 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_a_sphere_is_solved_from_any_start(seed, monkeypatch):
    monkeypatch.setattr(rejection, "friction_reverses", lambda step, evaluation: "")
    start, aside = np.random.default_rng(seed).uniform(0.0, 0.125, 2)
    for mu in (0.1, 0.3):
        assert sum(r.rejections for r in ride(start, aside if seed % 2 else -0.0625, mu, 60)) == 0


def test_jumps_that_smoothing_takes_back_count(monkeypatch):
    """Each update sends a corner to the other facet, and the solution of the few nodes around it brings it back: from one
    iterate to the next nothing has changed."""
    terms = SimpleNamespace(step=SimpleNamespace(body=SimpleNamespace(surface=None)))

    def at(facet):
        return SimpleNamespace(error=1.0, bodies=[terms], contacts=[facet], soil=None, body=None, unknowns=facet, norms={})

    system = SimpleNamespace(solve=lambda *system: (None, None, 1), soil_unknowns=1)
    step = SimpleNamespace(model=MODEL, system=system, assemble=lambda *tangent: None, carried=CarriedTangent(), dt=0.1)
    monkeypatch.setattr(contacts, "stiffness_ratio", lambda step: 0.0)
    monkeypatch.setattr(sticking, "reversing", lambda *evaluations: None)
    monkeypatch.setattr(sticking, "drifting", lambda *evaluations: None)
    monkeypatch.setattr(held_facets, "switched", lambda before, after, surface: before != after)
    monkeypatch.setattr(iteration, "line_search", lambda *search: (at("the other one"), 1.0))
    monkeypatch.setattr(iteration, "smoothed", lambda *few: at("one"))
    assert iteration.iterate(step, at("one"), iteration.Updates(iteration.PATIENCE)).jumping
    monkeypatch.setattr(iteration, "line_search", lambda *search: (at("one"), 1.0))
    assert not iteration.iterate(step, at("one"), iteration.Updates(iteration.PATIENCE)).jumping


@pytest.mark.parametrize("facets, tried", [([1, 1, 1], 1), ([1, 2, 1, 1], 3), (range(newton.HOLDS), newton.HOLDS)])
def test_corners_are_not_held_twice_to_the_same_facets(monkeypatch, facets, tried):
    """From the same iterate with the same facets nothing else would come out."""
    calls, facets = [], iter(facets)
    best = SimpleNamespace(unknowns=None, error=1.0)
    failed = iteration.Outcome(best, 1, 1, (1.0,), "residual", jumping=True)
    step = SimpleNamespace(bodies=(), evaluate=lambda unknowns: best, within_rounding=lambda best: False, model=MODEL)
    monkeypatch.setattr(contacts, "facet_error", lambda evaluation: 0.0)
    monkeypatch.setattr(contacts, "hold_facets", lambda evaluation: [np.array([next(facets)])])
    monkeypatch.setattr(newton, "_newton", lambda *start: failed)
    monkeypatch.setattr(newton, "iterate", lambda *start: calls.append(start) or failed)
    assert not newton._solution(step, best, newton.AMBIGUOUS).converged and len(calls) == tried


def test_a_corner_between_two_facets_is_carried_by_either_in_a_short_increment(monkeypatch):
    """Held to one, its overlap with the other is smaller by three quarters; at full length that is refused."""
    best, held = SimpleNamespace(unknowns=None, error=0.0), []
    step = SimpleNamespace(bodies=(), evaluate=lambda unknowns: best, model=MODEL)
    monkeypatch.setattr(contacts, "facet_error", lambda evaluation: 0.75 if held else 0.0)
    monkeypatch.setattr(contacts, "hold_facets", lambda evaluation: held.append(0) or [np.zeros(1)])
    monkeypatch.setattr(newton, "_newton", lambda *start: iteration.Outcome(best, 9, 9, (1.0,), "residual", jumping=True))
    monkeypatch.setattr(newton, "iterate", lambda *start: iteration.Outcome(best, 2, 2, (1.0,)))
    refused = newton._solution(step, best, newton.AMBIGUOUS)
    assert "jump between facets" in refused.reason and len(held) == newton.HOLDS
    held.clear()
    outcome = newton._solution(step, best, newton.BETWEEN)
    assert outcome.converged and outcome.judged and outcome.iterations == 11 and len(held) == 1


def test_corners_are_held_only_where_the_facet_is_as_near_as_any(monkeypatch):
    """Where no share of the overlap is allowed, the increments are refused."""
    monkeypatch.setattr(newton, "AMBIGUOUS", 0.0)
    rejected = []
    solve = newton.solve
    monkeypatch.setattr(newton, "solve", lambda *given, **how: rejected.append(solve(*given, **how)) or rejected[-1])
    try:
        ride(ROW[2], -0.06249, 0.3)
    except StepError:
        pass
    assert any("jump between facets" in outcome.reason for outcome in rejected)


def test_held_corners_are_on_the_planes_of_their_facets():
    """Gap, normal and force are those of the plane, also where another facet is the nearest; and released again."""
    plate = box(0.4, 0.4, 0.2, rest_on=-0.004, position=(0.4, 0.4, 0.0), contact="corners")
    simulation = build(soil_scene([plate]))
    workspace = Workspace(simulation.model)
    step = begin(simulation.model, simulation.state, 0.01, False, workspace)
    body = step.bodies[0]
    resting = step.evaluate(step.at_rest())
    contacts.hold_facets(resting)
    assert contacts.facet_error(resting) == 0.0
    assert (body.pair.points.facet >= 0).sum() == (resting.contacts[0].gap < -1e-6).sum()
    # 18 cm to the side some corners are nearer to the flank than to the bottom, but still held to it
    position, rotation = body.state.pose
    pose = position + (0.198, 0.0, 0.0), rotation
    held = body.pair.evaluate(step.at_rest().displacement, pose)
    pressed = held.gap < -1e-6      # others just touch a flank
    assert np.allclose(held.normal[pressed], (0.0, 0.0, -1.0)) and np.allclose(held.gap[pressed], -0.004)
    assert body.pair.facet_error(held, step.at_rest().displacement, pose) > newton.AMBIGUOUS
    contacts.release_facets(step)
    free = body.pair.evaluate(step.at_rest().displacement, pose)
    assert not np.allclose(free.normal, (0.0, 0.0, -1.0)) and held_facets.switched(free, held, body.body.surface)
    assert isinstance(free, soil_to_body.PointContact) and not held_facets.switched(held, held, body.body.surface)
    workspace.destroy()
