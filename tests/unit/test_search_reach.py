"""The reach of the contact search: covers every point that could touch, and follows the soil near the body only."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.contact.search import Reach
from hybrid.grid.axes import FACES, make_grid
from hybrid.scene import Time
from hybrid.setup.build import build
from hybrid.soil.basis import find_cell
from hybrid.step.equations import begin
from hybrid.step.search_reach import MARGIN, search_reach, travel_ratio
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import soil_scene, steel

DT, REACH = 0.01, 0.5    # [s], cells
HALF = np.array([0.1, 0.1, 0.05])


def body_at(*position, velocity=(0.0, 0.0, 0.0)):
    """(body, state) of a box with edges of 0.2, 0.2 and 0.1 m."""
    vertices = HALF * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    state = SimpleNamespace(position=np.array(position), rotation=np.eye(3), velocity=np.array(velocity),
                            spin=np.zeros(3))
    surface = SimpleNamespace(vertices=vertices, extent=lambda direction: (vertices @ direction).max())
    places = SimpleNamespace(reach=REACH)
    return SimpleNamespace(radius=np.linalg.norm(HALF), surface=surface, outline=surface, places=places), state


def grid_of(x, y, z):
    axes = [np.array(a, float) for a in (x, y, z)]
    extent = np.array([(a[0], a[-1]) if len(a) > 1 else (0.0, 1.0) for a in axes])
    return make_grid(axes, extent, dict.fromkeys(FACES, "free"))


LINE = np.linspace(0.0, 2.0, 21)
CUBE = grid_of(LINE, LINE, LINE)


def nodes_of(grid):
    return np.stack([a.ravel() for a in np.meshgrid(*grid.axes, indexing="ij")], axis=1)


def only(grid, place, speed):
    """Nodal velocities that are zero but at the node at `place`."""
    velocity = np.zeros((grid.node_count, 3))
    velocity[np.argmin(np.linalg.norm(nodes_of(grid) - place, axis=1)), 1] = speed
    return velocity


def test_slow_soil_and_held_soil_have_the_reach_of_a_share_of_a_cell():
    body, state = body_at(1.0, 1.0, 1.0)
    assert search_reach(body, state, CUBE, None, DT) == pytest.approx((0.05, DT))
    assert search_reach(body, state, CUBE, only(CUBE, (1.0, 1.0, 1.0), 2.0), DT) == pytest.approx((0.05, DT))
    assert search_reach(body, state, CUBE, None, DT, fall=0.1) == pytest.approx((0.1, DT))


def test_a_fast_node_near_the_body_sets_the_reach_and_a_far_one_does_not():
    """At 40 m/s a node could come 0.8 m closer within twice the step; beyond that it does not matter."""
    body, state = body_at(0.3, 0.3, 0.3, velocity=(0.0, 0.0, -6.0))
    for place, margin in (((0.4, 0.3, 0.3), 0.8), ((1.2, 0.3, 0.3), 0.8), ((1.8, 0.3, 0.3), 0.05),
                          ((0.3, 0.3, 1.9), 0.05)):
        assert search_reach(body, state, CUBE, only(CUBE, place, 40.0), DT).margin == pytest.approx(margin), place


def test_soil_that_a_body_slides_along_is_no_farther_within_reach_than_soil_at_rest():
    """The path of the surface towards a point counts: of translation and of rotation."""
    normal, reach = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]), Reach(0.05, DT)
    state = SimpleNamespace(position=np.zeros(3), rotation=np.eye(3), velocity=np.array([4.0, 0.0, 0.0]),
                            spin=np.array([0.0, 10.0, 0.0]))
    position = np.array([[0.3, 0.0, -0.2], [0.3, 0.0, 0.0], [-0.3, 0.0, 0.0]])
    assert reach.at(position, normal, state) == pytest.approx([0.05 + DT * 3.0, 0.05 + DT * 4.0, 0.05])
    assert reach.farthest(state, 0.5) == pytest.approx(0.05 + DT * 9.0)


@pytest.mark.parametrize("seed", range(5))
def test_no_corner_that_could_touch_is_missed(seed):
    """Random velocities over four decades, on graded and collapsed axes: a corner moves with the fastest node of its
    cell at most. Whatever could touch in a step in which the soil is MARGIN times as fast is within reach."""
    rng = np.random.default_rng(seed)
    graded = np.cumsum(np.append(0.0, rng.uniform(0.1, 0.2, 14)))
    grid = grid_of(graded, [0.5] if seed == 0 else graded, np.linspace(0.0, 1.5, 9))
    centre = np.array([0.5 * graded[-1], 0.5 if seed == 0 else 0.5 * graded[-1], 1.2])
    body, state = body_at(*centre, velocity=rng.uniform(-2, 2, 3))
    velocity = 10 ** rng.uniform(-2, 2, (grid.node_count, 1)) * rng.uniform(-1, 1, (grid.node_count, 3))
    reach = search_reach(body, state, grid, velocity, DT)
    assert reach.margin <= max(grid.smallest_cell, MARGIN * DT * np.linalg.norm(velocity, axis=1).max())
    speed, could = np.linalg.norm(velocity, axis=1).reshape(grid.shape), 0
    for place in rng.uniform(-0.1, 1.1, (4000, 3)) * [nodes[-1] for nodes in grid.axes]:
        cells = [slice(0, 1) if len(nodes) == 1 else slice(c := find_cell(x, nodes), c + 2)
                 for x, nodes in zip(place, grid.axes)]
        away = np.maximum(np.abs(place - state.position) - HALF, 0.0)
        away[grid.collapsed] = 0.0
        normal = away * np.sign(place - state.position) / max(np.linalg.norm(away), 1e-300)
        closing = DT * max(0.0, state.velocity @ normal)
        if np.linalg.norm(away) <= closing + MARGIN * DT * speed[tuple(cells)].max():
            could += 1
            assert np.linalg.norm(away) <= reach.at(place[None], normal[None], state)[0]
    assert could > 100


def test_the_check_afterwards_counts_points_near_the_body():
    """Up to 1 all points count; a path longer than the reach counts only where it could have ended at the body."""
    body, state = body_at(1.0, 1.0, 1.0)
    pose, rest = (state.position + (0.02, 0.0, 0.0), state.rotation), (state.position, state.rotation)
    points = SimpleNamespace(position=np.array([[1.2, 1.0, 1.0], [1.9, 1.0, 1.0]]), half_width=np.full((2, 3), 0.02))

    def ratio(near, far):
        return travel_ratio(body, state, pose, rest, 0.1, CUBE, points, np.array([[0.0, near, 0.0], [far, 0.0, 0.0]]))

    assert travel_ratio(body, state, pose, rest, 0.1, CUBE, points, None) == pytest.approx(0.2)
    assert travel_ratio(body, state, pose, pose, 0.1, CUBE, points, None) == 0.0      # as predicted
    assert ratio(0.07, 0.0) == pytest.approx(0.9) and ratio(0.0, 0.07) == pytest.approx(0.9)
    assert ratio(0.3, 0.0) == pytest.approx(3.2)
    across = np.array([[0.05, 0.05, 0.05], [0.0, 0.0, 0.0]])
    assert travel_ratio(body, state, rest, rest, 0.1, CUBE, points, across) == pytest.approx(0.05 * 3**0.5 / 0.1)
    assert ratio(0.0, 0.3) == pytest.approx(0.2)    # 0.8 m away
    assert ratio(0.0, 0.9) == pytest.approx(9.2)    # it could have come to the body


def test_a_body_strays_as_far_as_it_likes_where_no_soil_is():
    rest = np.array([1.0, 1.0, 1.0]), np.eye(3)
    pose = rest[0] + (0.3, 0.0, 0.0), np.eye(3)
    body, state = body_at(*rest[0])

    def ratio(x, moved):
        points = SimpleNamespace(position=np.array([[x, 1.0, 1.0]]), half_width=np.full((1, 3), 0.02))
        return travel_ratio(body, state, pose, rest, 0.1, CUBE, points, moved)

    for moved in (None, np.zeros((1, 3))):
        assert ratio(1.3, moved) == pytest.approx(3.0) and ratio(1.9, moved) == 0.0


def test_a_fast_node_far_away_does_not_add_corners():
    """A cube on a block 2 m long, whose far end flies off at 20 m/s."""
    cube = steel(0.3, 0.3, 0.3, position=(0.4, 0.4, 0.0), rest_on=0.0)
    simulation = build(soil_scene([cube], x=(0.0, 2.0), size=0.1, z=(-0.4, 0.4)))
    model, points = simulation.model, simulation.state.points

    def followed(end):
        """Reach and number of corners with all points beyond x = `end` at 20 m/s."""
        velocity = np.where(points.position[:, :1] > end, [0.0, 20.0, 0.0], 0.0)
        state = replace(simulation.state, points=replace(points, velocity=velocity))
        step = begin(model, state, DT, False, Workspace(model))
        return step.bodies[0].reach, len(step.bodies[0].pair.points)

    still, far, near = followed(2.0), followed(1.8), followed(0.6)
    assert far == still and still[0].margin == pytest.approx(
        model.bodies[0].places.reach * model.soil.grid.smallest_cell)
    assert near[0].margin == pytest.approx(MARGIN * DT * 20.0) and near[1] > 1.5 * still[1]


def test_without_inertia_nothing_falls_farther_than_a_cell():
    """A step of 1 s under gravity would otherwise search 9.8 m around the body."""
    for inertia in (False, True):
        described = soil_scene([steel(0.2, 0.2, 0.2, position=(0.4, 0.4, 0.2))], time=Time(1.0, inertia=inertia))
        simulation = build(replace(described, gravity=(0.0, 0.0, -9.81)))
        model = simulation.model
        reach = begin(model, simulation.state, 1.0, False, Workspace(model)).bodies[0].reach
        assert reach.margin == pytest.approx(9.81 if inertia else model.soil.grid.smallest_cell, rel=1e-3)
