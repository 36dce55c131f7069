"""Plastic strain in increments that are too long: the stress returns to the yield surface at once instead of along a
path.

The return mapping takes the plastic strain of an increment along the direction at its end, and the shape functions of
points stay as they were at its begin. With inertia the time step has reasons of its own to be short. Without it only
convergence sets the increments: a bank that slumps by a twentieth of its height in one of them comes to rest 31 %
short, converged to 1e-6 (failure mode plastic_step).
"""

from hybrid.monitors.monitor import Monitor

LIMIT = 0.1     # [-] that an increment may add to the plastic strain of a point; at 0.15 the bank was wrong by 31 %

AT_ONCE = ("; if it is the weight of a body, which acts from the first step on, carry it by an upward stage.load that fades "
           "in a table of times")


class PlasticIncrement(Monitor):
    """Warns once that an increment without inertia adds too much plastic strain to a point."""

    def warnings(self, view):
        """Plastic strain, limit and remedy."""
        added = view.report.plastic_increment
        if added > LIMIT:
            yield "plastic", (
                f"plastic increments too long: up to t = {view.state.time:.4g} s an increment added {added:.2g} to the "
                f"plastic strain of a point, limit {LIMIT:g}, so that the result depends on the length of the steps. "
                "Use more stage.steps" + AT_ONCE * (view.state.step == 1))
