"""Sparsity of the soil block, its reduced matrix and approximate inverses, and the block system in PETSc."""
