"""Soil as material points on a background grid: grid, basis, points, transfer, kinematics, forces."""

import hybrid.runtime.kernel_copies  # noqa: F401 (before a kernel of this folder is compiled)
