"""Runs of Kratos Multiphysics in its own Python, beside ours: scripts kratos_*.py of this folder."""

import json
import os
import subprocess
import tempfile
from pathlib import Path

from hybrid.runtime.errors import HybridError, SceneError

NEEDED = "KratosMultiphysics, KratosMPMApplication and KratosLinearSolversApplication"


def checked(python):
    """The Python that --peer gives. Raises SceneError where there is no such file."""
    if python is not None and not Path(python).is_file():
        raise SceneError(f"--peer {python}: no such file; give the python of an environment with Kratos MPM")
    return python


def version(python):
    """Of its MPM application, as text. Raises HybridError where it has none."""
    program = "from importlib.metadata import version; print(version('KratosMPMApplication'))"
    return _ran(python, ["-c", program], None, 1).strip()


def ask(python, script, described, threads):
    """Dict that a `script` of this folder tells of what is `described`, a dict as JSON knows it, on so many threads.
    Raises HybridError with its last words where it fails."""
    with tempfile.TemporaryDirectory() as folder:
        printed = _ran(python, [Path(__file__).with_name(script), json.dumps(described)], folder, threads)
    told = [line for line in printed.splitlines() if line.startswith("RESULT")]
    if not told:
        raise _failed(printed)
    return json.loads(told[-1].removeprefix("RESULT"))


def _ran(python, arguments, folder, threads):
    """What it prints."""
    # Ours without what would lead another Python astray.
    plain = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run([str(python), *map(str, arguments)], cwd=folder, capture_output=True, text=True,
                          env={**plain, "OMP_NUM_THREADS": str(threads), "PYTHONDONTWRITEBYTECODE": "1"})
    if done.returncode:
        raise _failed(done.stderr or done.stdout)
    return done.stdout


def _failed(words):
    return HybridError(f"the peer failed: {words.strip()[-500:]}; --peer wants a python with {NEEDED}")
