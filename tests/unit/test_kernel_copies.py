"""Kernels give the same bits in the process that compiles them and in those that read them from disk."""

import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from interrupted_runs import different, start, write_scene
from numba import njit, prange

import hybrid
from hybrid.runtime import kernel_copies  # noqa: F401 (before the kernel below is compiled)


@njit(parallel=True, fastmath={"contract"})
def fused(a, b, c):
    for i in prange(len(a)):
        c[i] += a[i] * b[i]


def test_a_kernel_has_private_copies_of_the_functions_that_it_calls():
    """The body of a parallel loop is one: it is called through its address, and never inlined."""
    a = np.ones(3)
    fused(a, a, a)
    (code,) = fused.inspect_llvm().values()
    functions = re.findall(r"^define (\w+).*@(\S+)\(", code, re.MULTILINE)
    assert any("gufunc" in name and kind == "internal" for kind, name in functions)
    assert [name for kind, name in functions if kind in ("linkonce_odr", "weak_odr")] == []


def test_all_folders_with_kernels_have_them():
    package = Path(hybrid.__file__).parent
    folders = {path.relative_to(package).parts[0] for path in package.rglob("*.py") if "@njit" in path.read_text()}
    assert {"soil", "contact"} <= folders
    for folder in folders:
        assert "hybrid.runtime.kernel_copies" in Path(import_module(f"hybrid.{folder}").__file__).read_text()


@pytest.mark.slow
def test_the_run_that_compiles_equals_the_next(tmp_path):
    """Minutes: it compiles every kernel of the scene."""
    scene = write_scene(tmp_path)
    for folder in ("first", "second"):
        process = start(scene, tmp_path / folder, environment={"NUMBA_CACHE_DIR": str(tmp_path / "kernels")})
        message = process.communicate()[1]
        assert process.returncode == 0, message
        assert ("compiling" in message) == (folder == "first")
    assert different(tmp_path / "first", tmp_path / "second") == []
