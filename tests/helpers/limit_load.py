"""Upper bound of limit analysis in plane strain, a calculation that has nothing in common with the program.

A kinematically admissible velocity on triangles whose dissipation equals the work of the loads bounds the load that a
rigid, perfectly plastic soil with associated flow can carry (Drucker, Prager & Greenberg 1952). Mohr and Coulomb's law
√((σ_x - σ_z)² + 4τ²) ≤ 2c cosφ - (σ_x + σ_z) sinφ is taken at `ANGLES` directions, so strain rates are a sum of λ_k ≥ 0
times

    n_k = (sinφ + cos α_k, sinφ - cos α_k, 2 sin α_k),     α_k = 2πk / ANGLES,

and the smallest dissipation is a linear programme. The directions make the bound larger by up to 1/cos(π/ANGLES), 0.9 %.
"""

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

ANGLES = 24


def triangles(length, height, across, up):
    """Nodes (N, 2) and triangles (T, 3) of `across` by `up` rectangles, each cut along both diagonals."""
    x, z = np.meshgrid(np.linspace(0, length, across + 1), np.linspace(0, height, up + 1), indexing="ij")
    corner = np.arange(x.size).reshape(x.shape)
    a, b, c, d = corner[:-1, :-1].ravel(), corner[1:, :-1].ravel(), corner[1:, 1:].ravel(), corner[:-1, 1:].ravel()
    nodes = np.stack([x.ravel(), z.ravel()], axis=1)
    centre = x.size + np.arange(a.size)
    nodes = np.concatenate([nodes, (nodes[a] + nodes[c]) / 2])
    return nodes, np.concatenate([np.stack(t, axis=1)
                                  for t in ((a, b, centre), (b, c, centre), (c, d, centre), (d, a, centre))])


def strain_rates(nodes, cells):
    """Areas (T,) and the matrix (3T, 2N) from velocities to (ε_x, ε_z, γ_xz) of every triangle."""
    edges = np.stack([nodes[cells[:, 1]] - nodes[cells[:, 0]], nodes[cells[:, 2]] - nodes[cells[:, 0]]], axis=2)
    inverse = np.linalg.inv(edges)
    gradient = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)        # (T, 3, 2)
    row = 3 * np.arange(len(cells))[:, None]
    rows = np.stack([row + 0 * cells, row + 1 + 0 * cells, row + 2 + 0 * cells, row + 2 + 0 * cells])
    columns = np.stack([2 * cells, 2 * cells + 1, 2 * cells, 2 * cells + 1])
    values = np.stack([gradient[..., 0], gradient[..., 1], gradient[..., 1], gradient[..., 0]])
    shape = (3 * len(cells), 2 * len(nodes))
    return np.linalg.det(edges) / 2, sparse.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape)


def share_of_gravity(weight, cohesion, angle, length, height, across, up):
    """Upper bound of the factor on `weight` (2,) [N/m³] at which a strip of soil on a rough base, between smooth walls
    that hold it in both directions, begins to slide. `angle` [rad], cohesion [Pa], lengths [m]."""
    nodes, cells = triangles(length, height, across, up)
    area, rates = strain_rates(nodes, cells)
    turn = 2 * np.pi * np.arange(ANGLES) / ANGLES
    flow = np.stack([np.sin(angle) + np.cos(turn), np.sin(angle) - np.cos(turn), 2 * np.sin(turn)])
    load = np.zeros((len(nodes), 2))
    for k in range(3):
        np.add.at(load, cells[:, k], area[:, None] / 3 * np.asarray(weight))
    base, walls = nodes[:, 1] == 0, (nodes[:, 0] == 0) | (nodes[:, 0] == length)
    free = ~np.stack([base | walls, base], axis=1).ravel()
    multipliers = len(cells) * ANGLES
    equal = sparse.bmat([[rates[:, free], -sparse.kron(sparse.eye(len(cells)), flow)],
                         [sparse.csr_matrix(load.ravel()[free]), sparse.csr_matrix((1, multipliers))]], format="csr")
    dissipation = np.concatenate([np.zeros(free.sum()), np.repeat(area, ANGLES) * 2 * cohesion * np.cos(angle)])
    found = linprog(dissipation, A_eq=equal, b_eq=np.append(np.zeros(3 * len(cells)), 1.0), method="highs-ipm",
                    bounds=[(None, None)] * int(free.sum()) + [(0, None)] * multipliers)
    assert found.status == 0, found.message
    return found.fun
