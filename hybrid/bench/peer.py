"""Runs of Kratos Multiphysics in its own Python, by the scripts kratos_*.py of this folder."""

import json
import os
import subprocess
import tempfile
from pathlib import Path

from hybrid.runtime.errors import HybridError, SceneError

NEEDED = "KratosMultiphysics, KratosMPMApplication and KratosLinearSolversApplication"


def checked(python):
    """The path given by --peer. Raises SceneError if there is no such file."""
    if python is not None and not Path(python).is_file():
        raise SceneError(f"--peer {python}: no such file; give the python of an environment with Kratos MPM")
    return python


def version(python):
    """Version of the MPM application of a Python, as text. Raises HybridError if it has none."""
    program = "from importlib.metadata import version; print(version('KratosMPMApplication'))"
    return _ran(python, ["-c", program], None, 1).strip()


def ask(python, script, described, threads):
    """Dict that a `script` of this folder prints for the arguments `described`, a dict for JSON, run on `threads`
    threads. Raises HybridError with the end of its output if it fails."""
    with tempfile.TemporaryDirectory() as folder:
        printed = _ran(python, [Path(__file__).with_name(script), json.dumps(described)], folder, threads)
    results = [line for line in printed.splitlines() if line.startswith("RESULT")]
    if not results:
        raise _failed(printed)
    return json.loads(results[-1].removeprefix("RESULT"))


def _ran(python, arguments, folder, threads):
    """Standard output of the peer's Python with these arguments."""
    # Our environment without the variables that misdirect another Python.
    plain = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run([str(python), *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                          env={**plain, "OMP_NUM_THREADS": str(threads), "PYTHONDONTWRITEBYTECODE": "1"})
    if done.returncode:
        raise _failed(done.stderr or done.stdout)
    return done.stdout


def _failed(output):
    return HybridError(f"the peer failed: {output.strip()[-500:]}; --peer wants a python with {NEEDED}")
