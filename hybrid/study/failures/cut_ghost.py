"""Small cuts and the ghost penalty: how strong it has to be, and what it costs in softness.

The leaning block of `hybrid.study.failures.cuts` at ρ g L / E = 0.2, over the share of a cell by which it is moved
through the grid and the factor of the penalty. Too weak a penalty leaves some places without a solution; too strong a
one makes the block stiff, as cells away from its edges are tied too where it is few cells thick. Known: as there.
"""

from hybrid.study.failures.cuts import EXACT, lean
from hybrid.study.outcome import Seen

TITLE = "small cuts"
PARAMETERS = ("share of the last cell filled", "factor of the ghost penalty, soil.ghost")
MEASURE, RIGHT, WRONG = "error of the displacement", 0.05, 0.25
METHODS = {"line search": {}, "whole updates": {"solver": {"line_search": False}}}
DEFAULT = "line search"
SAYS = r"carries \S+ of the mass of a full one, limit .*set soil\.ghost"
RATIO = 0.2


def settings(quick=False):
    if quick:
        return [(0.9, 0.0), (0.9, 0.033), (0.3, 0.033)]
    return [(share, ghost) for share in (0.9, 0.7, 0.6, 0.5, 0.45, 0.4, 0.3, 0.2, 0.1, 0.03, 0.001)
            for ghost in (0.0, 1e-4, 1e-3, 0.0033, 0.033, 0.33, 1.0)]


def solve(share, ghost, **values):
    """Seen of the block at that place."""
    return Seen(abs(lean(RATIO, share, ghost=ghost, **values) / EXACT[RATIO] - 1))
