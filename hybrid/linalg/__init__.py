"""The block system in PETSc, and the sparsity of its soil block.

1 stencil.py, stencil_pattern.py     nodes that a node is coupled with; numbers of the unknowns, and sparsity
  system_cache.py                    both kept while the active nodes stay the same
2 blocks.py         its arrays, and its solvers tried in turn
  petsc.py          how it is stored, and solved by GMRES or a direct factor
    solver_choice.py                 which solver a tangent goes to, by what was counted in the run
    inverses.py, precond_pattern.py  approximate inverses of the soil block, and the entries that they are made from
    product.py                       product of the soil block with a vector, on all threads
3 petsc_ranks.py    the same of several processes; petsc_copies.py: of few unknowns, solved by each of them
"""
