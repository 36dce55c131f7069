"""Which bodies cannot roll: these have softer tangential springs on soil that deforms, where the scene
leaves these open.

A body rolls on curved faces that are not upright. One that stands on plane faces sticks at some contact points and slips at
others, and with springs stiffer than those along the normal Newton's method takes longer to find which: a block of 1 m
with μ = 0.3 pressed on elastic soil (E = 10 MPa, cells of 0.1 m, plane strain) takes, in its first three steps,

| ε_T / ε_N | iterations |
|---|---|
| 3 | 39 |
| 0.3 | 19 |

On held ground a block that sticks takes 43 instead of 94 in 60 steps, but rocks in springs that lose energy. So held soil
keeps stiff ones, as contact of bodies with one another has.
"""

from dataclasses import replace

import numpy as np

from hybrid.scene.defaults import SLIDING, Decision

UPRIGHT = 0.1       # largest vertical component of the normal of an upright face
CURVED = np.radians(1.0)    # angle between the normals of a facet and of the surface at its corners, from which it is curved


def with_soft_springs(scene, bodies, motions, decisions):
    """(Scene, [RigidBody], Decisions) with ε_T / ε_N of SLIDING on soil that deforms, at bodies that cannot roll;
    motions: BodyState of each."""
    if scene.soil.held:
        return scene, bodies, decisions
    described, bodies, decisions = list(scene.bodies), list(bodies), list(decisions)
    for n, one in enumerate(decisions):
        name, _, key = one.key.rpartition(".")
        if key != "tangential" or one.value <= SLIDING:
            continue
        b = int(name.removeprefix("body."))
        if described[b].contact == "faces" and not rolls(bodies[b].outline, motions[b].rotation, scene.grid.z.collapsed):
            described[b], bodies[b] = replace(described[b], tangential=SLIDING), replace(bodies[b], tangential=SLIDING)
            decisions[n] = Decision(one.key, SLIDING, "it has no curved face to roll on, and needs fewer iterations")
    return replace(scene, bodies=tuple(described)), bodies, decisions


def rolls(surface, rotation, in_plan):
    """Whether a ContactSurface has curved faces that are not upright; in_plan: where z is collapsed, upright ones count
    too."""
    turning = np.einsum("tcj,tj->tc", surface.corner_normals, surface.normals).min(axis=1) < np.cos(CURVED)
    upward = surface.normals @ rotation[2]
    return bool(np.any(turning & (in_plan | (np.abs(upward) > UPRIGHT))))
