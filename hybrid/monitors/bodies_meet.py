"""Bodies that run into one another: no force acts between them, so they pass through each other."""

from itertools import combinations

from hybrid.contact.bodies import depth_of_overlap
from hybrid.monitors.monitor import Monitor

LIMIT = 0.01    # overlap, in radii of the smaller body


class BodiesMeet(Monitor):
    """Warns once for each pair of bodies, not joined, that overlap."""

    def __init__(self, model, state):
        super().__init__(model, state)
        joined = {frozenset(joint.bodies) for joint in model.joints}
        self._pairs = [pair for pair in combinations(range(len(model.bodies)), 2) if frozenset(pair) not in joined]

    def warnings(self, view):
        """Bodies, overlap, limit and remedy."""
        bodies, states, collapsed = view.model.bodies, view.state.bodies, view.model.soil.grid.collapsed
        for pair in self._pairs:
            if self.given(pair):
                continue
            one, other = ((bodies[b], states[b]) for b in pair)
            limit = LIMIT * min(one[0].radius, other[0].radius)
            depth = depth_of_overlap(one, other, collapsed)
            if depth > limit:
                yield pair, (f"bodies {one[0].name} and {other[0].name} overlap by {depth:.3g} m at t = {view.state.time:.4g} s, "
                             f"limit {limit:.3g} m: no force acts between bodies, so they pass through each other. Hold them "
                             "apart, or join them by a [[joint]]")
