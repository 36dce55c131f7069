"""A process without a home, without PATH, or with standard streams that are closed or that nobody reads."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hybrid.runtime import environment
from hybrid.runtime.errors import SceneError
from hybrid.runtime.kernel_cache import VARIABLE, require_folder

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def variables(monkeypatch, tmp_path):
    """Environment with a folder for temporary files and nothing else; changes are undone."""
    for name in ("HOME", *environment.FOLDERS, "PETSC_OPTIONS"):
        monkeypatch.setenv(name, "")    # so that it is restored
        monkeypatch.delenv(name)
    monkeypatch.setattr(environment.tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    return monkeypatch


def below_a_file(folder):
    """A folder that even root cannot make."""
    (folder / "file").touch()
    return folder / "file/home"


def test_a_home_that_cannot_be_written_is_replaced(variables, tmp_path):
    variables.setenv("HOME", str(below_a_file(tmp_path)))
    variables.setenv("PATH", "")
    environment.prepare()
    folder = tmp_path / f"temporary/hybrid-{os.getuid()}"
    assert Path(os.environ["HOME"]) == folder and folder.stat().st_mode & 0o777 == 0o700
    assert Path(os.environ["XDG_CACHE_HOME"]) == folder / ".cache"
    assert os.environ["PATH"] == os.defpath


@pytest.mark.parametrize("home", ["", "relative"])
def test_a_home_that_is_no_absolute_path_is_replaced(variables, home):
    variables.setenv("HOME", home)
    environment.prepare()
    assert Path(os.environ["HOME"]).is_dir()


def test_a_home_that_can_be_written_stays(variables, tmp_path):
    variables.setenv("HOME", str(tmp_path))
    variables.setenv("PATH", "/mine")
    environment.prepare()
    assert os.environ["HOME"] == str(tmp_path) and "XDG_CACHE_HOME" not in os.environ and os.environ["PATH"] == "/mine"


def test_a_temporary_folder_of_somebody_else_is_not_used(variables, tmp_path):
    """One that others may write to, and a link, which may lead anywhere."""
    usual = tmp_path / f"temporary/hybrid-{os.getuid()}"
    usual.mkdir()
    usual.chmod(0o777)
    assert environment.private_folder() != usual
    usual.rmdir()
    usual.symlink_to(tmp_path)
    assert environment.private_folder().lstat().st_mode & 0o777 == 0o700


def test_nowhere_to_write_at_all(variables, tmp_path):
    variables.setattr(environment.tempfile, "tempdir", str(below_a_file(tmp_path)))
    assert environment.private_folder() is None
    variables.setenv(VARIABLE, str(tmp_path / "file/kernels"))
    with pytest.raises(SceneError, match="compiled kernels cannot be kept in .*file/kernels: give a folder"):
        require_folder()
    variables.delenv(VARIABLE)
    with pytest.raises(SceneError, match="in any folder"):
        require_folder()


def command(*arguments, **options):
    return subprocess.Popen([sys.executable, "-m", "hybrid", *arguments], cwd=ROOT, stderr=subprocess.PIPE, text=True,
                            **options)


def test_output_that_nobody_reads_ends_without_a_traceback():
    read, write = os.pipe()
    os.close(read)
    process = command("schema", stdout=write)
    os.close(write)
    assert process.communicate()[1] == "" and process.returncode == 141


def test_output_that_does_not_fit_is_one_line():
    with open("/dev/full", "w") as full:
        process = command("schema", stdout=full)
        assert process.communicate()[1] == "hybrid: output: No space left on device\n" and process.returncode == 2


def test_messages_that_do_not_fit_change_no_exit_code(tmp_path):
    code = ("import contextlib, sys\nfrom hybrid.cli import main\nwith contextlib.suppress(OSError):\n"
            "    sys.stderr.write('note')\nsys.exit(main(['schema', '--out', sys.argv[1]]))")
    with open("/dev/full", "w") as full:
        done = subprocess.run([sys.executable, "-c", code, tmp_path / "schema.json"], stderr=full)
    assert done.returncode == 0


@pytest.mark.parametrize("closed", [(1,), (0, 1, 2)])
def test_closed_streams_are_not_given_to_files(closed, tmp_path):
    """The file that is opened next would get their number, and what libraries print."""
    code = ("import sys, os; from hybrid.cli import main; main(['schema', '--out', sys.argv[1]]); "
            "file = open(sys.argv[1], 'a'); assert file.fileno() > 2; os.write(1, b'lost')")
    path = tmp_path / "schema.json"

    def close():
        for number in closed:
            os.close(number)

    done = subprocess.run([sys.executable, "-c", code, str(path)], cwd=ROOT, preexec_fn=close)
    assert done.returncode == 0 and path.read_text().endswith("}\n")


def test_the_set_up_script_needs_no_path():
    done = subprocess.run(["/bin/sh", ROOT / "run"], env={"PATH": ""}, capture_output=True, text=True)
    assert done.returncode == 0 and "run SCENE.toml" in done.stdout and not done.stderr


@pytest.mark.parametrize("out", ["", " "])
def test_a_folder_without_a_name_is_refused(out):
    process = command("run", "demos/first.toml", "--out", out)
    assert "names no folder; leave the option out" in process.communicate()[1] and process.returncode == 2
