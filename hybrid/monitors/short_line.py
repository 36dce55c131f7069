"""Pull lines through soil whose far end is nearer than the place where they come up to the mudline.

The line leaves the soil at the mudline and is straight beyond (`hybrid.body.embedded_line`): one whose far end is nearer
has no such place, and its tension and angle at the body are those of a longer one.
"""

import math

from hybrid.body.embedded_line import shape_in_soil
from hybrid.body.rigid import line_ends
from hybrid.monitors.monitor import Monitor

LEFT = 0.05     # of the depth: a line that has so little above it has come up


class ShortLine(Monitor):
    """Warns once for each body."""

    def warnings(self, view):
        """Body, distances and remedy."""
        for number, body, motion, _ in view.bodies:
            if body.line is None or body.line.soil is None or motion.target is None or self.given(number):
                continue
            span = motion.target - (motion.position + motion.rotation @ body.line.attachment)
            depth = body.line.soil.mudline - (motion.target - span)[2]
            pull, angle, *_ = line_ends(body.line, motion)
            if pull <= 0.0 or depth <= 0.0:
                continue
            shape, across = shape_in_soil(pull, angle, depth, body.line.soil), math.hypot(span[0], span[1])
            up = shape[body.line.soil.mudline - shape[:, 1] <= LEFT * depth]
            needed = up[0, 0] if len(up) else shape[-1, 0]
            if across < needed:
                yield number, (
                    f"the line of {body.name} comes up to the mudline {needed:.3g} m ahead of its point at t = "
                    f"{view.state.time:.4g} s, and its far end is only {across:.3g} m ahead: tension and angle at the body "
                    f"are those of a longer line. Set body.pull.length to {1.2 * math.hypot(needed, span[2]):.2g} m or more")
