"""Reach of the contact search: the distance from a body within which contact points are followed during a step.

    R_c = R_0 + Δt max(0, ẋ_s·N)        R_0 = max(s, 2 Δt max_v |v_v| + f)     over nodes v with  d_v <= 2 Δt (V + |v_v|)

at the point of the body's surface closest to a contact point: ẋ_s is its velocity there and N the outward normal, so
soil that a body slides along is not farther within reach than soil at rest. s is a share of the smallest cell
(`hybrid.contact.places`), f the way that a body let go falls, V the speed of the fastest point of the body, |v_v| the
speed of a node, and d_v the distance from the body's bounding box to the cells around the node. A
contact point moves no faster than the fastest node of its cell. The factor 2 is the margin for velocities that grow
within the step.

f = g Δt², without inertia at most a cell: nothing falls there, and with a step of 1 s it was 9.8 m, so all of the soil was
searched in every step. `travel_ratio` measures afterwards whether the margin R_0 was enough.
"""

import numpy as np

from hybrid.body import rigid
from hybrid.contact.search import Reach
from hybrid.runtime import comm

MARGIN = 2.0


def search_reach(body, state, grid, velocity, dt, fall=0.0):
    """Reach around a `body` at its committed `state`; velocity: (N, 3) [m/s] of the nodes, None for held soil; fall:
    [m] by which a body that is let go falls in the step."""
    speed = np.linalg.norm(state.velocity) + np.linalg.norm(state.spin) * body.radius
    floor = body.places.reach * grid.smallest_cell
    fastest = 0.0 if velocity is None else comm.largest(np.linalg.norm(velocity, axis=1))
    if MARGIN * dt * (speed + fastest) > floor and fastest > 0.0:
        node_speed = np.linalg.norm(velocity, axis=1)
        distance = _distance_of_cells(grid, rigid.bounding_box(body, state))
        fastest = comm.largest(node_speed[distance <= MARGIN * dt * (speed + node_speed)])
    return Reach(max(floor, MARGIN * dt * fastest + fall), dt)


def travel_ratio(body, state, pose, predicted, margin, grid, points, moved):
    """Largest path of soil and body towards each other that was not predicted, over the `margin` [m] of the search [-];
    above 1 a contact point that was not followed could have touched.

    pose, predicted: of the body at the end; points: committed; moved: (n, 3) [m] displacement of each point, None for
    held soil. Where the ratio would be above 1, points do not count whose domains, with a cell around them, are too far
    away to touch; it is 0 where all of them are.
    """
    strayed = np.linalg.norm(pose[0] - predicted[0]) + rigid.turn_between(predicted[1], pose[1]) * body.radius
    length = np.zeros(len(points.position)) if moved is None else np.linalg.norm(moved, axis=1)
    farthest = comm.largest(length)
    if strayed + farthest > margin:
        path = np.linalg.norm(pose[0] - state.position) + rigid.turn_between(state.rotation, pose[1]) * body.radius
        lower, upper = rigid.bounding_box(body, state)
        around = points.half_width + grid.smallest_cell
        apart = np.maximum(lower - points.position - around, points.position - around - upper)
        apart[:, grid.collapsed] = 0.0
        near = apart.max(axis=1) <= path + length
        if not comm.anywhere(near):
            return 0.0
        farthest = comm.largest(length[near])
    return (strayed + farthest) / margin


def _distance_of_cells(grid, box):
    """Distance (N,) [m], along the axis where it is largest, from a box (2, 3) [m] to the cells around each node. The
    outermost cells of the whole grid extend beyond it, as contact points outside move with their nodes."""
    apart = []
    for nodes, (first, last), lower, upper in zip(grid.axes, grid.extent, *box):
        before, after = np.append(nodes[0], nodes[:-1]), np.append(nodes[1:], nodes[-1])
        if nodes[0] <= first or len(nodes) == 1:
            before[:2] = -np.inf
        if nodes[-1] >= last or len(nodes) == 1:
            after[-2:] = np.inf
        apart.append(np.maximum(0.0, np.maximum(lower - after, before - upper)))
    x, y, z = apart
    return np.maximum(np.maximum(x[:, None, None], y[:, None]), z).ravel()
