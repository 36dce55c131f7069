"""Plastic flow in increments that are too long: the stress returns at once where it would have gone along a path.

The return mapping takes an increment's flow along the direction at its end, and the functions of points stay as they
were at its begin. With inertia the time step has reasons of its own to be short; without, convergence alone sets the
increments, and a bank that slumps by a twentieth of its height in one of them comes to rest 31 % short, converged to
1e-6 (`hybrid.study.failures.plastic_step`).
"""

import numpy as np

LIMIT = 0.1     # [-] that an increment may add to the plastic strain of a point; at 0.15 the bank was wrong by 31 %


def flowed(before, after):
    """Largest growth of the plastic strain of a point between two states of the same Points."""
    return float(np.max(after.plastic_strain - before.plastic_strain, initial=0.0))


class Flow:
    """Says once when an increment without inertia has made a point flow too far."""

    def __init__(self):
        self._said = False

    def notes(self, time, flow):
        """Texts (none or one) about a step that ended at `time` [s]."""
        if self._said or flow <= LIMIT:
            return ()
        self._said = True
        return (f"long plastic increments: up to t = {time:.4g} s an increment added {flow:.2g} to the plastic strain "
                f"of a point, limit {LIMIT:g}; what it comes to depends on the steps. Use more stage.steps",)
