"""The monitor of impacts between bodies: what is lost over some steps is reported, and what is held back for a while is
not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.impacts import QUIET, BodyImpact, GroundImpact, LastImpact, _free_energy
from hybrid.state import BodyState


def moving(*velocity):
    """BodyState of a body at the origin with a velocity [m/s], which does not turn."""
    return BodyState(np.zeros(3), np.eye(3), np.array(velocity), *np.zeros((3, 3)))


def notes(errors, in_contact=(), near=(), touching=0, pairs=1, accuracy=None, monitor=None, held=False, free=False,
          along=0.0, gravity=0.0, begun=False, **scheme):
    """Of steps with these errors [J] of a body of 2 kg with 10 m/s, 100 J, and of one that stands still, both of which fly
    `along`; in_contact, near: steps at whose ends bodies press, or are near one another; touching: number of contacts with
    the soil; free: whether both are; begun: whether the monitor knows of the motion before the first step."""
    body = SimpleNamespace(mass=SimpleNamespace(mass=2.0, inertia=np.eye(3)), free=np.array([True, *[free] * 5]),
                           radius=0.5)
    motions = [moving(speed + along, 0.0, 0.0) for speed in (10.0, 0.0)]
    law = SimpleNamespace(plastic=False)
    model = SimpleNamespace(bodies=(body, body), pairs=(None,) * pairs, soil=SimpleNamespace(held=held, law=law),
                            gravity=np.array([0.0, 0.0, -gravity]))
    known = (model, SimpleNamespace(bodies=motions)) if begun else (None, None)
    monitor, found = monitor or BodyImpact(*known), []
    for step, error in enumerate(errors):
        of_pairs = SimpleNamespace(energy=1.0 * (step in in_contact), contacts=(None,) * (step in {*in_contact, *near}))
        report = SimpleNamespace(error=accuracy, evaluation=SimpleNamespace(contacts=(range(touching),), pairs=of_pairs))
        found += monitor.notes(StepView(
            model=model, state=SimpleNamespace(time=float(step), bodies=motions),
            scheme=SimpleNamespace(**{"inertia": True, "first_order": False} | scheme), report=report,
            energy={"error": error}, last=step == len(errors) - 1))
    return found


AFTER = [-13.0] * (QUIET + 1)


def test_an_impact_within_a_step_or_over_some_is_reported_once():
    for errors, in_contact in (([0.0, 0.0, *AFTER, *AFTER], ()), ([0.0, -4.0, -9.0, *AFTER], (1, 2))):
        text, = notes(errors, in_contact, near=(0, 1, 2))
        assert "13 J of the 100 J" in text and "(13%, limit 12%)" in text and "smaller time.step" in text
        assert "time.accuracy = 1e-4" in text
    assert "a smaller time.accuracy" in notes([0.0, 0.0, *AFTER], near=(0, 1, 2), accuracy=1e-6)[0]


def test_after_soil_has_been_touched_waves_in_it_go_on_while_bodies_are_in_the_air():
    """A ram that hits a cap again as both have left the soil: judged as on it, and coarse cells may be the cause."""
    monitor = BodyImpact(None, None)
    assert notes([0.0] * 3, touching=1, monitor=monitor) == []
    assert notes([0.0, -4.0, *AFTER], in_contact=(1,), monitor=monitor) == []
    text, = notes([-13.0, -30.0, *[-50.0] * 8], in_contact=(1,), monitor=monitor)
    assert "limit 30%" in text and "cells too coarse for waves in the soil" in text


@pytest.mark.parametrize("along", [0.0, 3.0, 1e3])
def test_an_impact_in_flight_is_judged_by_the_motion_of_bodies_relative_to_one_another(along):
    """Half of the energy of one that hits another one of its mass takes part, whatever frame they fly in."""
    text, = notes([0.0, -4.0, -6.5, *[-6.5] * 8], in_contact=(1, 2), near=range(12), free=True, along=along)
    assert "6.5 J of the 50 J" in text and "(13%, limit 12%)" in text
    assert notes([0.0, -4.0, -5.5, *[-5.5] * 8], in_contact=(1, 2), near=range(12), free=True, along=along) == []
    text, = notes([-6.5] * 8, in_contact=(0,), free=True, along=along, begun=True)      # in the first step
    assert "6.5 J of the 50 J" in text


def test_free_bodies_on_soil_are_judged_by_all_of_their_motion():
    text, = notes([0.0, 0.0, *[-40.0] * 9], in_contact=(2,), touching=3, free=True)
    assert "40 J of the 100 J" in text


def test_an_impact_above_held_ground_is_none_on_it():
    assert len(notes([0.0, 0.0, *AFTER], near=(1,), held=True)) == 1


def test_an_impact_is_judged_when_nothing_is_lost_any_more():
    """That of bodies which stay near one another counts once."""
    monitor = BodyImpact(None, None)
    text, = notes([0.0, *range(-4, -36, -4), *[-32.0] * 20], in_contact=(1,), near=range(30), monitor=monitor)
    assert "32 J of the 100 J" in text and not monitor.later()


def test_bodies_that_are_laid_on_one_another_hit_nothing():
    """Their springs settle: less than a hundredth of what the bodies would gain by falling by their radius."""
    lost = [0.0, 0.0, *AFTER, *AFTER]
    assert notes(lost, near=(0, 1, 2)) and not notes(lost, near=(0, 1, 2), gravity=9.81e4)


def test_energy_that_bodies_gain_by_an_impact_is_reported():
    gain = [0.0, 4.0, 13.0, *[13.0] * 8]
    text, = notes(gain, in_contact=(1, 2), near=range(12))
    assert "13 J were added to the 87 J" in text and "(15%, limit 12%)" in text and "quarter of the time.step" in text
    monitor = BodyImpact(None, None)
    assert notes(gain + [13.0] * 9, in_contact=(1, 2), near=range(20), monitor=monitor) and not monitor.later()
    assert notes([0.0, 40.0, *[5.0] * 9], in_contact=(1,), near=range(12)) == []        # comes back
    assert notes(gain, near=range(12)) == notes(gain, in_contact=(1, 2), near=range(12), touching=3) == []


def test_energy_that_the_scheme_holds_back_is_not_lost():
    assert notes([0.0, -40.0, -30.0, *[-8.0] * 8], in_contact=(1,)) == []
    assert notes([0.0, *[-40.0] * 10], in_contact=range(11)) == []      # still pressed together


@pytest.mark.parametrize("held, touching", [(True, 3), (False, 0)])
def test_a_run_that_ends_in_an_impact_says_what_it_has_cost_so_far(held, touching):
    """And a run that goes on from there knows nothing of it."""
    pressed = {"in_contact": range(5), "touching": touching, "held": held}
    text, = notes([0.0, 0.0, -80.0, -40.0], monitor=(monitor := LastImpact(None, None)), **pressed)
    assert text.startswith("impact of bodies in which the run ends: 40 J of the 100 J") and "limit 24%" in text
    assert not {"_lost", "_given"} & set(monitor.memory())
    assert notes([0.0, 0.0, -80.0, -20.0], monitor=LastImpact(None, None), **pressed) == []
    assert notes([0.0, 0.0, *[-40.0] * 8], near=(2,), monitor=LastImpact(None, None)) == []      # nothing was pressed
    assert notes([0.0, -80.0, -40.0], in_contact=range(5), touching=3, monitor=LastImpact(None, None)) == []


def test_losses_of_two_impacts_add_up_while_bodies_stay_near_and_not_when_they_were_apart():
    first, second = [0.0, *[-8.0] * 8], [-16.0] * 8
    assert len(notes(first + second, near=range(17))) == 1
    assert notes(first + second, near=(1, 9)) == []


def test_impacts_that_are_reported_add_up_at_the_end():
    monitor = BodyImpact(None, None)
    given, = notes([0.0, *AFTER, *[-30.0] * 8, *[-31.0] * 8], near=(1, 8), monitor=monitor)
    assert "13 J of the 100 J" in given and "30 J of the 100 J" in monitor.later()[given]
    assert "(30%, limit 12%)" in monitor.later()[given]
    given, = notes([0.0, *[-90.0] * 8, *[-180.0] * 8], monitor=(monitor := BodyImpact(None, None)))
    # bodies that gravity drives
    assert "180 J of the 180 J" in monitor.later()[given] and "(100%" in monitor.later()[given]


def test_bodies_that_hit_one_another_on_soil_are_told_of_larger_losses():
    """Soil that deforms takes some of their energy, and all of what is lost before they have come near; `GroundImpact` has
    held ground."""
    lost = [0.0, 0.0, -40.0, *[-40.0] * 8]
    text, = notes(lost, in_contact=(2,), touching=3)
    assert "40 J of the 100 J" in text and "(40%, limit 30%)" in text
    assert notes(lost, touching=3) == notes(lost, in_contact=(2,), touching=3, held=True) == []
    assert notes(lost, near=(1, 2, 3), touching=3) == []
    assert notes([0.0, 0.0, *[-25.0] * 8], in_contact=(2,), touching=3) == []
    # a little at each of two touches of bodies that stay near one another
    assert notes([0.0, 0.0, *[-20.0] * 8, *[-40.0] * 8], in_contact=(2, 10), near=range(18), touching=3) == []


def on_ground(errors, touching=(), held=True, radius=0.5, gravity=9.81, in_contact=(), near=(), plastic=True, speeds=None,
              load=0.0, falls=0.0, rubbed=0.0, **scheme):
    """The same of the monitor of held ground, for a body that touches it at the steps `touching`; speeds: its own [m/s];
    load: work of loads in a step [J]; falls: [m/s] downwards; rubbed: [J] that friction has taken from the tenth step on."""
    body = SimpleNamespace(mass=SimpleNamespace(mass=2.0, inertia=np.eye(3)), free=np.ones(6, bool), radius=radius)
    monitor, found = GroundImpact(None, None), []
    for step, error in enumerate(errors):
        pairs = SimpleNamespace(energy=1.0 * (step in in_contact), contacts=(None,) * (step in near))
        report = SimpleNamespace(error=None, evaluation=SimpleNamespace(contacts=(range(step in touching),), pairs=pairs))
        motion = moving(speeds[step] if speeds else 10.0, 0.0, -falls)
        soil = SimpleNamespace(held=held, law=SimpleNamespace(plastic=plastic))
        model = SimpleNamespace(bodies=(body,), pairs=(), soil=soil, gravity=np.array([0.0, 0.0, -gravity]))
        found += monitor.notes(StepView(model, SimpleNamespace(time=float(step), bodies=(motion,)),
                                        SimpleNamespace(**{"inertia": True, "first_order": False} | scheme), report,
                                        {"error": error, "load": load * step, "friction": rubbed * (step >= 10)}))
    return found, monitor.later()


def test_an_impact_on_held_ground_is_reported_with_all_that_follow():
    found, later = on_ground([0.0, 0.0, -40.0, *[-44.0] * 8, *[-66.0] * 8, -67.0], touching=(2, 3, 11))
    text, = found
    assert text.startswith("impact on held ground: 44 J of the 100 J") and "(44%, limit 12%)" in text
    assert "smaller time.step" in text
    assert "66 J of the 100 J" in later[text] and "time.accuracy = 1e-4" in text


@pytest.mark.parametrize("forwards, falls, words", [
    (0.0, 10.0, "44 J of the 100 J"), (60.0, 10.0, "44 J of the 100 J"), (60.0, 2.0, None)])
def test_what_is_left_of_the_way_along_the_ground_takes_no_part_in_an_impact(forwards, falls, words):
    """A ball that falls and one that is thrown; one that grazes the ground, of whose motion 1 % is lost."""
    found, _ = on_ground([0.0] * 10 + [-40.0] + [-44.0] * 8, touching=(10, 11), speeds=[forwards] * 19, falls=falls)
    assert [words in text for text in found] == ([True] if words else [])


def test_what_friction_takes_along_the_ground_takes_no_part_in_an_impact():
    """A thrown ball is slowed down from 60 to 50 m/s, by 1 100 J: by friction, or by what is lost."""
    slowed = {"touching": (10, 11), "speeds": [60.0] * 10 + [50.0] * 9, "falls": 10.0}
    lost = [0.0] * 10 + [-40.0] + [-44.0] * 8
    assert on_ground(lost, **slowed)[0] == []
    for rubbed in (1100.0, 2000.0):     # it falls with 100 J, whatever friction has taken
        text, = on_ground(lost, rubbed=rubbed, **slowed)[0]
        assert "44 J of the 100 J" in text


def test_on_elastic_soil_as_well():
    elastic = {"held": False, "plastic": False, "touching": range(30), "speeds": [60.0] * 19, "falls": 10.0}
    text, = on_ground([0.0] * 10 + [-40.0] + [-44.0] * 8, **elastic)[0]
    assert text.startswith("impact on elastic soil: 44 J of the 100 J")


def test_what_bodies_lose_by_one_another_in_the_air_is_not_of_the_ground_on_which_they_land():
    """`BodyImpact` has it: two balls that hit one another and fall on the ground three steps later."""
    assert on_ground([0.0, -40.0, -44.0, *[-44.0] * 12], touching=range(5, 15), in_contact=(1, 2)) == ([], {})


@pytest.mark.parametrize("where", [{"in_contact": (1,)}, {"near": (2,)}])
def test_a_body_on_held_ground_that_another_hits_is_told_as_that(where):
    """A ball hit by a driven one in steps of 2 ms lost 15 % in this way; one that falls afterwards hits the ground."""
    assert "44 J of" in on_ground([0.0, 0.0, *[-44.0] * 9], touching=range(12), in_contact=(1, 2))[0][0]     # in that step
    text, = on_ground([0.0, 0.0, -40.0, *[-44.0] * 8], touching=range(12), **where)[0]
    assert text.startswith("impact of bodies with one another on held ground: 44 J") and "time `check` shows" in text
    first, then = on_ground([0.0, 0.0, *[-44.0] * 8, *[-88.0] * 8], touching=range(20), **where)[0]
    assert first.startswith("impact of bodies") and then.startswith("impact on held ground")


def test_what_is_left_of_a_body_that_elastic_soil_brakes_is_no_impact():
    """A lid on a column that waves leave: 0.2 J of 2 J were lost at first, quietly, then all of the rest seemed lost."""
    elastic = {"held": False, "plastic": False, "touching": range(30)}
    late = [-0.8, *[-0.9] * 9]
    assert on_ground([0.0] * 10 + late, speeds=[10.0] * 2 + [1.0] * 18, **elastic) == ([], {})
    assert on_ground([0.0] * 10 + late, speeds=[1.0] * 20, **elastic | {"radius": 1e-3})[0]
    text, = on_ground([0.0, 0.0, *[-44.0] * 9], **elastic)[0]
    assert text.startswith("impact on elastic soil: 44 J of the 100 J")


def test_a_body_that_a_load_moves_on_elastic_soil_has_hit_nothing():
    """What is lost is little beside the work of the load: a plate on a column, of which waves go down."""
    elastic, lost = {"held": False, "plastic": False, "touching": range(30)}, [0.0, 0.0, *[-44.0] * 9]
    assert on_ground(lost, load=20.0, **elastic) == ([], {}) and on_ground(lost, load=1.0, **elastic)[0]


@pytest.mark.parametrize("other", [{"touching": ()}, {"held": False}, {"first_order": True}, {"inertia": False},
                                   {"in_contact": range(20)}, {"radius": 1e3}])
def test_other_losses_are_no_impact_on_held_ground(other):
    """In the air, on soil that yields, by schemes that damp, without inertia, by other bodies, of what settles on its
    springs."""
    assert on_ground([0.0, 0.0, *[-44.0] * 10], **{"touching": (2,)} | other) == ([], {})


@pytest.mark.parametrize("other", [{"touching": 3}, {"pairs": 0}, {"first_order": True}, {"inertia": False}])
def test_other_losses_are_no_impact_of_bodies(other):
    """On soil, without bodies that may touch, by schemes that are meant to damp, without inertia."""
    assert notes([0.0, 0.0, *AFTER], near=(1,), **other) == []


def test_what_drives_a_body_gives_it_back_what_it_loses():
    """The energy of a body that moves along a component that is not free is none that an impact could cost."""
    body = SimpleNamespace(mass=SimpleNamespace(mass=2.0, inertia=np.eye(3)), free=np.array([True, *[False] * 5]))
    along, across = (moving(*v) for v in ((10.0, 0.0, 0.0), (0.0, 0.0, 10.0)))
    assert _free_energy((body, body), (along, across)) == pytest.approx(100.0)
    assert _free_energy((body, body), (along, moving(10.0, 0.0, 1e-15))) == pytest.approx(200.0)    # held, with round-off
