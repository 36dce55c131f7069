"""Points at random with domains of random widths, on a uniform and on a roughly graded grid."""

import numpy as np

COUNT = 4000
UNIFORM = tuple(np.linspace(-1.0, 2.0, n) for n in (13, 8, 4))


def graded():
    """Axes whose neighbouring cells differ by random factors up to the limit of two."""
    rng = np.random.default_rng(7)
    axes = []
    for cells in (12, 7, 3):
        widths = 0.3 * np.cumprod(2.0 ** rng.uniform(-1, 1, cells))
        axes.append(-1.0 + np.concatenate([[0.0], np.cumsum(widths)]))
    return tuple(axes)


GRIDS = {"uniform": UNIFORM, "graded": graded()}


def scattered(axes, narrowest=0.02, seed=2):
    """Points at random in the grid with random domains, up to the widest allowed. (n, 3), (n, 3)."""
    rng = np.random.default_rng(seed)
    position, half = np.empty((COUNT, 3)), np.empty((COUNT, 3))
    for axis, nodes in enumerate(axes):
        cell = rng.integers(len(nodes) - 1, size=COUNT)
        width = np.diff(nodes)[cell]
        position[:, axis] = nodes[cell] + rng.uniform(0.01, 0.99, COUNT) * width
        room = np.minimum(position[:, axis] - nodes[0], nodes[-1] - position[:, axis])
        half[:, axis] = np.minimum(0.5 * width * rng.uniform(narrowest, 1.0, COUNT), room)
    return position, half


def clear_of_nodes(position, half, axes, distance):
    """(n,) bool: both ends of the domains stay `distance` (a part of the smallest cell) away from nodes."""
    clear = np.ones(len(position), bool)
    for axis, nodes in enumerate(axes):
        for end in (position[:, axis] - half[:, axis], position[:, axis] + half[:, axis]):
            clear &= np.abs(end[:, None] - nodes).min(axis=1) > distance * np.diff(nodes).min()
    return clear
