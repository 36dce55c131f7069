"""Sparsity of the soil block, its reduced matrix and approximate inverses, and the block system in PETSc."""

import hybrid.runtime.kernel_copies  # noqa: F401 (before a kernel of this folder is compiled)
