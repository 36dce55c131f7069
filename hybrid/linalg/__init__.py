"""Sparsity of the soil block, its reduced matrix for the preconditioner, and the block system in PETSc."""
