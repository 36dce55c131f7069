"""Numbers of the nodes of a grid of `shape` = (nx, ny, nz) nodes: v = (i ny + j) nz + k."""

from hybrid.runtime.jit import njit


@njit(cache=True)
def node_number(shape, i, j, k):
    """Number of node (i, j, k). For an offset (i, j, k) of two nodes: the difference of their numbers."""
    return (i * shape[1] + j) * shape[2] + k


@njit(cache=True)
def node_indices(shape, v):
    """(i, j, k) of node v."""
    return v // (shape[1] * shape[2]), v // shape[2] % shape[1], v % shape[2]
