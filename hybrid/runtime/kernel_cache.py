"""Where compiled kernels are kept: a folder for each version of their sources.

Numba compiles a kernel again when the file of the kernel changes. It does not when a function or a constant of another
file changes that the kernel uses. So the name of the folder is a digest of all files in the folders with kernels: a new
version of the package never runs kernels of an old one. Kernels of a package that somebody else has installed and
used are taken over: they are copied to a folder of the user.
"""

import contextlib
import hashlib
import os
import shutil
import sys
import tempfile
from pathlib import Path

from hybrid.runtime.environment import private_folder
from hybrid.runtime.errors import SceneError

PACKAGE = Path(__file__).resolve().parents[1]
VARIABLE = "NUMBA_CACHE_DIR"    # read when numba is imported


def choose_folder():
    """Have numba keep kernels in the first of these that can be written, unless the environment names a folder: the
    package itself, the user's cache, a private folder for temporary files. Folders of older versions in it are removed.
    """
    if VARIABLE in os.environ:
        return
    name = f"kernels-{digest()}"
    for place in (PACKAGE / "__pycache__", _user_cache(), private_folder()):
        if place is not None and _made(place / name):
            os.environ[VARIABLE] = str(place / name)
            if "numba" in sys.modules:      # it has read the variable already
                sys.modules["numba"].config.CACHE_DIR = os.environ[VARIABLE]
            return


def require_folder():
    """SceneError where kernels cannot be kept anywhere: numba would refuse to compile them."""
    folder = os.environ.get(VARIABLE, "")
    try:
        os.makedirs(folder, exist_ok=True)
        writable = os.access(folder, os.W_OK | os.X_OK)
    except OSError:
        writable = False
    if not writable:
        raise SceneError(f"compiled kernels cannot be kept in {folder or 'any folder'}: give a folder that you may "
                         f"write to by the variable {VARIABLE}, or by TMPDIR one for all temporary files")


def _made(folder):
    """Whether a folder for kernels is there and can be written, after an attempt to make it."""
    try:
        if not folder.is_dir():
            for old in folder.parent.glob("kernels-*"):
                shutil.rmtree(old, ignore_errors=True)
            _fill(folder)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def _fill(folder):
    """Make a folder for kernels, with those of the package in it where it has any."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    new = Path(tempfile.mkdtemp(dir=folder.parent))     # complete before another process sees it
    with contextlib.suppress(OSError, shutil.Error):
        shutil.copytree(PACKAGE / "__pycache__" / folder.name, new, dirs_exist_ok=True)
    new.chmod(0o755 if folder.parent.parent == PACKAGE else 0o700)
    try:
        new.rename(folder)
    except OSError:
        shutil.rmtree(new, ignore_errors=True)
        if not folder.is_dir():
            raise


def digest(package=PACKAGE):
    """Digest of all files in the folders with kernels, as text."""
    texts = {path: path.read_bytes() for path in sorted(Path(package).rglob("*.py"))}
    folders = {path.parent for path, text in texts.items() if b"njit" in text and path.parent.name != "runtime"}
    found = hashlib.sha1()
    for path, text in texts.items():
        if path.parent in folders:
            found.update(path.name.encode() + text)
    return found.hexdigest()[:12]


def _user_cache():
    """Folder of the user's caches, None for a user without a home."""
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "hybrid"
    except RuntimeError:
        return None
