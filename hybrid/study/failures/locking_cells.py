"""Locking over the cells: finer ones bend at last, but the nearer ν is to 1/2 the finer they have to be.

The beam of `hybrid.study.failures.locking`. Without F-bar the error goes with (K/G) (h/H)² while it is small, so that
ten times the bulk modulus takes three times the cells along each axis. With F-bar it does not know ν. Known: as there.
"""

from hybrid.study.failures.locking import DEFAULT, MEASURE, METHODS, RIGHT, SAG, SAYS, WRONG, solve

__all__ = ["DEFAULT", "MEASURE", "METHODS", "PARAMETERS", "RIGHT", "SAYS", "TITLE", "WRONG", "settings", "solve"]
TITLE = "locking of a beam"
PARAMETERS = ("Poisson's ratio", "cells through the beam's height")


def settings(quick=False):
    return [(nu, cells) for nu in ((0.3, 0.4999) if quick else SAG) for cells in ((4,) if quick else (2, 4, 8, 16))]
