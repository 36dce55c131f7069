"""Kernels give the same bits in the process that compiles them and in those that read them from disk.

The code of a kernel contains copies of the functions that it calls. Each copy is optimised where it is, so a product and
a sum may be fused in one (fastmath={"contract"}) and not in another. Numba marks the copies as exchangeable: a process
that has compiled a function by itself too runs that copy, one that has read the kernel from disk the copy in the
kernel. Here the copies become private to their kernel. Import this before the first kernel is compiled.

Numba compiles a whole-number power once in a process, with the flags of the first kernel that has one, and puts it in all
later ones. So x ** 2 is fused with a sum or not by what else has been compiled: kernels with fastmath write x * x.
"""

from numba.core.codegen import CPUCodeLibrary

import hybrid.runtime.kernel_types  # noqa: F401 (for the same kernels)


def _optimise(library):
    linked = {function.name for other in library._linking_libraries
              for function in other._get_module_for_linking().functions if not function.is_declaration}
    for function in library._final_module.functions:
        if function.name in linked and not function.is_declaration:
            function.linkage = "internal"
    _numba_optimise(library)


if CPUCodeLibrary._optimize_final_module.__module__ != __name__:
    _numba_optimise = CPUCodeLibrary._optimize_final_module
    CPUCodeLibrary._optimize_final_module = _optimise
