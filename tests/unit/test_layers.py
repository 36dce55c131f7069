"""The import rules of pyproject.toml hold for the package, and would be seen to fail if broken; lines fit a screen."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("importlinter")

ROOT = Path(__file__).resolve().parents[2]
WIDTH = 125      # characters of a line of code
LINT = """
import sys
from importlinter.cli import lint_imports
sys.exit(lint_imports(config_filename="pyproject.toml", no_cache=True))
"""


def lint(folder):
    """Exit status and report of import-linter on the package and contracts in `folder`."""
    done = subprocess.run([sys.executable, "-c", LINT], cwd=folder, capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def test_contracts_hold():
    status, report = lint(ROOT)
    assert status == 0, report


@pytest.mark.parametrize(
    "module, line, contract",
    [
        ("laws/hencky.py", "import hybrid.soil.basis", "Imports only downwards"),
        ("soil/basis.py", "import hybrid.body.surface", "Imports only downwards"),
        ("stranger.py", "", "Imports only downwards"),
        ("contact/soil_to_body.py", "from petsc4py import PETSc", "Each outside library in one module or two"),
    ],
)
def test_a_broken_rule_is_seen(tmp_path, module, line, contract):
    shutil.copytree(ROOT / "hybrid", tmp_path / "hybrid", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    with open(tmp_path / "hybrid" / module, "a") as file:
        file.write(f"\n{line}\n")
    status, report = lint(tmp_path)
    assert status != 0 and f"{contract} BROKEN" in report, report
    assert "hybrid." + module.removesuffix(".py").replace("/", ".") in report, report


@pytest.mark.parametrize("folder", ["hybrid", "tests", "demos"])
def test_lines_fit_a_screen(folder):
    for path in sorted((ROOT / folder).rglob("*.py")):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            assert len(line) <= WIDTH, f"{path.relative_to(ROOT)}:{number}"


@pytest.mark.parametrize("package", ["contact", "linalg", "soil", "step"])
def test_a_package_lists_its_modules(package):
    """So that a reader finds what a step consists of without opening each."""
    folder = ROOT / "hybrid" / package
    listed = (folder / "__init__.py").read_text(encoding="utf-8")
    missing = [path.name for path in folder.glob("*.py") if path.name != "__init__.py" and path.name not in listed]
    assert missing == []
