"""Bodies with edges on held ground that bends under them, where an edge catches between places of the ground.

A smooth rod on its two edges in a round valley, whose profile had pieces of a fortieth of its length, did not swing; a
smooth cube on its edge, with heights on a grid that were no plane, did not slide. On straight pieces longer than a body it
touches the ground at places of its own (`hybrid.setup.on_ground`), and slides as it should.
"""

import numpy as np

from hybrid.monitors.limits.start import initial_vertices, top_of


def edges_on_bends(scene, model):
    """Bodies with plane faces that may move over held ground without a straight piece as long as they are."""
    soil = model.soil
    if not soil.held or soil.heights is None or soil.grid.collapsed[2]:
        return
    (_, y, heights), top = soil.heights
    if np.ptp(np.minimum(heights, top)) == 0.0:
        return
    for described, body in zip(scene.bodies, model.bodies):
        plain = described.contact != "corners" and described.penalty is None
        if body.ground is not None or not plain or body.surface.turning.all() or not body.free[:3].any():
            continue
        if initial_vertices(described, body)[:, 2].min() > top_of(soil) + body.radius:
            continue
        pieces = "no straight piece as long as it is"
        if y is not None:
            pieces = "heights on a grid that " + ("fall across its plane of symmetry" if body.mirrors else "are no plane")
        yield (f"{body.name} has edges, and the ground under it has {pieces}: where it stands on an edge, that catches "
               "between places of the ground, so that it neither slides nor swings, however smooth it is. Right are bodies "
               "that lie on a face, and round ones. Give soil.ground in straight pieces longer than the body")


LIMITS = (edges_on_bends,)
