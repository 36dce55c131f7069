"""A vertical cut in clay under growing gravity, without inertia: reported where it fails, and not where it stands or
settles.

It stands up to γ H / s_u = 3.78 by limit analysis, and up to 4.27 on 8 cells in its height.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from put_on_soil import put_on_soil

from hybrid.monitors.flowing_soil import FLOWS, FlowingSoil
from hybrid.monitors.monitor import StepView
from hybrid.scene import Axis, Faces, Grid, Material, Motion, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import box, soil_scene, steel

HEIGHT, CELLS, WEIGHT = 4.0, 8, 1800 * 9.81
(_, LIMIT), (_, LONG) = FLOWS


def cut(number, steps=10, young=5e6, hold=0, law="von-mises"):
    """Scene of a cut with γ H / s_u = number; gravity grows in `steps` and stays for another `hold`."""
    strength = {"strength": WEIGHT * HEIGHT / number} if law == "von-mises" else {}
    grid = Grid(Axis(start=-1.5 * HEIGHT, end=2 * HEIGHT, size=HEIGHT / CELLS), Axis(start=0.0, end=1.0, collapsed=True),
                Axis(start=-HEIGHT, end=1.25 * HEIGHT, size=HEIGHT / CELLS), Faces(z_min="fixed"))
    soil = Soil(Material(law=law, young=young, poisson=0.49, density=1800.0, **strength), top=HEIGHT,
                ground=((0.0, 0.0), (0.001, HEIGHT)), geostatic=False)
    stages = Stage("on", steps, gravity=(0.0, 1.0)), *([Stage("hold", hold)] if hold else [])
    return Scene(name="cut", grid=grid, soil=soil, time=Time(1.0, inertia=False), stages=stages)


def notes(scene):
    """(Notes about flow, the same with the values of the last step) of a run."""
    simulation = build(scene)
    found = [text for record in simulation.steps() for text in record.notes if "flows under its weight" in text]
    return found, [simulation.later_notes.get(text, text) for text in found]


@pytest.mark.parametrize("changes", [{"number": 6}, {"number": 6, "steps": 40}, {"number": 4.5},
                                     {"number": 4.5, "young": 1e8, "hold": 5}])
def test_a_cut_that_cannot_stand_is_reported(changes):
    """Whatever the number of steps; stiff clay has flowed by 0.007 of its height only, 1.4 times the limit."""
    found, last = notes(cut(**changes))
    assert len(found) == 1 and f"limit {LIMIT:g}" in found[0] and "time.inertia = true" in found[0]
    if changes == {"number": 6}:
        assert "from t = 7 to 8 s" in found[0] and "from t = 7 to 10 s" in last[0] and "began to flow at t = 7 s" in last[0]


@pytest.mark.parametrize("changes", [{"number": 3}, {"number": 3, "steps": 40, "hold": 3}, {"number": 4},
                                     {"number": 3, "young": 1e6},
                                     {"number": 3.5, "young": 1e8, "hold": 5}, {"number": 3, "young": 1e6, "law": "hencky"}])
def test_a_cut_that_stands_is_not(changes):
    """Also where soft soil settles by a twentieth of the height of the cut."""
    assert notes(cut(**changes)) == ([], [])


def test_clay_that_springs_back_under_a_lifted_footing_is_not():
    """Its elastic energy is given back in the steps in which the footing goes, and some of it yields."""
    clay = Material(law="von-mises", young=1e6, poisson=0.45, density=1700.0, strength=10e3)
    strip = box(1.2, 1.0, 0.3, density=2000.0, position=(0.0, 0.5, 0.0), rest_on=0.0, held=("x", "ry"), driven=("z",),
                velocity=(0.0, 0.0, -0.005), friction=0.3)
    scene = put_on_soil(strip, size=0.125, x=(0.0, 2.0), z=(-1.0, 0.25), material=clay)
    lift = Stage("lift", 4, motions=(Motion(component="z", velocity=0.05),))
    assert notes(replace(scene, gravity=(0.0, 0.0, -9.81), stages=(Stage("press", 10), lift))) == ([], [])


# ------------------------------------------------------------------ steps made up


def seen(*steps, inertia=False, first=1):
    """Number of notes about steps (displacement of the soil, of a box over it [m], its contacts, plastic work of the step
    [J]) of clay 0.4 m high that stores 1 J in each; first: number of the first one, in a run that is resumed before
    it."""
    clay = Material(law="von-mises", young=1e6, poisson=0.3, density=1800.0, strength=1e4)
    scene = soil_scene([steel(0.2, 0.2, 0.2, position=(0.4, 0.4, 0.0), rest_on=0.1)], gravity=(0.0, 0.0, -9.81),
                       time=Time(1.0, inertia=inertia))
    simulation = build(replace(scene, soil=replace(scene.soil, material=clay)))
    model, state = simulation.model, simulation.state
    monitor, notes = FlowingSoil(model, state), 0
    energy = {"plastic": 0.0, "elastic": model.soil.stored_energy(state.points)}
    for number, (moved, body, contacts, plastic) in enumerate(steps, first):
        motion = replace(state.bodies[0], position=state.bodies[0].position + np.array([body, 0.0, 0.0]))
        state = replace(state, bodies=[motion], step=number)
        energy = {"plastic": energy["plastic"] + plastic, "elastic": energy["elastic"] + 1.0}
        report = SimpleNamespace(moved=moved, evaluation=SimpleNamespace(contacts=[range(contacts)]))
        notes += len(monitor.notes(StepView(model, state, model.scheme, report, energy)))
    return notes


FLOW = (0.6 * LIMIT * 0.4, 0.0, 1, 10.0)    # two of these are too much
REST = (0.0, 0.0, 1, 0.0)


def test_only_soil_that_moves_by_itself_far_without_inertia_and_dissipates_is_reported():
    assert seen(FLOW, FLOW, FLOW) == 1
    assert seen(FLOW) == 0 and seen((0.1, 0.0, 1, 0.5)) == 0 and seen(FLOW, FLOW, inertia=True) == 0


def test_soil_that_comes_to_rest_in_between_has_not_failed():
    assert seen(FLOW, REST, FLOW) == 0 and seen(FLOW, FLOW, REST, FLOW) == 1


@pytest.mark.parametrize("body, contacts, reported", [(0.02, 1, 0), (0.001, 1, 1), (0.02, 0, 1)])
def test_soil_that_a_body_moves_is_not(body, contacts, reported):
    """Not where the body hardly moves or does not touch it."""
    assert seen((0.1, body, contacts, 10.0)) == reported



def test_a_run_that_is_resumed_is_judged_from_its_second_step_on():
    """The first one has no step before it to compare its energy with."""
    assert seen(FLOW, FLOW, first=5) == 0 and seen(FLOW, FLOW, FLOW, first=5) == 1


def test_soil_that_stores_a_third_of_what_it_dissipates_flows_on_a_longer_way():
    """As a slope near failure that yields in a part of it; where gravity grows, what all of the soil stores hides flow."""
    slow = 0.3 * LONG * 0.4, 0.0, 1, 3.0
    assert seen(*[slow] * 3) == 0 and seen(*[slow] * 4) == 1
