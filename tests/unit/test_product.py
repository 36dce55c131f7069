"""Product of the soil block with a vector."""

import numba
import numpy as np
import pytest
from petsc4py import PETSc
from scipy.sparse import csr_matrix, random

from hybrid.linalg.product import ROWS, Product


def matrix(rows):
    """Rows of every length from 0 on, in no order."""
    return csr_matrix(random(rows, rows, 0.1, random_state=1) + random(rows, rows, 0.01, random_state=2))


@pytest.mark.parametrize("rows", [1, 7, ROWS, 3 * ROWS + 5])
@pytest.mark.parametrize("threads", [1, 2])
def test_it_is_that_of_the_matrix(rows, threads):
    A, before = matrix(rows), numba.get_num_threads()
    product = PETSc.Mat().createPython((rows, rows), Product(A.indptr, A.indices, A.data), comm=PETSc.COMM_SELF)
    product.setUp()
    x, y = product.createVecs()
    v, x.array, y.array = y.duplicate(), np.arange(1.0, rows + 1), np.full(rows, 7.0)
    try:
        numba.set_num_threads(threads)
        product.mult(x, y)
        np.testing.assert_allclose(y.array, A @ x.array, rtol=1e-13)
        v.array = np.ones(rows)
        product.multAdd(x, v, y)
        np.testing.assert_allclose(y.array, A @ x.array + 1.0, rtol=1e-13)
        product.multAdd(x, y, y)        # as nested matrices do
        np.testing.assert_allclose(y.array, 2 * (A @ x.array) + 1.0, rtol=1e-13)
    finally:
        numba.set_num_threads(before)


def test_it_follows_the_values():
    A = matrix(9)
    product, x, y = Product(A.indptr, A.indices, A.data), PETSc.Vec().createSeq(9), PETSc.Vec().createSeq(9)
    x.array = 1.0
    A.data *= 3.0
    product.mult(None, x, y)
    np.testing.assert_allclose(y.array, A @ x.array)
