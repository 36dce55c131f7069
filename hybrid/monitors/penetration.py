"""Penetration deeper than one point domain: a second layer of corners comes into contact, and the pressure is counted
twice.

A layer of corners represents all of the area under a body (`hybrid.contact.corners`). With n the normal of a touching
corner and l the half-widths of its point's domain, the next layer is 2 Σ |n_i| l_i farther in. Contact multipliers
leave no overlap when they have converged; where their updates do not suffice, the layer of soil is thicker than it
should be by the overlap that is left.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import maximum, total

LIMIT = {False: 1.0, True: 0.1}     # overlap over the height of a domain, without multipliers and with them
SHARE = 0.25                        # of the force on a body, carried by corners deeper than LIMIT


class Penetration(Monitor):
    """Warns once for each body that corners deeper than the limit carry a quarter of its contact force."""

    def warnings(self, view):
        """Body, depth, limit and remedy."""
        for b, body, _, contact in view.bodies:
            if self.given(b) or not len(contact.corners) or view.model.soil.basis != "gimp":
                continue
            limit = LIMIT[body.augmented]
            depth, force = _depths(contact.corners, view.state.contacts[b], view.state.points)
            share = total(force[depth > limit]) / max(total(force), 1e-300)
            if share > SHARE:
                yield b, _text(body, view.state.time, maximum(depth), limit, share)


def _depths(contact, history, points):
    """Overlaps (m,) over the heights of the domains [-], and forces (m,) [N], of the corners that touch."""
    half = points.half_width[history.id[history.touching] // 8]
    height = 2 * np.einsum("ci,ci->c", np.abs(contact.normal), half)
    return -contact.gap / height, np.linalg.norm(contact.force, axis=1)


def _text(body, time, deepest, limit, share):
    text = (f"{body.name} penetrates the soil too far: at t = {time:.4g} s corners overlap it by up to {deepest:.2g} "
            f"of the height of their point's domain, limit {limit:g}; corners beyond the limit carry {share:.0%} of "
            "the contact force. ")
    if body.augmented:
        return text + ("The contact multipliers have not converged: raise solver.augmentations or body.penalty, or "
                       "take shorter steps")
    return text + ("From 1 on a second layer of corners is in contact and the pressure is counted twice: raise "
                   "body.penalty")
