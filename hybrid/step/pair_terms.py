"""Bodies in contact with one another, in one increment: their forces and stiffness in the bodies' block of the equations.

The law is that of `hybrid.contact.body_to_body`, at places on both bodies, each side with half of the stiffness k. Pairs
that are too far apart to touch in the increment cost a distance of centres.

    k = f k_0       k_0 from the weight of the lighter body (`hybrid.setup.body_contact`)

f >= 1 is chosen where contact begins, from the speed at which it does, and kept until the bodies have come apart, so that an
impact overlaps bodies by no more than IMPACT of their size.

Equations: FORMULATION (60) to (64).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hybrid.body.rigid import reduced_mass, turn_between
from hybrid.contact import body_to_body
from hybrid.contact.body_to_body import PairContact, Side, SideStep
from hybrid.contact.law import Coulomb
from hybrid.state import PairHistory

IMPACT = 5e-3   # of the size of the smaller body: overlap by an impact
# Share of the size of the smaller body: reach beyond twice the predicted path, with and without inertia
MARGIN = {True: 0.02, False: 0.1}
LONGEST_PATH = 0.5  # of the same: longest predicted path of bodies that may meet in an increment
SLOW = 2.0      # times the speed that overlaps bodies by as much as the load does: of a contact that is no impact
RESOLVED = 1 / 20   # of the time that an impact lasts, in an increment
PASSED = 0.01   # of the same: depth of places on their way that counts as having passed through


@dataclass(frozen=True)
class BodyPair:
    """Two bodies that may touch one another.

    numbers: of the first and second body; sides: places of the first one on the second, and the other way round
    stiffness: k_0 [N/m³]; impact: [N s²/m⁵] k over the square of the speed of an impact; size: [m] of the smaller body
    law: Coulomb; radii: (2,) [m] of balls around them; collapsed: (3,) bool axes; load: [N] that k_0 is made for, and
    overlap: [m] under it
    """

    numbers: tuple[int, int]
    sides: tuple[Side, Side]
    stiffness: float
    impact: float
    size: float
    law: Coulomb
    radii: tuple[float, float]
    collapsed: np.ndarray
    load: float
    overlap: float

    def distance(self, poses):
        """[m] between the balls around both bodies."""
        apart = poses[self.numbers[0]][0] - poses[self.numbers[1]][0]
        return float(np.linalg.norm(np.where(self.collapsed, 0.0, apart))) - sum(self.radii)

    def contact_times(self, mass):
        """(time [s] of a contact at most as deep as `overlap`, way [m] that over the speed of a harder impact is its time)
        of bodies with a reduced `mass` [kg]: π times depth over speed of a linear spring, 2.8 of one whose area grows
        with the overlap."""
        return float(np.pi * np.sqrt(mass * self.overlap / self.load)), 3.0 * IMPACT * self.size

    def impact_of(self, speed, change, factor, mass, springs):
        """Increment [s] that resolves an impact in which bodies with a reduced `mass` [kg] approach or part at a `speed`
        [m/s] that changes by `change` [m/s²], with a `factor` on the stiffness and `springs` [N/m] that press: inf for a
        light contact."""
        slow, way = self.contact_times(mass)
        lasts = min(slow / np.sqrt(factor), np.pi * np.sqrt(mass / springs) if springs else np.inf)
        speed = np.hypot(speed, change * lasts / np.pi)
        return RESOLVED * min(lasts, way / speed) if speed > SLOW * np.pi * self.overlap / slow else np.inf

    def path(self, poses, others):
        """Upper bound [m] of the way of any place relative to the other body from `poses` to `others`."""
        (a, b), ways = self.numbers, []
        for number, radius in zip(self.numbers, self.radii):
            ways.append(turn_between(poses[number][1], others[number][1]) * radius)
        change = (others[a][0] - poses[a][0]) - (others[b][0] - poses[b][0])
        return float(np.linalg.norm(change)) + sum(ways)


@dataclass(frozen=True)
class PairStep:
    """A pair near enough to touch, frozen during an increment: index in the model; sides; factor f; reach [m] of the
    search; longest: [s] increment that resolves an impact which goes on, or may begin, inf where there is none."""

    index: int
    pair: BodyPair
    sides: tuple[SideStep, SideStep]
    factor: float
    reach: float
    longest: float = np.inf


@dataclass(frozen=True)
class PairsStep:
    """All pairs during an increment. poses: committed, of all bodies; near: PairStep of those that may touch; columns:
    (b, 6) places of the bodies' components among their unknowns, -1 of components that are none; too_long: why the increment
    is too long for what bodies are predicted to do, empty if it is not."""

    poses: tuple
    pairs: tuple[BodyPair, ...]
    near: tuple[PairStep, ...]
    columns: np.ndarray
    too_long: str = ""

    @property
    def longest(self):
        """[s] increment that resolves the impacts of all pairs that go on, or are predicted to begin."""
        return min((one.longest for one in self.near if any(side.closes or side.touching.any() for side in one.sides)),
                   default=np.inf)

    def unforeseen(self, terms):
        """The same of those in PairTerms that were not predicted."""
        return min((one.longest for one, sides in zip(self.near, terms.contacts) if any(len(side.active) for side in sides)),
                   default=np.inf)

    def evaluate(self, poses):
        """PairTerms at trial poses of all bodies."""
        return PairTerms(self, poses, tuple(tuple(side.evaluate(poses) for side in one.sides) for one in self.near))

    def sticking(self, points):
        """The same with places of each side in stick, whatever their shear; points: their numbers, side by side."""
        given, near = iter(points), []
        for one in self.near:
            near.append(replace(one, sides=tuple(side.holding(next(given)) for side in one.sides)))
        return replace(self, near=tuple(near))

    def rejection(self, terms, bodies):
        """Why the increment to PairTerms must not be accepted, empty if it may be."""
        near = {one.index: one for one in self.near}
        for index, pair in enumerate(self.pairs):
            names = " and ".join(bodies[b].body.name for b in pair.numbers)
            reach = near[index].reach if index in near else pair.distance(self.poses)
            if pair.path(self.poses, terms.poses) > max(reach, pair.distance(self.poses)):
                return f"bodies {names} moved farther than the search for their contact allows for"
        for one, sides in zip(self.near, terms.contacts):
            count = sum(step.passed(found, terms.poses, PASSED * one.pair.size) for step, found in zip(one.sides, sides))
            if count:
                names = " and ".join(bodies[b].body.name for b in one.pair.numbers)
                return f"bodies {names} pass through one another, at {count} places"
        return ""


@dataclass(frozen=True)
class PairTerms:
    """Contact of all pairs near one another at trial poses: contacts of both sides of each PairStep."""

    step: PairsStep
    poses: tuple
    contacts: tuple[tuple[PairContact, PairContact], ...]

    def on_body(self, number):
        """Residual (6,) [N, N m] of all pairs on a body: minus their force and moment about its centre."""
        total = np.zeros(6)
        for side, residual in self._residuals:
            if number in (side.a, side.b):
                total += residual[:6] if number == side.a else residual[6:]
        return total

    @cached_property
    def _residuals(self):
        """[(Side, residual (12,) [N, N m] on both bodies)] of what touches."""
        return [(side, found.residual()) for _, side, found in self._sides() if len(found.active)]

    def springs(self, number):
        """Root of the sum of squares [N/m] of all springs in contact on a body."""
        return float(np.sqrt(sum(found.springs**2 for _, side, found in self._sides() if number in (side.a, side.b))))

    def add_tangent(self, ww):
        """Add the stiffness of all pairs to the bodies' block (m, m)."""
        for _, side, found in self._sides():
            if len(found.active):
                places = np.concatenate([self.step.columns[side.a], self.step.columns[side.b]])
                own = places >= 0
                ww[np.ix_(places[own], places[own])] += found.stiffness()[np.ix_(own, own)]

    @property
    def energy(self):
        """[J] in the springs."""
        return sum(found.energy for _, _, found in self._sides())

    @property
    def dissipated(self):
        """Work [J] against friction in the increment."""
        return sum(found.dissipated for _, _, found in self._sides())

    def of_pair(self, index):
        """(force (3,) [N] of the second body on the first one, deepest overlap [m], number of places in contact)."""
        force, depth, count = np.zeros(3), 0.0, 0
        for pair, side, found in self._sides():
            if pair == index and len(found.active):
                first = self.step.pairs[index].numbers[0]
                force += (-1.0 if side.a == first else 1.0) * found.force.sum(axis=0)
                depth, count = max(depth, float(-found.gap.min())), count + len(found.active)
        return force, depth, count

    def histories(self):
        """[PairHistory] of all pairs of the model once the increment is accepted."""
        out = [PairHistory.empty() for _ in self.step.pairs]
        for one, sides in zip(self.step.near, self.contacts):
            parts = [step.history(found) for step, found in zip(one.sides, sides)]
            out[one.index] = PairHistory(*parts[0], *parts[1], np.array([one.factor]))
        return out

    def _sides(self):
        """(index of the pair, Side, PairContact) of all near pairs, both ways."""
        for one, sides in zip(self.step.near, self.contacts):
            for step, found in zip(one.sides, sides):
                yield one.index, step.side, found


