"""Where compiled kernels are kept: a folder for each version of their sources.

Numba compiles a kernel again when the file of the kernel changes. It does not when a function or a constant of another
file changes that the kernel uses. So the name of the folder is a digest of all files in the folders with kernels: a new
version of the package never runs kernels of an old one.
"""

import hashlib
import os
import shutil
import tempfile
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
VARIABLE = "NUMBA_CACHE_DIR"    # read when numba is imported


def choose_folder():
    """Have numba keep kernels in the first of these that can be written, unless the environment names a folder: the
    package itself, the user's cache, the folder for temporary files. Folders of older versions in it are removed."""
    if VARIABLE in os.environ:
        return
    name = digest()
    temporary = Path(tempfile.gettempdir()) / f"hybrid-{os.getuid()}"
    for place in (PACKAGE / "__pycache__", _user_cache() / "hybrid", temporary):
        folder = place / f"kernels-{name}"
        try:
            if not folder.is_dir():
                for old in place.glob("kernels-*"):
                    shutil.rmtree(old, ignore_errors=True)
                folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            os.environ[VARIABLE] = str(folder)
            return


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
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
