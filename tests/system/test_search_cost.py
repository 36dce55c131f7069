"""The cost of contact in a step follows the corners near the body, not all points, nor all triangles.

Counted, not timed: `distances`, corners whose distance from the body is evaluated in the search; `triangles` visited
for these in the tree of the surface; `domains` and `queries`, points in the neighbour searches of the second pass and
places they are asked for. Each test also counts a search without the one bound that it is about, and fails on it.
"""

import numpy as np
import pytest
from numba import njit

from hybrid.body.closest import search
from hybrid.contact import contact_pair, corners, exposed_faces
from hybrid.scene import Body
from hybrid.setup.build import build
from hybrid.study.scenes import soil_scene, steel

SHARES = pytest.mark.parametrize("second_pass", [0.0, 0.5])
REACH = 0.1     # [m], a cell
COUNTED = "distances", "triangles", "domains", "queries"


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
    distances, Tree = corners.distances, exposed_faces.cKDTree

    def counting_distances(places, surface, reach=np.inf):
        counts["distances"] += len(places)
        counts["triangles"] += visited(places, reach, surface.tree)
        return distances(places, surface, reach)

    class CountingTree(Tree):
        def __init__(self, points):
            counts["domains"] += len(points)
            super().__init__(points)

        def query(self, x, *args, **options):
            counts["queries"] += len(x)
            return super().query(x, *args, **options)

    monkeypatch.setattr(corners, "distances", counting_distances)
    monkeypatch.setattr(exposed_faces, "cKDTree", CountingTree)

    def contact_of(body, cells=8):
        width = 0.1 * cells
        simulation = build(soil_scene([body], x=(0.0, width), y=(0.0, width), z=(-width / 2, 0.2), size=0.1))
        state, grid, points = simulation.state.bodies[0], simulation.model.soil.grid, simulation.state.points
        rest, pose = np.zeros((grid.node_count, 3)), (state.position - (0.0, 0.0, 0.03), state.rotation)
        counts.update(dict.fromkeys(COUNTED, 0))
        pair = contact_pair.ContactPair(
            simulation.model.bodies[0], state, simulation.state.contacts[0], points, points.half_width, grid,
            np.ones(grid.node_count, bool), REACH, (rest, pose))
        return pair, pair.evaluate(rest, pose), dict(counts)

    return contact_of


def ball(geometry, second_pass, size=0.06, cells=8):
    return Body(geometry=geometry / "sphere.geo", density=3000.0, rest_on=0.0, friction=0.3, second_pass=second_pass,
                position=(0.05 * cells + 0.013, 0.05 * cells + 0.007, 0.0),
                parameters={"radius": 0.25, "size": size, "growth": 0.5})


def few_and_many_points(counted, geometry, second_pass):
    """Counts with 2 048 and with 16 384 points; corners near the body and in contact are the same."""
    (few, one, small), (many, other, large) = (
        counted(ball(geometry, second_pass, cells=cells), cells) for cells in (8, 16))
    assert len(few.corners) == len(many.corners) > 200
    assert len(one) == len(other) > 10
    return small, large


@SHARES
def test_eight_times_as_many_points_around(counted, geometry, second_pass):
    small, large = few_and_many_points(counted, geometry, second_pass)
    assert large["distances"] == small["distances"] > 200
    for name, count in small.items():
        assert large[name] <= 1.1 * count


def test_count_of_a_search_without_the_body_s_box_grows_with_the_points(counted, geometry, monkeypatch):
    monkeypatch.setattr(corners, "_mark", lambda *args: args[-1].fill(True))
    small, large = few_and_many_points(counted, geometry, 0.0)
    assert large["distances"] == 8 * small["distances"]


def test_count_of_a_search_for_domains_without_a_box_grows_with_the_points(counted, geometry, monkeypatch):
    monkeypatch.setattr(exposed_faces, "_in_box", lambda position, lower, upper: np.ones(len(position), bool))
    small, large = few_and_many_points(counted, geometry, 0.5)
    assert large["domains"] > 4 * small["domains"]


def coarse_and_fine(counted, geometry, second_pass):
    """Counts with few and with 14 times as many triangles; the corners near the body are nearly the same."""
    (coarse, _, few), (fine, _, many) = (counted(ball(geometry, second_pass, size)) for size in (0.06, 0.015))
    assert len(fine.body.surface.triangles) > 14 * len(coarse.body.surface.triangles)
    assert len(fine.corners) == pytest.approx(len(coarse.corners), rel=0.05)
    return few, many


@SHARES
def test_sixteen_times_as_many_triangles(counted, geometry, second_pass):
    """Triangles visited grow with the depth of the tree; measured 2.1 times as many."""
    few, many = coarse_and_fine(counted, geometry, second_pass)
    assert many["distances"] == pytest.approx(few["distances"], rel=0.05)
    assert many["triangles"] < 3 * few["triangles"]


def test_count_of_a_search_without_the_boxes_of_the_tree_grows_with_the_triangles(counted, geometry, monkeypatch):
    counting = corners.distances

    def without_boxes(places, surface, reach=np.inf):
        unbounded = np.repeat([[-np.inf, np.inf]], 3, axis=1) * np.ones((len(surface.tree.boxes), 1))
        return counting(places, type("Surface", (), {"tree": surface.tree._replace(boxes=unbounded)}), reach)

    monkeypatch.setattr(corners, "distances", without_boxes)
    few, many = coarse_and_fine(counted, geometry, 0.0)
    assert many["triangles"] > 10 * few["triangles"]


def small_and_large_plate(counted, second_pass):
    """Counts of a plate and of one with nine times the area, both for each corner near the body."""
    found = []
    for edge in (0.5, 1.5):
        plate = steel(edge, edge, 0.1, position=(1.0, 1.0, 0.0), rest_on=0.0, friction=0.3, second_pass=second_pass)
        pair, _, counts = counted(plate, 20)
        found.append({"corners": len(pair.corners)} | {name: n / len(pair.corners) for name, n in counts.items()})
    assert found[1]["corners"] > 4 * found[0]["corners"]
    return found


@SHARES
def test_more_corners_near_the_body(counted, second_pass):
    """Distances evaluated are in proportion to the corners, 6.3 times as many."""
    small, large = small_and_large_plate(counted, second_pass)
    assert large["distances"] < 1.2 * small["distances"]
    assert large["domains"] <= 1.5 * small["domains"] and large["queries"] <= 1.5 * small["queries"]


def test_count_of_a_search_in_the_ball_about_the_body_grows_with_its_volume(counted, monkeypatch):
    mark = corners._mark

    def in_ball(position, half, centre, rotation, lower, upper, radius, in_box):
        mark(position, half, centre, rotation, np.full(3, -radius), np.full(3, radius), radius, in_box)

    monkeypatch.setattr(corners, "_mark", in_ball)
    small, large = small_and_large_plate(counted, 0.0)
    assert large["distances"] > 1.5 * small["distances"]
