"""Compiling kernels is announced, once, and only when it happens."""

import io
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from numba import njit

from hybrid.runtime import jit_notice

ROOT = Path(__file__).resolve().parents[2]
COMPILES = """
import numpy as np
from hybrid.kernels import announced
with announced():
    from hybrid.soil.basis import find_cell, hat
    hat(0.5, 0, np.arange(3.0))
    find_cell(0.5, np.arange(3.0))
"""


def test_kernels_are_announced_where_none_are_on_disk(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    said = [subprocess.run([sys.executable, "-c", COMPILES], env=environment, text=True, capture_output=True, check=True)
            for _ in range(2)]
    assert [child.stderr for child in said] == [jit_notice.TEXT + "\n", ""]


def test_functions_of_others_are_not_announced():
    stream = io.StringIO()
    with jit_notice.announced(stream):
        assert njit(lambda x: x + 1)(np.float64(1.0)) == 2.0
    assert stream.getvalue() == ""
