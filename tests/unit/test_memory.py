"""Freed large arrays go back to the system, whatever allocator options the loaded libraries have set."""

import ctypes
import subprocess
import sys

import pytest

FREED = """
import ctypes
import sys
import numpy as np
from hybrid.runtime.memory import map_large_arrays

ctypes.CDLL(None).mallopt(-4, 0)    # as SuperLU_DIST does
ctypes.CDLL(None).mallopt(-1, -1)
if sys.argv[1] == "mapped":
    map_large_arrays()

def held():
    return int(open("/proc/self/statm").read().split()[1]) * 4096

before, large = held(), np.ones(10_000_000)
above = [bytes(100_000) for _ in range(20)]     # what comes later keeps the heap from shrinking
del large
print((held() - before) / 8e7)
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "mallopt"), reason="another C library")
@pytest.mark.parametrize("way, least, most", [("mapped", 0.0, 0.2), ("as set", 0.8, 1.2)])
def test_a_large_array_goes_back_when_it_is_freed(way, least, most):
    output = subprocess.run([sys.executable, "-c", FREED, way], capture_output=True, text=True, check=True).stdout
    assert least <= float(output) <= most
