"""Sparsity of the soil block, what preconditioners are made of, PETSc."""
