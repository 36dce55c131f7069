"""Telling the user when kernels are compiled. Numba keeps them on disk, so that happens once, and takes a while."""

import sys

from numba.core import event

TEXT = "hybrid: compiling kernels, once on this machine; up to a minute where none is there yet"


def announced(stream=None):
    """Context in which one line is written to `stream` (default: stderr) when the first kernel of hybrid is compiled.

    Kernels that are read from disk, and those of a user's own law, are not announced.
    """
    return event.install_listener("numba:compile", _Announcement(stream or sys.stderr))


class _Announcement(event.Listener):
    def __init__(self, stream):
        self._stream, self._told = stream, False

    def on_start(self, compiled):
        module = compiled.data["dispatcher"].py_func.__module__ or ""   # numba's own functions may have none
        if not self._told and module.split(".")[0] == "hybrid":
            clear = "\r\x1b[2K" if self._stream.isatty() else ""   # of the line that tells the progress
            print(clear + TEXT, file=self._stream, flush=True)
            self._told = True

    def on_end(self, compiled):
        """A listener has to have this."""
