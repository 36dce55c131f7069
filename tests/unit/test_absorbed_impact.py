"""The monitor of impacts: what falling bodies lose over many steps is reported, and what others bring or store is not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.absorbed_impact import AbsorbedImpact, least_energy


def notes(errors, elastic=0.0, plastic=True, first_order=False, inertia=True, monitor=None, gravity=9.81, then=0.0,
          until=99, speeds=(), held=False, pairs=None, **energy):
    """Of steps with these errors [J] of a body of 2 kg that falls with 10 m/s, 100 J, and stands still from the second
    step on, or has a speed `then`, or these speeds. Work from outside grows `until` a step."""
    body = SimpleNamespace(mass=SimpleNamespace(mass=2.0, inertia=np.eye(3)), radius=0.5)
    model = SimpleNamespace(bodies=(body,), soil=SimpleNamespace(held=held, law=SimpleNamespace(plastic=plastic)),
                            gravity=np.array([0.0, 0.0, -gravity]))
    monitor, found = monitor or AbsorbedImpact(None, None), []
    for time, error in enumerate(errors):
        velocity = np.array([0.0, 0.0, speeds[time] if speeds else then if time else -10.0])
        motion = SimpleNamespace(velocity=velocity, spin=np.zeros(3), rotation=np.eye(3))
        found += monitor.notes(StepView(
            model=model, state=SimpleNamespace(time=float(time), bodies=(motion,)),
            scheme=SimpleNamespace(inertia=inertia, first_order=first_order),
            report=SimpleNamespace(error=None, evaluation=SimpleNamespace(contacts=(None,), pairs=pairs)),
            energy={"kinetic": 0.0 if time else 100.0, "elastic": elastic, "contact": 0.0, "error": error}
            | {name: value * min(time, until) for name, value in energy.items()}))
    return found


PRESSED = SimpleNamespace(energy=1.0)


def test_small_losses_that_add_up_are_reported_once():
    assert notes([0.0, -7.0, -14.0]) == []
    text, = notes([0.0, -7.0, -16.0, -24.0])
    assert "16 J of the 100 J" in text and "t = 2 s (16%, limit 15%)" in text and "smaller cells" in text


def test_a_body_that_a_drive_has_lifted_is_judged_from_there_on():
    """30 % of the energy of a ram that was lifted and dropped were lost; so is what a drive does in each step not. One that
    moves another body by little work does not matter."""
    lifted = {"errors": [0.0, -40.0, -40.0, -70.0], "drive": 10.0, "speeds": [0.0, 0.0, -10.0, 0.0]}
    text, = notes(**lifted, until=1)
    assert "30 J of the 100 J" in text
    assert notes(**lifted) == []
    assert "40 J of the 101 J" in notes([0.0, -40.0], drive=1.0)[0]


def test_a_body_that_goes_on_has_hit_nothing():
    """A ball that rolls down clay ever faster; one that keeps a third of its energy has been stopped."""
    assert notes([0.0, -16.0, -24.0], then=-12.0) == [] and len(notes([0.0, -40.0], then=-5.7)) == 1


def test_the_cause_of_a_loss_is_that_of_the_first_text():
    """A large loss in one step, and many small ones in the waves that follow."""
    monitor = AbsorbedImpact(None, None)
    notes([0.0, -40.0, *np.linspace(-45.0, -90.0, 10)], monitor=monitor)
    (_, last), = monitor.later().items()
    assert "90 J of the 100 J" in last and "most of it in a single step" in last


def test_bodies_that_settle_are_no_impact():
    """100 J are less than a hundredth of what a heavy body gains as it falls by its radius."""
    assert notes([0.0, -40.0], gravity=9.81e4) == [] and notes([0.0, -40.0], gravity=0.0) != []


@pytest.mark.parametrize("other", [{"drive": 10.0}, {"pull": -10.0}, {"elastic": 150.0}, {"plastic": False},
                                   {"first_order": True}, {"inertia": False}, {"held": True}, {"pairs": PRESSED}])
def test_other_energies_make_no_impact(other):
    """Work from outside, soil that stores more than falls, elastic or held soil, schemes that are meant to damp, no inertia,
    bodies that still press one another."""
    assert notes([0.0, -40.0], **other) == []


def test_the_end_of_the_run_has_the_last_value_also_of_energy_that_comes_back():
    monitor = AbsorbedImpact(None, None)
    given, = notes([0.0, -16.0, -24.0, -22.0], monitor=monitor)
    (first, last), = monitor.later().items()
    assert first == given and "16 J of the 100 J" in first and "22 J of the 100 J" in last
    assert "t = 3 s (22%, limit 15%)" in last
    notes([0.0, -4.0], monitor=monitor)
    assert "4 J of the 100 J" in monitor.later()[given] and "(4%, within the limit 15%)" in monitor.later()[given]


def test_no_more_than_all_is_lost_and_the_motion_before_the_first_step_counts():
    """Bodies that fall again and again; an impact within the first step."""
    text, = notes([0.0, -157.0])
    assert "157 J of the 157 J" in text and "(100%, limit 15%)" in text
    body = SimpleNamespace(mass=SimpleNamespace(mass=2.0, inertia=np.eye(3)), radius=0.5)
    start = SimpleNamespace(velocity=np.array([0.0, 0.0, -20.0]), spin=np.zeros(3), rotation=np.eye(3))
    text, = notes([-200.0], monitor=AbsorbedImpact(SimpleNamespace(bodies=(body,)), SimpleNamespace(bodies=(start,))))
    assert "200 J of the 400 J" in text


def test_what_is_lifted_again_falls_again():
    """A ram that a drive has given 300 J more after the first note has had 400 J to lose."""
    monitor = AbsorbedImpact(None, None)
    notes([0.0, -20.0], monitor=monitor)
    notes([-20.0, -20.0, -20.0, -20.0, -60.0], monitor=monitor, drive=100.0, until=3)
    (_, last), = monitor.later().items()
    assert "60 J of the 400 J" in last


def test_an_impact_within_a_step_needs_smaller_steps_first_and_cells_then():
    text, = notes([0.0, -40.0])
    assert "most of it in a single step" in text and "Use a fifth of the time.step" in text
    assert text.endswith("where that hardly helps, as on clay, smaller cells at the bodies")


def test_soil_that_flows_fast_around_what_goes_on_is_reported():
    """A torpedo that has not slowed down: what is lost is compared with what the soil took."""
    text, = notes([0.0, -8.0, -12.0, -16.0], then=-10.5, friction=12.0)
    assert text.startswith("soil flows fast: 16 J of the 52 J") and "until t = 3 s" in text and "(31%, limit 20%)" in text
    monitor = AbsorbedImpact(None, None)
    notes([0.0, -8.0, -12.0, -16.0, -16.0], then=-10.5, friction=12.0, monitor=monitor)     # its share falls: nothing new
    assert not monitor.later()


@pytest.mark.parametrize("other", [{"friction": 40.0}, {"friction": 2.0}, {"drive": 10.0}, {"inertia": False},
                                   {"first_order": True}, {"gravity": 9.81e4}, {"pairs": PRESSED}])
def test_other_losses_are_none_of_soil_that_flows_fast(other):
    """Where soil took far more, or next to nothing, as from what rolls; of bodies that are driven; of damped settling; of
    bodies that are put down, or press one another."""
    assert notes([0.0, -8.0, -12.0, -16.0], then=-10.5, **{"friction": 12.0} | other) == []


def test_without_bodies_the_soil_must_have_fallen_by_some_of_its_height():
    """The shock of weight that acts at once on a block of 1 m was told as a flow that loses 73 % of its energy."""
    points = SimpleNamespace(position=np.array([[0.0, 0.0, 0.25], [0.0, 0.0, 0.75]]), half_width=np.full((2, 3), 0.25),
                             mass=np.array([800.0, 800.0]))
    model = SimpleNamespace(bodies=(), gravity=np.array([0.0, 0.0, -9.81]), soil=SimpleNamespace(constants=points))
    assert least_energy(model) == pytest.approx(0.01 * 1600.0 * 9.81)
