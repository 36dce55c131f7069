"""Kernels give the same bits in the process that compiles them and in those that read them from disk."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from interrupted_runs import different, start, write_scene

import hybrid
from hybrid.runtime.jit import njit, prange


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


def test_all_kernels_have_them():
    """Each takes njit from hybrid.runtime.jit."""
    package = Path(hybrid.__file__).parent
    texts = {path.relative_to(package): path.read_text() for path in package.rglob("*.py")}
    kernels = [path for path, text in texts.items() if "@njit" in text]
    assert {"soil", "contact"} <= {path.parts[0] for path in kernels}
    assert [path for path in kernels if "from hybrid.runtime.jit import njit" not in texts[path]] == []


def test_no_kernel_with_fastmath_has_a_whole_number_power():
    """It would be fused with a sum or not by what the process has compiled before: a run that had to compile one kernel
    again ended otherwise than the one before."""
    found = []
    for path in Path(hybrid.__file__).parent.rglob("*.py"):
        for function in ast.walk(ast.parse(path.read_text())):
            if isinstance(function, ast.FunctionDef) and any("contract" in ast.unparse(d) for d in function.decorator_list):
                found += [f"{path.name}: {ast.unparse(node)}" for node in ast.walk(function) if isinstance(node, ast.BinOp)
                          and isinstance(node.op, ast.Pow) and isinstance(node.right, ast.Constant)]
    assert found == []


def test_meshing_starts_without_numba():
    code = "import sys, hybrid.body.mesh_worker; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


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
