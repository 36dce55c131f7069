"""Condensation of a rigid body's nodal degrees of freedom to six.

A node at r_i from the centre of mass moves by w_i = Δc + Δφ × r_i = C_i Δq, Δq = (Δc, Δφ), with

    C_i = [ I , -r̃_i ]      (seed paper, Eq. 2)      r̃ a = r × a

| symbol | field                             | shape   | unit  |
|--------|-----------------------------------|---------|-------|
| r_i    | nodes, from the centre of mass    | (n, 3)  | m     |
| C      | condensation matrix               | (3n, 6) | 1 | m |

Rows run node by node: x, y, z of node 0, then of node 1.

Equations: FORMULATION (30).
"""

import numpy as np


def condensation(nodes, centre=(0.0, 0.0, 0.0)):
    """Condensation matrix C (3n, 6) of `nodes` (n, 3) [m] about `centre` (3,) [m]."""
    r = np.asarray(nodes, dtype=float) - np.asarray(centre, dtype=float)
    blocks = np.zeros((len(r), 3, 6))
    blocks[:, :, :3] = np.eye(3)
    blocks[:, 0, 4], blocks[:, 0, 5] = r[:, 2], -r[:, 1]
    blocks[:, 1, 3], blocks[:, 1, 5] = -r[:, 2], r[:, 0]
    blocks[:, 2, 3], blocks[:, 2, 4] = r[:, 1], -r[:, 0]
    return blocks.reshape(-1, 6)
