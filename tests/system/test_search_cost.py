"""The cost of contact in a step follows the corners near the body, not all points, nor all triangles.

Counted, not timed: `distances`, places whose distance from the body is evaluated in the search; `triangles` visited
for these in the tree of the surface. Each test also counts a search without the one bound that it is about, and fails
on it.
"""

import numpy as np
import pytest
from numba import njit

from hybrid.body.facet_tree import search
from hybrid.contact import contact_pair, contact_points
from hybrid.contact import search as contact_search
from hybrid.scene import Body
from hybrid.setup.build import build
from hybrid.study.scenes import soil_scene, steel

PLACES = pytest.mark.parametrize("contact", ["corners", "faces"])
REACH = 0.1     # [m], a cell
COUNTED = "distances", "triangles"
LIMITS = {"corners": 3.0, "faces": 5.0}     # distances evaluated for each contact point near a plate


@njit
def visited(places, reach, tree):
    """Triangles visited for the closest points of places (m, 3)."""
    count = 0
    for y in places:
        count += search(y[0], y[1], y[2], reach, tree)[-1]
    return count


@pytest.fixture
def counted(monkeypatch):
    """Function that finds and evaluates the contact of a body pressed 30 mm into cells³/2 cells of 0.1 m; it returns
    the pair, its contact, and the counts."""
    counts = dict.fromkeys(COUNTED, 0)
    distances = contact_search.distances

    def counting_distances(places, surface, reach=np.inf):
        counts["distances"] += len(places)
        counts["triangles"] += visited(places, reach, surface.tree)
        return distances(places, surface, reach)

    monkeypatch.setattr(contact_search, "distances", counting_distances)

    def contact_of(body, cells=8):
        width = 0.1 * cells
        simulation = build(soil_scene([body], x=(0.0, width), y=(0.0, width), z=(-width / 2, 0.2), size=0.1))
        state, grid, points = simulation.state.bodies[0], simulation.model.soil.grid, simulation.state.points
        rest, pose = np.zeros((grid.node_count, 3)), (state.position - (0.0, 0.0, 0.03), state.rotation)
        counts.update(dict.fromkeys(COUNTED, 0))
        soil = contact_points.SoilSurface(contact_search.Domains.of(points, simulation.model.soil.constants, "gimp"), grid,
                                          np.ones(grid.node_count, bool))
        pair = contact_pair.ContactPair(soil, simulation.model.bodies[0], state, simulation.state.contacts[0],
                                        contact_search.Reach(REACH, 0.0), (rest, pose), begins=True)
        return pair, pair.evaluate(rest, pose), dict(counts)

    return contact_of


def ball(geometry, contact, size=0.06, cells=8):
    return Body(geometry=geometry / "sphere.geo", density=3000.0, rest_on=0.0, friction=0.3, contact=contact,
                position=(0.05 * cells + 0.013, 0.05 * cells + 0.007, 0.0),
                parameters={"radius": 0.25, "size": size, "growth": 0.5})


def few_and_many_points(counted, geometry, contact):
    """Counts with 2 048 and with 16 384 points; corners near the body and in contact are the same."""
    (few, one, small), (many, other, large) = (
        counted(ball(geometry, contact, cells=cells), cells) for cells in (8, 16))
    assert len(few.points) == len(many.points) > 200
    assert len(one) == len(other) > 10
    return small, large


@PLACES
def test_eight_times_as_many_points_around(counted, geometry, contact):
    small, large = few_and_many_points(counted, geometry, contact)
    assert large["distances"] == small["distances"] > 200
    for name, count in small.items():
        assert large[name] <= 1.1 * count


def test_count_of_a_search_without_the_body_s_box_grows_with_the_points(counted, geometry, monkeypatch):
    monkeypatch.setattr(contact_search, "_mark", lambda *args: args[-1].fill(True))
    """The middle of every domain is looked at, wherever it is."""
    small, large = few_and_many_points(counted, geometry, "corners")
    assert large["distances"] - small["distances"] == 16384 - 2048


def coarse_and_fine(counted, geometry, contact):
    """Counts with few and with 14 times as many triangles; the corners near the body are nearly the same."""
    (coarse, _, few), (fine, _, many) = (counted(ball(geometry, contact, size)) for size in (0.06, 0.015))
    assert len(fine.body.surface.triangles) > 14 * len(coarse.body.surface.triangles)
    assert len(fine.points) == pytest.approx(len(coarse.points), rel=0.05)
    return few, many


@PLACES
def test_sixteen_times_as_many_triangles(counted, geometry, contact):
    """Triangles visited grow with the depth of the tree; measured 2.1 times as many."""
    few, many = coarse_and_fine(counted, geometry, contact)
    assert many["distances"] == pytest.approx(few["distances"], rel=0.05)
    assert many["triangles"] < 3 * few["triangles"]


def test_count_of_a_search_without_the_boxes_of_the_tree_grows_with_the_triangles(counted, geometry, monkeypatch):
    counting = contact_search.distances

    def without_boxes(places, surface, reach=np.inf):
        unbounded = np.repeat([[-np.inf, np.inf]], 3, axis=1) * np.ones((len(surface.tree.boxes), 1))
        return counting(places, type("Surface", (), {"tree": surface.tree._replace(boxes=unbounded)}), reach)

    monkeypatch.setattr(contact_search, "distances", without_boxes)
    few, many = coarse_and_fine(counted, geometry, "corners")
    assert many["triangles"] > 10 * few["triangles"]


def small_and_large_plate(counted, contact):
    """Distances evaluated for each contact point near a plate and near one with nine times the area."""
    plates = [steel(edge, edge, 0.1, position=(1.0, 1.0, 0.0), rest_on=0.0, friction=0.3, contact=contact,
                    velocity=(0.1, 0.0, 0.0))
              for edge in (0.5, 1.5)]
    (small, _, few), (large, _, many) = (counted(plate, 20) for plate in plates)
    assert len(large.points) > 4 * len(small.points)
    return few["distances"] / len(small.points), many["distances"] / len(large.points)


@pytest.mark.parametrize("contact, limit", LIMITS.items())
def test_more_contact_points_near_the_body(counted, contact, limit):
    """Distances evaluated are in proportion to them: 2.6 and 2.4 for each corner, half of which look away from the
    plate; 3.5 and 4.4 for each place on faces, which are fewer within reach than their groups have."""
    assert max(small_and_large_plate(counted, contact)) < limit


@PLACES
def test_a_search_in_the_ball_about_the_body_evaluates_more(counted, monkeypatch, contact):
    """A tenth more for places on faces, as domains out of reach are left out by one distance each; half more for corners."""
    mark, boxed = contact_search._mark, small_and_large_plate(counted, contact)

    def in_ball(position, half, centre, rotation, lower, upper, near):
        radius = np.linalg.norm(np.maximum(np.abs(lower), np.abs(upper)))
        mark(position, half, centre, rotation, np.full(3, -radius), np.full(3, radius), near)

    monkeypatch.setattr(contact_search, "_mark", in_ball)
    assert np.all(np.divide(small_and_large_plate(counted, contact), boxed) > 1.05)
