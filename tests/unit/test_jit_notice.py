"""A notice when kernels are compiled: one line, and only when they are."""

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
from hybrid.runtime.jit_notice import compilation_notice
with compilation_notice():
    from hybrid.soil.basis import find_cell, hat
    hat(0.5, 0, np.arange(3.0))
    find_cell(0.5, np.arange(3.0))
"""


def test_the_notice_comes_where_no_kernel_is_on_disk(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    command, options = [sys.executable, "-c", COMPILES], {"text": True, "capture_output": True, "check": True}
    runs = [subprocess.run(command, env=environment, **options)
            for _ in range(2)]
    assert [child.stderr for child in runs] == [jit_notice.TEXT + "\n", ""]


def test_no_notice_for_functions_outside_the_package():
    stream = io.StringIO()
    with jit_notice.compilation_notice(stream):
        assert njit(lambda x: x + 1)(np.float64(1.0)) == 2.0
    assert stream.getvalue() == ""
