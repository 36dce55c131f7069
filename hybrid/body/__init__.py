"""Rigid bodies: mesh, mass, attitude, contact surface, motion and pull line."""

import hybrid.runtime.kernel_copies  # noqa: F401 (before a kernel of this folder is compiled)
