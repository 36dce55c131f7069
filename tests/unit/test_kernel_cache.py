"""Compiled kernels are kept by the version of their sources, where the user may write."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from hybrid.runtime import kernel_cache

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def own_folder(monkeypatch):
    """Kernels of other tests stay where they are."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", numba.config.CACHE_DIR)


def test_numba_may_have_been_imported_before():
    code = "import os, numba, hybrid; assert numba.config.CACHE_DIR == os.environ['NUMBA_CACHE_DIR'] != ''"
    environment = {name: value for name, value in os.environ.items() if name != kernel_cache.VARIABLE}
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=environment, check=True)


@pytest.fixture
def package(tmp_path):
    """A small package: kernels in a/, a constant that they take in beside them, and no kernels in b/."""
    for name, text in {"a/kernel.py": "@njit\n", "a/constant.py": "N = 1\n", "b/other.py": "M = 1\n"}.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize("name, differs", [("a/kernel.py", True), ("a/constant.py", True), ("b/other.py", False)])
def test_a_change_beside_a_kernel_is_a_new_version(package, name, differs):
    before = kernel_cache.digest(package)
    assert kernel_cache.digest(package) == before
    (package / name).write_text("changed njit" if "kernel" in name else "N = 2\n")
    assert (kernel_cache.digest(package) != before) == differs


def test_folders_of_older_versions_are_removed_and_the_present_one_is_kept(tmp_path, monkeypatch):
    monkeypatch.delenv(kernel_cache.VARIABLE)
    monkeypatch.setattr(kernel_cache, "PACKAGE", tmp_path)
    (tmp_path / "__pycache__/kernels-old").mkdir(parents=True)
    kernel_cache.choose_folder()
    folder = Path(os.environ[kernel_cache.VARIABLE])
    assert [folder] == list((tmp_path / "__pycache__").glob("kernels-*"))
    (folder / "kept").touch()
    monkeypatch.delenv(kernel_cache.VARIABLE)
    kernel_cache.choose_folder()
    assert os.environ[kernel_cache.VARIABLE] == str(folder) and (folder / "kept").exists()


def test_a_folder_that_the_user_names_stays(monkeypatch, tmp_path):
    monkeypatch.setenv(kernel_cache.VARIABLE, str(tmp_path))
    kernel_cache.choose_folder()
    assert os.environ[kernel_cache.VARIABLE] == str(tmp_path) and not list(tmp_path.iterdir())


def test_a_package_that_cannot_be_written_leaves_the_users_cache(monkeypatch, tmp_path):
    """A file stands where the folder would be, as root may write anywhere."""
    (tmp_path / "__pycache__").touch()
    monkeypatch.delenv(kernel_cache.VARIABLE)
    monkeypatch.setattr(kernel_cache, "PACKAGE", tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    kernel_cache.choose_folder()
    assert Path(os.environ[kernel_cache.VARIABLE]).parent == tmp_path / "cache/hybrid"


def test_a_kernel_that_takes_in_a_changed_function_is_compiled_again(tmp_path):
    """The fault that the folders are for: without them the second run prints 1 again."""
    shutil.copytree(ROOT / "hybrid/runtime", tmp_path / "hybrid/runtime", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "hybrid/__init__.py", tmp_path / "hybrid")
    folder = tmp_path / "hybrid/kernels"
    folder.mkdir()
    (folder / "outer.py").write_text(
        "from numba import njit\nfrom hybrid.kernels.inner import f\n\n@njit(cache=True)\ndef g():\n    return f()\n")
    environment = {name: value for name, value in os.environ.items() if name != kernel_cache.VARIABLE}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"    # bytecode of a file changed within a second would be kept

    def run(value, **more):
        (folder / "inner.py").write_text(f"from numba import njit\n\n@njit(cache=True)\ndef f():\n    return {value}\n")
        code = "from hybrid.kernels.outer import g; print(g())"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path,
                              env={**environment, "PYTHONPATH": str(tmp_path), **more})
        return int(done.stdout)

    assert [run(1), run(2)] == [1, 2]
    fixed = {kernel_cache.VARIABLE: str(tmp_path / "fixed")}
    assert [run(1, **fixed), run(2, **fixed)] == [1, 1]
