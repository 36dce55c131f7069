"""All failure modes by name, in the order of the panels of the figures."""

from hybrid.study.failure import contact, grid, soil, time

MODES = {**grid.MODES, **soil.MODES, **contact.MODES, **time.MODES}
