"""Points that tile cells of a grid, without a scene."""

from dataclasses import replace

from hybrid.setup.lattice import Lattice
from hybrid.soil.points import lines_of_points


def tile(grid, lower, upper, per_axis, density):
    """PointConstants of a `density` [kg/m³] that tile the cells from `lower` to `upper` (3,) [m], `per_axis` (3,) points
    along each cell edge."""
    lattice = Lattice(*lines_of_points(grid, lower, upper, per_axis))
    constants = lattice.points(lattice.chosen(None))
    return replace(constants, mass=density * constants.volume)
