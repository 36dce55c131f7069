"""Increments whose residual ended above the tolerance, a hair above it or within round-off of the soil's stiffness, or in
which a contact point is carried by a facet that is not the nearest.

Newton's method accepts them once it makes no progress any more (`hybrid.step.newton`). One of them in a run
is of no interest. Many show that the tolerance is below what the forces of this scene can be solved to, as of soil that
is very stiff beside its loads.
"""

from hybrid.monitors.monitor import Monitor

NUMBER, SHARE = 5, 0.1      # of increments: smallest number, and smallest share of all


class JudgedIncrements(Monitor):
    """Warns once that a tenth of the increments, and five at least, ended with a residual above the tolerance."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._judged = self._all = 0

    def warnings(self, view):
        """Number, tolerance and remedy."""
        self._judged, self._all = self._judged + view.report.judged, self._all + view.report.increments
        if self._judged < NUMBER or self._judged < SHARE * self._all:
            return
        tolerance = view.model.solver.tolerance
        yield "judged", (
            f"residuals above the tolerance: up to t = {view.state.time:.4g} s {self._judged} of {self._all} increments "
            f"ended above solver.tolerance = {tolerance:.0e} and could not be solved any better. Their residuals are at "
            "most three times the tolerance, or round-off of the stiffness of the soil and at most 1e-3 of the forces "
            "acting, or a contact point is between two facets of a body. If the loads are small beside the modulus, set a "
            "looser solver.tolerance, or a lower modulus")
