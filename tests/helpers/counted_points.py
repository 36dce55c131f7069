"""The largest number of points that any process has at a time."""

from unittest.mock import patch

import hybrid
from hybrid import state
from hybrid.runtime import comm


def largest_share(scene, out):
    """The most points that a process has had at a time during a run of a `scene` into a folder, of all that there are in
    the end."""
    held = []
    with _counted(state.PointConstants, held), _counted(state.Points, held):
        simulation = hybrid.run(scene, out=out, quiet=True)
    return comm.largest([max(held)]) / comm.number(simulation.state.points)


def _counted(kind, held):
    """Context in which each object of a `kind` that is made puts its number of points into a list."""
    make = kind.__init__

    def counted(self, *given, **named):
        make(self, *given, **named)
        held.append(len(self.position))

    return patch.object(kind, "__init__", counted)
