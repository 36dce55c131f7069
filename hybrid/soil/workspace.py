"""Memory that the evaluations of one soil share, and the tangent as Newton's method wants it.

The soil model and the points are never written to. What changes from one evaluation to the next lies here: the buffers
of trial strains (`hybrid.soil.kinematics`) and, with `solver.tangent_tolerance`, the tangent that is kept within an
increment (`hybrid.soil.stiffness`).

At the apex of a cone the consistent tangent is zero, and sand changes between no stiffness and its full stiffness from
one Newton iteration to the next. A share s of the elastic tangent mixed into the plastic one, D + s (D_e - D), damps
that; it changes the iterations, not the solution. Newton's method sets it (`hybrid.step.iteration.ELASTIC`).
"""

import numpy as np

from hybrid.soil.kinematics import Kinematics
from hybrid.soil.stiffness import KeptStiffness


def keeps_tangents(soil, solver):
    """Whether points keep their tangents within an increment."""
    return solver.tangent_tolerance > 0.0 and not soil.held


class SoilWorkspace:
    """Buffers for the evaluations of one Soil; solver: a `hybrid.scene.Solver`, None for the full consistent tangent.

    kept: KeptStiffness, None where every assembly is complete
    """

    def __init__(self, soil, solver=None):
        n = len(soil.constants)
        self.trial_strain = Kinematics(0 if soil.held else n, soil.fbar)
        self.kept, self._law, self._elastic = None, soil.law, None
        if solver is not None and keeps_tangents(soil, solver):
            self.kept = KeptStiffness(solver.tangent_tolerance, soil.law.young, soil.fbar)

    def follow_points(self, soil):
        """Go on with a Soil whose points have moved from process to process."""
        self.trial_strain.resize(len(soil.constants))
        self._law, self._elastic = soil.law, None
        if self.kept:
            self.kept.follow_points(soil.law.young)

    def law_tangent(self, tangent, share):
        """The `tangent` D (n, 3, 3) [Pa] of the law with a `share` [-] of the elastic one."""
        if not (share and self._law.plastic):
            return tangent
        if self._elastic is None:
            at_rest = np.zeros((len(tangent), 3))
            self._elastic = self._law.respond(self._law.strain(at_rest), np.zeros(len(tangent))).tangent
        return tangent + share * (self._elastic - tangent)
