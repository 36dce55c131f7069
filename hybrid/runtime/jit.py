"""What compiles kernels: every kernel imports njit and prange from here, so that none is compiled otherwise.

Packages with kernels do not import numba by themselves: the process that meshes a geometry (`hybrid.body.mesh_worker`)
needs none, and has its imports in half the time.
"""

from numba import njit, prange  # noqa: F401

import hybrid.runtime.kernel_copies  # noqa: F401
