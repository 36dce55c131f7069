"""A stand-in for another program's interpreter."""

import sys


def interpreter(folder, text):
    """Path of a command in a folder that runs the Python program `text` with the arguments it is given."""
    (folder / "fake.py").write_text(text)
    path = folder / "python"
    path.write_text(f'#!/bin/sh\nexec {sys.executable} {folder}/fake.py "$@"\n')
    path.chmod(0o755)
    return path
