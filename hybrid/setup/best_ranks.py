"""The number of processes of a run where the user leaves it open: decided from the scene, before anything is built.

    N = min(cores, points / PER_PROCESS, (memory left - memory of the soil) / LIBRARIES), rounded down; one where N < FEWEST

Each process makes its own block of the initial state. On two cores two processes take 0.93 of the time of two threads for a
block of 106 000 unknowns and 0.7 for the anchor (demos/speed/README.md), and start 6 s later, which most runs on two cores
do not make good. Threads share only the products of the linear solver, a quarter of the work: they cannot be faster than
four times one, and processes can. One process runs held soil, whose points cost nothing, and a
grid that follows a body, whose number of points is not known from the scene.
"""

from hybrid.runtime.errors import HybridError
from hybrid.scene.accuracy import apply_accuracy
from hybrid.scene.defaults import resolve
from hybrid.setup.grid import axis_nodes
from hybrid.setup.size import size
from hybrid.soil.size import LIBRARIES

PER_PROCESS, FEWEST = 100_000, 4    # points, processes


def best_ranks(scene, cores, memory):
    """(Number of processes for a checked Scene on `cores` with `memory` [bytes] left, its number of points or 0 where
    that was not needed)."""
    if cores < FEWEST or scene.grid.moves or scene.soil.held:
        return 1, 0
    try:
        scene, _ = resolve(apply_accuracy(scene)[0])
        need, points = size(scene, [axis_nodes(axis) for axis in scene.grid.axes])
    except HybridError:     # reported when the scene is built
        return 1, 0
    number = int(min(cores, points // PER_PROCESS, (memory - need) / LIBRARIES))
    return number if number >= FEWEST else 1, points
