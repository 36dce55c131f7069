"""Radius of curvature of a body's surface, by the patches that smooth it."""

import numpy as np

SHARP = 0.1     # of the area: fillets and tips, which cells do not resolve either


def curvature_radius(surface):
    """Radius of curvature [m] that all but SHARP of a surface's area exceed, inf where that is plane."""
    nodes, area = surface.tree.patches.nodes, surface.areas
    if not len(nodes):
        return np.inf
    edge, turn = (np.stack([nodes[:, i], nodes[:, i + 1], nodes[:, i + 1] - nodes[:, i]], axis=1) for i in (1, 4))
    curvature = (np.linalg.norm(turn, axis=2) / np.linalg.norm(edge, axis=2)).max(axis=1)
    order = np.argsort(-curvature)
    strongest = curvature[order][np.searchsorted(np.cumsum(area[order]), SHARP * area.sum())]
    return 1.0 / strongest if strongest > 0.0 else np.inf