def begin_pairs(model, state, bodies, dt):
    """PairsStep of an increment of `dt` [s], None where no bodies may touch one another. bodies: BodyStep of each."""
    if not model.pairs:
        return None
    poses = tuple(body.state.pose for body in bodies)
    predicted = tuple(body.predicted_pose() for body in bodies)
    fall = np.linalg.norm(model.loads.on_bodies(state.time + dt)) * dt**2 if model.scheme.inertia else 0.0
    histories = state.pairs or [PairHistory.empty() for _ in model.pairs]
    near, too_long = [], ""
    for index, (pair, history) in enumerate(zip(model.pairs, histories)):
        path = pair.path(poses, predicted)
        reach = 2.0 * path + fall + MARGIN[model.scheme.inertia] * pair.size
        if path > LONGEST_PATH * pair.size and pair.distance(poses) <= path:
            names = " and ".join(bodies[b].body.name for b in pair.numbers)
            too_long = (f"bodies {names} approach one another by {path:.3g} m, limit {LONGEST_PATH * pair.size:.3g} m where "
                        "they may meet")
        elif pair.distance(poses) <= reach:
            near.append(_begin_pair(index, pair, history, bodies, poses, predicted, reach, dt))
    return PairsStep(poses, model.pairs, tuple(near), model.component_places, too_long)


