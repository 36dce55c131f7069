"""Initial equilibrium: the forces on the nodes of the soil that do not balance at the start.

    r_v = f_int,v - Σ_p S_vp m_p b        share = Σ_v |r_v| / M |g|        over the free components of all nodes

Geostatic stress balances the weight of level soil that fills its cells between held sides, to round-off. It does not
do so at a face that is cut free, under a slope, or where cells are filled unevenly; and soil without initial stress has
to take up all of its weight. Bodies that touch the soil at the start press on it.

With inertia the soil then swings, as a column of its height H does in

    T = 4 H √(ρ / M)        M = K + 4 G / 3

and flows plastically in the first swings. In a vertical cut of 1 m with c = 2.5 kPa the plastic work was 1.8, 3.8, 5.7 and
6.8 J in steps of 0.63, 0.31, 0.16 and 0.08 T: the state of rest depends on the step unless it resolves the swing.
"""

from dataclasses import dataclass

import numpy as np

from hybrid.laws.hencky import BULK, SHEAR
from hybrid.runtime.comm import anywhere, gathered, total
from hybrid.soil.points import extent

TOLERANCE = 1e-3    # share of the weight from which a run warns; results are right to as much
SETTLED = 0.02      # the same of soil that has settled (`hybrid.setup.settle`)
RESOLVED = 0.1    # largest step over the period of the swing
FAR = 0.1         # of the weight: soil that yields and lies on two held bodies, 1, had no first step without inertia
_UNSETTLED = ("Settling at the start, without inertia, did not bring the soil to rest: its ground is too steep, or its load "
              "too large, for its strength, and it slides from the start on. If it should stand, flatten soil.ground or "
              "raise the strength.")


@dataclass(frozen=True)
class InitialImbalance:
    """share: of the weight [-]; place: (3,) [m] of the node with the largest force; stressed: whether any point carries
    stress; period: [s] of the swing of soil that may yield, None for other soil."""

    share: float
    place: tuple[float, float, float]
    stressed: bool
    period: float | None = None

    def __str__(self):
        if self.share <= TOLERANCE:
            return f"balanced, to {self.share:.1g} of the weight"
        place = ", ".join(f"{x:.4g}" for x in self.place)
        return f"{_per_cent(self.share)} of the weight, largest at node ({place}) m"

    def notes(self, stage, scheme, length, settled=False):
        """Texts (none or one) for a run that starts with `stage`, in steps of `length` [s] by `scheme`; settled: whether
        the soil has settled before."""
        limit = SETTLED if settled else TOLERANCE
        if self.share <= limit:
            return ()
        about = _UNSETTLED if settled else f"{self._cause()} {_remedy(stage, scheme, self.stressed)}"
        return (f"initial imbalance: {self}, is not balanced at the start, limit {100 * limit:g} %. {about}"
                f"{self._too_long(length) if scheme.inertia else ''}",)

    def hazards(self):
        """Texts (none or one) about soil that yields and begins with stress, without inertia, so far from equilibrium that
        the first step may have none."""
        if self.share > FAR and self.stressed and self.period is not None:
            yield (f"initial imbalance: {self}, is not balanced at the start, limit {FAR:.0%}, and without inertia soil "
                   f"that yields may find no equilibrium in the first step. {self._cause()} Set soil.geostatic = "
                   "false, and turn gravity on in a first stage, stage.gravity = [0.0, 1.0]")

    def _too_long(self, length):
        """About steps of `length` [s] that do not resolve the swing, so that plastic flow depends on them."""
        if self.period is None or length <= RESOLVED * self.period:
            return ""
        return (f" The step of {length:.3g} s is {length / self.period:.2g} of the period {self.period:.3g} s in which "
                f"the soil then swings, limit {RESOLVED:g}: how far it flows until it is at rest depends on the step. "
                f"Use stage.step = {RESOLVED * self.period:.2g} or less until it is at rest.")

    def _cause(self):
        if self.stressed:
            return ("Geostatic stress is in equilibrium only in level soil that fills its cells and is held at its "
                    "sides.")
        return "The soil carries no stress yet and its weight acts at once."


def _per_cent(share):
    """Text of a share: two digits, and no exponent from a hundred on."""
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{100 * share:.2g} %"


def initial_imbalance(step, evaluation):
    """InitialImbalance of the state that `step` begins from, by its `evaluation` with nothing moved; None where the
    soil is held, weighs nothing, or falls with nothing in its way."""
    grid, weight = step.model.soil.grid, 0.0
    if step.soil is not None:
        weight = float(total(step.soil.mass[grid.owned_nodes])) * float(np.linalg.norm(step.model.gravity))
    if weight == 0.0 or _falls(step, evaluation):
        return None
    force = evaluation.soil_trial.force - step.soil.weight
    contact = force if grid.nodes is None else np.zeros_like(force)     # of several processes each has its part
    for terms in evaluation.bodies:
        if grid.nodes is not None or len(terms.contact):    # several processes add up what the body feels
            terms.step.pair.add_residual(terms.contact, contact)
    if grid.nodes is not None:
        force += grid.summed(contact)
    size = np.linalg.norm(np.where(step.pattern.free, force, 0.0), axis=1)
    return InitialImbalance(float(total(size[grid.owned_nodes])) / weight, _largest(size, grid),
                            anywhere(step.soil.points.stress), _period(step.model.soil))


def _falls(step, evaluation):
    """Whether neither a held node nor a body touches the soil, with inertia."""
    across = ~step.model.soil.grid.collapsed    # along collapsed axes all nodes are held
    touched = ~step.pattern.free[:, across].all(axis=1) & (step.soil.mass > 0.0)
    return step.model.scheme.inertia and not anywhere(touched) and not anywhere(
        [len(terms.contact) for terms in evaluation.bodies])


def _largest(size, grid):
    """Place (3,) [m] of the node with the largest `size` (N,) in all processes, of equal ones the first along x, y and z."""
    node = np.unravel_index(int(np.argmax(size)), grid.shape)
    found = gathered(np.array([[size.max(), *(nodes[i] for nodes, i in zip(grid.axes, node))]]))
    first = np.lexsort((*found.T[:0:-1], -found[:, 0]))[0]
    return tuple(map(float, found[first, 1:]))


def _period(soil):
    """Period [s] of the first vertical mode of a column as high as the soil, None for soil that cannot yield."""
    if not soil.law.plastic or soil.law.parameters is None:
        return None
    points, (bulk, shear) = soil.constants, soil.law.parameters[:, [BULK, SHEAR]].T
    (bottom, top), volume = extent(points, 2), points.volume
    slowness = np.sqrt(points.mass / volume / (bulk + 4 / 3 * shear))      # [s/m]
    return float(4 * (top - bottom) * total(slowness * volume) / total(volume))


def _remedy(stage, scheme, stressed):
    """What the first stage does about it, or what to change; stressed: whether the soil has geostatic stress, which could
    be left out."""
    if not scheme.inertia:
        return f"Stage {stage.name!r} has no inertia, so its first step finds the equilibrium."
    if scheme.first_order:
        return f"Stage {stage.name!r} damps the motion that follows; give it enough steps to settle."
    change = "set soil.geostatic = false and turn" if stressed else "turn"
    return ("Let the soil settle in a first stage that damps (stage.beta = 0.5625, stage.gamma = 1) or without "
            f"inertia, or {change} gravity on by stage.gravity = [0.0, 1.0].")
