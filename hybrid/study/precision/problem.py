"""A problem with a known answer: what a study has to know of it to run its curves, draw them and fit levels to them.

Each module of `hybrid.study.precision.problems` computes one such problem and ends in its `PROBLEM`.
"""

from collections.abc import Callable
from dataclasses import dataclass


def _none(quick=False):
    return {}


@dataclass(frozen=True)
class Problem:
    """title: its name in words; errors: {error: what is measured, with unit}, the drawn one first.

    curves(quick): {curve: [(setting, values), ...]} with values that JSON can hold; "default" is one of the curves.
    solve(**values): RunResult; raises HybridError where the run fails.
    shown: the curves of the first figure beside the default, five at most; chosen: curves over what a scene chooses
        itself and no default can give, steps and the grading of cells; they do not count for the front.
    length, transferable(values): for problems that a scene can name in `accuracy`: which length of the problem the
        cells are counted across, in words; the settings that a scene can take over from a run of these values
        (`hybrid.study.precision.settings.transferable`), None where it cannot.
    certain: smallest value of the first error that means something; a smaller one is accidental. peers(): Records of
    other programs, taken elsewhere. peer_curves(quick), peer_solve(python, **values): curves and RunResult of Kratos
    MPM, where it can solve the problem.
    """

    title: str
    errors: dict[str, str]
    curves: Callable
    solve: Callable
    shown: tuple = ()
    chosen: tuple = ()
    length: str = ""
    transferable: Callable | None = None
    certain: float = 0.0
    peers: Callable = list
    peer_curves: Callable = _none
    peer_solve: Callable | None = None
