"""The wheel holds all that the package needs, and works outside the checkout."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = "hybrid geometry demos pyproject.toml README.md LICENSE".split()


def executed(*arguments, cwd, **environment):
    """Standard output of this Python, started in folder `cwd`."""
    done = subprocess.run([sys.executable, *map(str, arguments)], cwd=cwd, env={**os.environ, **environment},
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Path of a wheel built from a copy, so that nothing is left in the checkout."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    source.mkdir()
    for name in SOURCES:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copyfile
        more = {"symlinks": True, "ignore": shutil.ignore_patterns("__pycache__")} if copy is shutil.copytree else {}
        copy(ROOT / name, source / name, **more)
    executed("-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "-w", folder, ".", cwd=source)
    path, = folder.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel):
    """Folder that the wheel is installed in."""
    target = wheel.parent / "installed"
    executed("-m", "pip", "install", "--no-deps", "--target", target, wheel, cwd=wheel.parent)
    return target


def test_files_of_the_wheel(wheel):
    """All of the package, shipped scenes, scripts and geometries, and nothing else."""
    with ZipFile(wheel) as archive:
        held = {name for name in archive.namelist() if ".dist-info/" not in name}
    package = {str(path.relative_to(ROOT)) for suffix in ("py", "json", "md")
               for path in (ROOT / "hybrid").rglob(f"*.{suffix}") if path.resolve().is_relative_to(ROOT / "hybrid")}
    patterns = ("geometry/*.geo", "geometry/*.step", "demos/*.csv", "demos/*.toml", "demos/*.py")
    shipped = {f"hybrid/data/{path.relative_to(ROOT)}" for pattern in patterns for path in ROOT.glob(pattern)}
    assert held == package | shipped


def test_commands_outside_the_checkout(wheel, installed, tmp_path):
    """From another folder and with the installed package alone: a shipped scene is copied and read, a geometry
    meshed, and the shipped files are the wheel's own."""
    def hybrid(*arguments):
        return executed("-m", "hybrid", *arguments, cwd=tmp_path, PYTHONPATH=str(installed))

    place = "import hybrid, hybrid.runtime.data as data; print(hybrid.__file__, data.DEMOS, data.GEOMETRY)"
    places = executed("-c", place, cwd=tmp_path, PYTHONPATH=str(installed)).split()
    assert all(Path(each).is_relative_to(installed) for each in places)
    assert hybrid("--version") == f"hybrid {wheel.name.split('-')[1]}\n"
    assert hybrid("demos", "rolling_sphere").split() == ["hybrid", "run", "demos/rolling_sphere.toml"]
    read = "import hybrid; print(hybrid.load_scene('demos/rolling_sphere.toml').bodies[0].geometry)"
    geometry = Path(executed("-c", read, cwd=tmp_path, PYTHONPATH=str(installed)).strip())
    assert geometry.is_file() and geometry.is_relative_to(tmp_path)
    assert "watertight" in hybrid("mesh", "geometry/sphere.geo")


@pytest.mark.slow   # compiles all kernels
def test_a_check_a_bench_and_a_study_outside_the_checkout(installed, tmp_path):
    executed("-m", "hybrid", "demos", "rolling_sphere", cwd=tmp_path, PYTHONPATH=str(installed))
    for arguments in (("check", "demos/rolling_sphere.toml"), ("bench", "sphere", "anchor", "--quick"),
                      ("study", "precision", "platen", "--quick")):
        executed("-m", "hybrid", *arguments, cwd=tmp_path, PYTHONPATH=str(installed))
