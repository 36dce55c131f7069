"""Overlaps as deep as the soil's points are high: the next row of corners touches too, and counts the pressure twice.

A row of corners stands for all of the area under a body (`hybrid.contact.corners`). With n the normal of a touching
corner and l the half-widths of its point's domain, the next row is 2 Σ |n_i| l_i farther in. Multipliers are there to
leave no overlap; where their updates do not suffice, some is left, and the soil is that much thicker than it should be.
"""

import numpy as np

DEEP = {False: 1.0, True: 0.1}  # overlaps over heights of domains, without multipliers and with them
SHARE = 0.25                    # of the force on a body, carried by corners deeper than that


class Deep:
    """Says once for each body that much of its force comes from such overlaps."""

    def __init__(self):
        self._said = set()

    def notes(self, model, state, contacts, scheme=None):
        """Texts about bodies, by the Contacts that led to `state`."""
        texts = []
        for b, (body, contact) in enumerate(zip(model.bodies, contacts)):
            if b in self._said or not len(contact.corners) or model.soil.basis != "gimp":
                continue
            limit = DEEP[body.augmented]
            depth, force = _depths(contact.corners, state.contacts[b], state.points)
            share = force[depth > limit].sum() / max(force.sum(), 1e-300)
            if share > SHARE:
                self._said.add(b)
                texts.append(_text(body, state.time, depth.max(), limit, share))
        return tuple(texts)


def _depths(touch, history, points):
    """Overlaps (m,) over the heights of the domains [-], and forces (m,) [N], of the corners that touch."""
    half = points.half_width[history.id[history.touching] // 8]
    height = 2 * np.einsum("ci,ci->c", np.abs(touch.normal), half)
    return -touch.gap / height, np.linalg.norm(touch.force, axis=1)


def _text(body, time, deepest, limit, share):
    text = (f"{body.name} is deep in the soil: at t = {time:.4g} s corners overlap it by up to {deepest:.2g} of their "
            f"point's domain, limit {limit:g}, and such carry {share:.0%} of the force. ")
    if body.augmented:
        return text + ("Its multipliers are not settled; raise solver.augmentations or body.penalty, or take shorter "
                       "steps")
    return text + "From 1 on a second row of corners touches and counts the pressure twice; raise body.penalty"
