"""Memory that the evaluations of one soil share, and the tangent as the solver's settings want it.

The soil model and the points are never written to. What changes from one evaluation to the next lies here: the buffers
of trial strains (`hybrid.soil.kinematics`) and, with `solver.tangent_tolerance`, the tangent that is kept within an
increment (`hybrid.soil.stiffness`).

At the apex of a cone the consistent tangent is zero, and loose sand at the surface changes between no stiffness and its
full stiffness from one Newton iteration to the next. A share s of the elastic tangent mixed into the plastic one,
D + s (D_e - D), damps that; it changes the iterations, not the solution (`solver.elastic_share`).
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
        self.kept, self._share, self._elastic = None, 0.0, None
        if solver is None or soil.held:
            return
        if keeps_tangents(soil, solver):
            self.kept = KeptStiffness(solver.tangent_tolerance, soil.law.young, soil.fbar)
        if solver.elastic_share and soil.law.plastic:
            self._share = solver.elastic_share
            self._elastic = soil.law.respond(np.zeros((n, 3)), np.zeros(n)).tangent

    def law_tangent(self, tangent):
        """The law's D (n, 3, 3) [Pa] with its share of the elastic one."""
        return tangent + self._share * (self._elastic - tangent) if self._share else tangent
