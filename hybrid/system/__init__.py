"""The block system of one step: numbering, sparsity, residual, tangent and its solution."""
