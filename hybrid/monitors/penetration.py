"""Penetration deeper than one point domain: a second layer of contact points comes into contact, and the pressure is
counted twice.

The contact points of one layer of domains represent all of the area under a body (`hybrid.contact.places`). With n the
normal of the body and l the half-widths of a domain, the next layer is 2 Σ |n_i| l_i farther in.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere, maximum, total

LIMIT = 1.0     # overlap over the height of a domain
SHARE = 0.25                        # of the force on a body, carried by points deeper than LIMIT


class Penetration(Monitor):
    """Warns once for each body that contact points deeper than the limit carry a quarter of its contact force."""

    def warnings(self, view):
        """Body, depth, limit and remedy."""
        for b, body, _, contact in view.bodies:
            if self.given(b) or not anywhere([len(contact)]) or view.model.soil.basis != "gimp":
                continue
            depth, force = _depths(contact, view.state.contacts[b], view.state.points)
            share = total(force[depth > LIMIT]) / max(total(force), 1e-300)
            if share > SHARE:
                yield b, _text(body, view.state.time, maximum(depth), share)


def _depths(contact, history, points):
    """Overlaps (m,) over the heights of the domains [-], and forces (m,) [N], of the points of the soil that touch: m = 0
    where contact is at places of the body."""
    point = history.point[history.touching]
    if (point < 0).any():
        return np.zeros(0), np.zeros(0)
    height = 2 * np.einsum("ci,ci->c", np.abs(contact.normal), points.half_width[point])
    return -contact.gap / height, np.linalg.norm(contact.force, axis=1)


def _text(body, time, deepest, share):
    return (f"{body.name} penetrates the soil too far: at t = {time:.4g} s contact points overlap it by up to "
            f"{deepest:.2g} of the height of their point's domain, limit {LIMIT:g}; points beyond the limit carry "
            f"{share:.0%} of the contact force. From there on a second layer of domains is in contact and the pressure "
            "is counted twice: raise body.penalty")