def _begin_pair(index, pair, history, bodies, poses, predicted, reach, dt):
    """PairStep of a pair that may touch."""
    def both(factor):
        return tuple(body_to_body.begin(side, poses, predicted, reach, history.side(i), 0.5 * factor * pair.stiffness,
                                        pair.law,
                                        pair.collapsed) for i, side in enumerate(pair.sides))

    factor, states = float(history.factor[0]), {b: bodies[b].state for b in pair.numbers}
    rates = {b: (state.velocity, state.rotation @ state.spin) for b, state in states.items()}
    if len(history.number_0) or len(history.number_1):
        begun = both(factor)
        changes = {b: (state.acceleration, state.rotation @ state.spin_rate) for b, state in states.items()}
        speed, change, springs = _approach(begun, rates, changes, poses)
    else:
        factor, begun, change, springs = 1.0, both(1.0), 0.0, 0.0
        speed = max(body_to_body.closing_speed(one, rates[one.side.a], rates[one.side.b], poses, dt) for one in begun)
        if bodies[0].scheme.inertia and pair.impact * speed**2 > pair.stiffness:
            factor = pair.impact * speed**2 / pair.stiffness
            begun = tuple(replace(one, stiffness=factor * one.stiffness) for one in begun)
    mass = reduced_mass([bodies[b].body for b in pair.numbers])
    if np.isinf(mass) or not bodies[0].scheme.inertia:
        return PairStep(index, pair, begun, factor, reach)
    longest = pair.impact_of(speed, change, factor, mass, springs)
    if springs and longest < dt:    # looked at more closely
        normals = [body_to_body.pressed_normals(one, poses) for one in begun]
        longest = pair.impact_of(*_approach(begun, rates, changes, poses, normals)[:2], factor, mass, springs)
    return PairStep(index, pair, begun, factor, reach, longest)


def _approach(begun, rates, changes, poses, normals=(None, None)):
    """(speed [m/s], change [m/s²], stiffness [N/m]) of the places of both SideStep that press, as `mean_normal_speed`."""
    (speed, springs), (change, _) = (
        body_to_body.mean_normal_speed(begun, of, poses, normals) for of in (rates, changes))
    return speed, change, springs
