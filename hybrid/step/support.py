"""Support of free bodies where a quasi-static step cannot begin out of balance.

A ball put on clay touches it at a point: all of its weight at once has no solution near there, however short the increment,
because without inertia loads do not grow with it. Where the first increment of a step fails, the imbalance R_w(0) of the
bodies at its start is therefore taken off their equations, and comes back linearly over the step:

    R_w(u) - (1 - s) R_w(0) = 0        s = (t - t_0)/T at the end of an increment, FORMULATION (53a)

At the end of the step, s = 1, the equations are those without support.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body.attitude import log_so3

ROUND_OFF = 1e-9        # of a step: a remaining time as short as this is none
OUT_OF_BALANCE = 0.01   # share of the largest term of a body from which on it is supported


@dataclass(frozen=True)
class Support:
    """begin, length [s] of the step; imbalance: (6,) [N, N m] R_w(0) of each body on its free components, about its
    centre."""

    begin: float
    length: float
    imbalance: tuple

    @classmethod
    def at_start(cls, step, length):
        """Support in a step of `length` [s] whose first increment is `step`; None where its bodies are in balance, or where
        others than the soil bear them, or may: inertia, joints, bodies near enough to touch."""
        if step.model.scheme.inertia or step.joints or step.pairs and step.pairs.near:
            return None
        gravity, displacement = step.model.loads.on_bodies(step.state.time), step.at_rest().displacement
        terms = [body.at_start(displacement, gravity) for body in step.bodies]
        found = tuple(np.where(body.free, sum(own.values()), 0.0) for body, own in zip(step.bodies, terms))
        if not any(_out_of_balance(*one) for one in zip(step.bodies, found, terms)):
            return None
        return cls(step.state.time, length, found)

    def under(self, step):
        """The `step` with its bodies supported."""
        passed = (np.array([step.state.time, step.state.time + step.dt]) - self.begin) / self.length
        shares = 1.0 - np.where(passed > 1.0 - ROUND_OFF, 1.0, passed)
        return replace(step, bodies=tuple(replace(body, support=np.outer(shares, left))
                                          for body, left in zip(step.bodies, self.imbalance)))


def _out_of_balance(body, left, terms):
    """Whether the force or moment of the imbalance `left` (6,) of a BodyStep is a share of its largest terms {name: (6,)},
    of which each force may act on the arm of the body."""
    largest = max(np.linalg.norm(term[:3]) for term in terms.values())
    arm = max(largest * body.body.radius, max(np.linalg.norm(term[3:]) for term in terms.values()))
    return np.linalg.norm(left[:3]) > OUT_OF_BALANCE * largest or np.linalg.norm(left[3:]) > OUT_OF_BALANCE * arm


def work_of_support(step, before, after):
    """Work [J] of the support of a BodyStep as it moves between two BodyStates."""
    if step.support is None:
        return 0.0
    mean, angle = step.support.mean(axis=0), log_so3(after.rotation @ before.rotation.T)
    return float(mean[:3] @ (after.position - before.position) + mean[3:] @ angle)
