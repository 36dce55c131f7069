"""Monitors on steps made up for them: when each warns, how often, and with which values."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.body.attitude import exp_so3
from hybrid.body.rigid import FREEDOMS
from hybrid.monitors.domain_exit import DomainExit
from hybrid.monitors.lost_contact import LostContact
from hybrid.monitors.lost_points import LostPoints
from hybrid.monitors.monitor import Monitor, StepView
from hybrid.monitors.penetration import Penetration
from hybrid.monitors.untouched import Untouched
from hybrid.setup.build import build
from hybrid.study.scenes import soil_scene, steel


@pytest.fixture(scope="module")
def simulation():
    """A box of 0.2 m above the middle of elastic soil in a grid of 0.8 m."""
    return build(soil_scene([steel(0.2, 0.2, 0.2, position=(0.4, 0.4, 0.0), rest_on=0.1)]))


def view(simulation, state, contacts=()):
    report = SimpleNamespace(evaluation=SimpleNamespace(contacts=contacts, pairs=None))
    return StepView(simulation.model, state, simulation.model.scheme, report, {})


def test_a_monitor_gives_the_first_text_of_each_key():
    class Counting(Monitor):
        def warnings(self, view):
            yield from view

    monitor = Counting(None, None)
    assert monitor.notes([("a", "one"), ("b", "two"), ("a", "three")]) == ("one", "two")
    assert monitor.notes([("b", "four"), ("c", "five")]) == ("five",)
    assert monitor.given("a") and not monitor.given("d")


def test_what_grows_has_its_last_text_at_the_end():
    class Growing(Monitor):
        grows = True

        def warnings(self, view):
            yield from view

    monitor = Growing(None, None)
    assert monitor.notes([("a", "1 J"), ("b", "5 J")]) == ("1 J", "5 J") and monitor.later() == {}
    assert monitor.notes([("a", "2 J")]) == () and monitor.later() == {"1 J": "2 J"}


# ------------------------------------------------------------------ driven bodies that touch nothing


def driven_above(last=True, step=1, touching=0, drive=(0.0, 0.0, -0.1), joints=()):
    """Notes of Untouched about one step of a driven box 0.1 m above soil."""
    given = build(soil_scene([steel(0.2, 0.2, 0.2, name="cube", position=(0.4, 0.4, 0.0), rest_on=0.1, velocity=drive,
                                    driven=("z",) if any(drive) else ())]))
    report = SimpleNamespace(evaluation=SimpleNamespace(contacts=(range(touching),), pairs=None))
    model = replace(given.model, joints=joints)
    return Untouched(model, given.state).notes(StepView(model, replace(given.state, step=step), model.scheme, report, {},
                                                        last))


def test_a_driven_body_that_touched_nothing_is_told_at_the_end_of_the_run():
    text, = driven_above()
    assert text.startswith("cube is driven and touches neither soil nor another body at the end of any step")
    assert "0.1 m above the highest soil" in text
    assert "body.rest_on" in text


@pytest.mark.parametrize("other", [{"last": False}, {"step": 5}, {"touching": 2}, {"drive": (0.0, 0.0, 0.0)},
                                   {"joints": (SimpleNamespace(bodies=(0, None)),)}])
def test_other_bodies_are_not(other):
    """Before the end, in a run that was resumed, in contact, free to fall, and one that carries another."""
    assert driven_above(**other) == ()


# ------------------------------------------------------------------ bodies that leave the grid


def moved(simulation, position, rotation=None):
    body = simulation.state.bodies[0]
    rotation = body.rotation if rotation is None else rotation
    return replace(simulation.state, bodies=[replace(body, position=np.array(position), rotation=rotation)])


@pytest.mark.parametrize("position, words", [
    ((0.1 - 0.003, 0.4, 0.2), "x = -0.003 m, limit x = 0 m"), ((0.4, 0.75, 0.2), "y = 0.85 m, limit y = 0.8 m"),
    ((0.4, 0.4, -0.35), "z = -0.45 m, limit z = -0.4 m")])
def test_each_face_that_a_body_passes_is_named_once(simulation, position, words):
    monitor = DomainExit(simulation.model, simulation.state)
    assert monitor.notes(view(simulation, simulation.state)) == ()
    text, = monitor.notes(view(simulation, moved(simulation, position)))
    assert words in text and f"grid.{words[0]}.{'end' if '0.8 m' in words else 'start'} outwards" in text
    assert monitor.notes(view(simulation, moved(simulation, position))) == ()


def test_neither_the_open_top_nor_a_face_passed_from_the_start_counts(simulation):
    above, monitor = moved(simulation, (0.4, 0.4, 9.0)), DomainExit(simulation.model, simulation.state)
    assert monitor.notes(view(simulation, above)) == ()
    outside = moved(simulation, (0.05, 0.4, 0.2))
    assert DomainExit(simulation.model, outside).notes(view(simulation, outside)) == ()


def test_the_turned_surface_counts(simulation):
    """An edge of the box reaches 0.1 √2 m."""
    monitor, turned = DomainExit(simulation.model, simulation.state), exp_so3(np.array([0.0, 0.0, np.pi / 4]))
    assert monitor.notes(view(simulation, moved(simulation, (0.12, 0.4, 0.2)))) == ()
    assert "x = -0.02142 m" in monitor.notes(view(simulation, moved(simulation, (0.12, 0.4, 0.2), turned)))[0]


def test_a_body_flush_with_a_face_may_breathe_with_the_soil(simulation):
    """Less than a hundredth of a cell past a face is none; a face touched at the start does not count at all."""
    monitor = DomainExit(simulation.model, simulation.state)
    assert not monitor.notes(view(simulation, moved(simulation, (0.1 - 0.001, 0.4, 0.2))))
    flush = DomainExit(simulation.model, moved(simulation, (0.1 + 1e-6, 0.4, 0.05)))
    past = view(simulation, moved(simulation, (0.1 - 0.01, 0.4, 0.05)), [[1]])
    assert not flush.notes(past) and not list(flush.stops(past)) and list(monitor.stops(past))


@pytest.mark.parametrize("components, lost", [((), True), (("x",), False), (("y", "z"), True)])
def test_a_body_that_leaves_the_grid_stops_the_run_unless_it_is_driven_there(simulation, components, lost):
    monitor, free = DomainExit(simulation.model, simulation.state), ~np.isin(FREEDOMS, components)
    outside = view(simulation, moved(simulation, (0.05, 0.4, 0.2)), [[1]])
    body = replace(simulation.model.bodies[0], free=free)
    texts = list(monitor.stops(replace(outside, model=replace(simulation.model, bodies=(body,)))))
    assert len(texts) == lost and all("leaves the grid" in text for text in texts)
    assert not list(DomainExit(simulation.model, outside.state).stops(outside))     # there from the start
    assert not list(monitor.stops(view(simulation, outside.state, [[]])))           # flies above the soil
    assert list(monitor.stops(view(simulation, moved(simulation, (0.05, 0.4, 0.05)), [[]])))    # is too low


@pytest.mark.parametrize("position, speed, gravity, lost", [
    ((1.0, 0.4, -0.15), -1.0, -9.81, True),     # beside the soil, below its surface
    ((1.0, 0.4, -0.15), -1.0, 0.0, False),      # but nothing draws it down
    ((1.0, 0.4, -0.15), 1.0, -9.81, False),     # on its way up
    ((1.0, 0.4, 0.2), -1.0, -9.81, False),      # beside the soil, above its surface
    ((0.4, 0.4, 0.2), -1.0, -9.81, False),      # above the soil
    ((0.4, 0.4, -0.2), -1.0, -9.81, True),      # inside it
    ((0.4, 0.4, -0.2), -1.0, 0.0, True),
])
def test_a_body_that_falls_beside_or_inside_the_soil_stops_the_run(simulation, position, speed, gravity, lost):
    simulation = build(replace(simulation.scene, gravity=(0.0, 0.0, gravity)))
    state = moved(simulation, position)
    state = replace(state, bodies=[replace(state.bodies[0], velocity=np.array([0.0, 0.0, speed]))])
    monitor = LostContact(simulation.model, simulation.state)
    texts = list(monitor.stops(view(simulation, state, [[]])))
    assert len(texts) == lost and all("falls free at z = -0." in text for text in texts)
    assert not list(monitor.stops(view(simulation, state, [[1]])))      # something touches it


def test_a_body_in_a_pit_is_not_lost(simulation):
    """Soil is left out of a shaft, down to 0.3 m below the surface."""
    state = moved(simulation, (0.4, 0.4, -0.12))
    points = state.points
    shaft = (np.abs(points.position[:, :2] - 0.4) < 0.15).all(axis=1) & (points.position[:, 2] > -0.3)
    state = replace(state, points=replace(points, inactive=shaft),
                    bodies=[replace(state.bodies[0], velocity=np.array([0.0, 0.0, -1.0]))])
    monitor = LostContact(simulation.model, simulation.state)
    assert not list(monitor.stops(view(simulation, state, [[]])))


@pytest.mark.parametrize("start, x, z, lost", [
    (1.0, 1.0, -0.4, False),    # a table under it: it will land there
    (1.0, 1.3, -0.4, True),     # beside it
    (1.0, 1.0, 0.3, True),      # above it
    (0.4, 1.3, -0.4, True),     # the cube is inside the soil,
    (0.4, 0.4, -0.4, True),     # also with the table under it
])
def test_a_body_that_falls_on_another_is_not_lost(start, x, z, lost):
    bodies = [steel(0.2, 0.2, 0.2, name=name, position=place) for name, place in
              (("cube", (1.0, 0.4, -0.15)), ("table", (1.6, 0.4, z)))]
    simulation = build(soil_scene(bodies, gravity=(0.0, 0.0, -9.81)))
    cube, table = simulation.state.bodies
    falling = replace(cube, position=np.array([start, 0.4, -0.15]), velocity=np.array([0.0, 0.0, -1.0]))
    state = replace(simulation.state, bodies=[falling, replace(table, position=np.array([x, 0.4, z]))])
    monitor = LostContact(simulation.model, simulation.state)
    assert len(list(monitor.stops(view(simulation, state, [[], []])))) == lost


# ------------------------------------------------------------------ penetration


def penetrating(simulation, gaps, forces):
    """View of corners of the first points with these gaps [m] and normal forces [N]; domains are 0.1 m high."""
    count = len(gaps)
    contact = type("Contact", (), {
        "gap": np.array(gaps), "normal": np.tile([0.0, 0.0, 1.0], (count, 1)),
        "force": np.outer(forces, [0.0, 0.0, -1.0]), "__len__": lambda self: count})()
    history = SimpleNamespace(point=np.arange(count), touching=np.ones(count, bool))
    return view(simulation, replace(simulation.state, contacts=[history]), (contact,))


def test_a_quarter_of_the_force_beyond_a_layer_is_too_much(simulation):
    monitor = Penetration(simulation.model, simulation.state)
    assert simulation.state.points.half_width[:2] == pytest.approx(0.05)
    assert monitor.notes(penetrating(simulation, [-0.11, -0.09], [24.0, 76.0])) == ()
    text, = monitor.notes(penetrating(simulation, [-0.11, -0.09], [26.0, 74.0]))
    assert "up to 1.1 of the height" in text and "limit 1;" in text and "carry 26%" in text


def test_contact_at_places_of_a_body_has_no_layers(simulation):
    """On level held ground: no point of the soil is known, number -1."""
    seen, monitor = penetrating(simulation, [-0.11], [1.0]), Penetration(simulation.model, simulation.state)
    seen.state.contacts[0].point[:] = -1
    assert monitor.notes(seen) == ()


# ------------------------------------------------------------------ points that get lost


def test_inactive_points_are_counted_again_when_they_have_doubled(simulation):
    monitor, points = LostPoints(simulation.model, simulation.state), simulation.state.points

    def notes(lost):
        inactive = np.arange(len(points)) < lost
        return monitor.notes(view(simulation, replace(simulation.state, points=replace(points, inactive=inactive))))

    assert notes(0) == ()
    text, = notes(3)
    mass = simulation.model.soil.constants.mass
    assert text.startswith(f"3 of {len(points)} points are inactive") and f"({mass[:3].sum():.4g} kg" in text
    assert notes(5) == ()
    text, = notes(6)
    assert text.startswith("6 of") and f"{6 / len(points):.2g} of the mass" in text
