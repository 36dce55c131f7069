"""Trial values of the unknowns of an increment, and the residual of its equations there."""

from dataclasses import dataclass

import numpy as np

from hybrid.soil.model import SoilTrial
from hybrid.step.body_terms import BodyTerms
from hybrid.step.joint_terms import JointTerms
from hybrid.step.pair_terms import PairTerms


@dataclass(frozen=True)
class Unknowns:
    """Trial values: nodal displacement increments (N, 3) [m] (None for held soil), poses of the bodies, multipliers (n,) of
    their joints (None without joints)."""

    displacement: np.ndarray | None
    poses: tuple
    multipliers: np.ndarray | None = None


@dataclass(frozen=True)
class Evaluation:
    """Residual and its terms at trial unknowns. Its soil trial is valid until the next evaluation, unless that one
    keeps it.

    soil (n,) [N] and body (m,) [N, N m]: residual on the unknowns; error: largest residual of soil and bodies relative
    to the forces acting on each; norms: the same in physical units, by name; internal: norm [N] of the internal forces;
    rates: `Scheme.advance` of the nodes; bodies: BodyTerms of each body; joints: JointTerms, None without joints;
    pairs: PairTerms, None where no bodies may touch one another.
    """

    unknowns: Unknowns
    soil: np.ndarray
    body: np.ndarray
    error: float
    norms: dict
    internal: float
    soil_trial: SoilTrial | None
    rates: tuple | None
    bodies: tuple[BodyTerms, ...]
    joints: JointTerms | None = None
    pairs: PairTerms | None = None

    @property
    def contacts(self):
        """Contact of each body."""
        return tuple(terms.contact for terms in self.bodies)
