"""Reach of the corner search: the distance from a body within which corners are followed during a step.

    R = max(s, max_v 2 Δt (V + |v_v|))    over the nodes v with  d_v <= 2 Δt (V + |v_v|)

s is a share of the smallest cell (`hybrid.contact.places`), V the speed of the fastest point of the body, |v_v| the largest component of a node's velocity,
and d_v the distance from the body's bounding box to the cells around the node. A corner moves no faster than the
fastest node of its cell. If it could touch the body within twice the step, that node fulfils the condition, so R
covers it; a fast node so far away that none of its corners could touch leaves R as it is. The factor 2 is the margin
for velocities that grow within the step. `travel_ratio` measures afterwards whether the margin was enough.
"""

import numpy as np

from hybrid.body import rigid
from hybrid.runtime import comm

MARGIN = 2.0


def search_reach(body, state, grid, velocity, dt, gravity=0.0):
    """Reach R [m] around a `body` at its committed `state`; velocity: (N, 3) [m/s] of the nodes, None for held soil;
    gravity: [m/s²], by which a body that is let go falls in the step."""
    speed = np.linalg.norm(state.velocity) + np.linalg.norm(state.spin) * body.radius + gravity * dt
    cell = body.places.reach * grid.smallest_cell
    fastest = 0.0 if velocity is None else comm.largest(np.abs(velocity))
    if MARGIN * dt * (speed + fastest) > cell and fastest > 0.0:
        node_speed = np.abs(velocity).max(axis=1)
        distance = _distance_of_cells(grid, rigid.bounding_box(body, state))
        fastest = comm.largest(node_speed[distance <= MARGIN * dt * (speed + node_speed)])
    return max(cell, MARGIN * dt * (speed + fastest))


def travel_ratio(body, state, pose, reach, grid, points, moved):
    """Largest path of soil and body towards each other over the `reach` [-]; above 1 a corner that was not followed
    could have touched.

    pose: of the body at the end; points: committed; moved: (n, 3) [m] displacement of each point, None for held soil.
    Where the ratio would be above 1, points do not count whose domains, with a cell around them, are too far away to
    touch.
    """
    rotated = np.linalg.norm(pose[1] - state.rotation, 2) * body.radius
    path = np.linalg.norm(pose[0] - state.position) + rotated
    farthest = 0.0 if moved is None else comm.largest(np.abs(moved))
    if path + farthest > reach and farthest > 0.0:
        length = np.abs(moved).max(axis=1)
        lower, upper = rigid.bounding_box(body, state)
        around = points.half_width + grid.smallest_cell
        apart = np.maximum(lower - points.position - around, points.position - around - upper)
        apart[:, grid.collapsed] = 0.0
        farthest = comm.largest(length[apart.max(axis=1) <= path + length])
    return (path + farthest) / reach


def _distance_of_cells(grid, box):
    """Distance (N,) [m], along the axis where it is largest, from a box (2, 3) [m] to the cells around each node. The
    outermost cells extend beyond the grid, as corners outside move with their nodes."""
    apart = []
    for nodes, lower, upper in zip(grid.axes, *box):
        before, after = np.append(-np.inf, nodes[:-1]), np.append(nodes[1:], np.inf)
        before[:2], after[-2:] = -np.inf, np.inf
        apart.append(np.maximum(0.0, np.maximum(lower - after, before - upper)))
    x, y, z = apart
    return np.maximum(np.maximum(x[:, None, None], y[:, None]), z).ravel()
