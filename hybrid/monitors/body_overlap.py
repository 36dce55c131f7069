"""Bodies pressed into one another far deeper than under their weight: the contact between them is too soft for the force."""

import numpy as np

from hybrid.monitors.monitor import Monitor

LIMIT = 0.01    # overlap, in sizes of the smaller body; an impact may take half of it


class BodyOverlap(Monitor):
    """Warns once for each pair of bodies that overlap by too much."""

    def warnings(self, view):
        """Bodies, overlap, limit, force and remedy."""
        pairs, bodies = view.report.evaluation.pairs, view.model.bodies
        for index, pair in enumerate(view.model.pairs):
            if self.given(index):
                continue
            force, depth, _ = pairs.of_pair(index)
            limit = LIMIT * pair.size
            if depth > limit:
                names = [bodies[b].name for b in pair.numbers]
                yield index, (f"bodies {names[0]} and {names[1]} overlap by {depth:.3g} m at t = {view.state.time:.4g} "
                              f"s, limit {limit:.3g} m, under a force of {np.linalg.norm(force):.3g} N, for which their "
                              f"contact is too soft: use a [[contact]] with bodies = {names} and the largest force "
                              "expected as load")
