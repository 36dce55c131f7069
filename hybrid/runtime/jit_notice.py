"""A notice when kernels are compiled. Numba keeps compiled kernels on disk, so that a run compiles only those that no
run before it has used: the first scene most of them, later scenes those of another law or kind of contact."""

import sys
from contextlib import suppress

from numba.core import event

TEXT = "hybrid: compiling kernels that are used for the first time and kept for later runs; takes one to two minutes"


def compilation_notice(stream=None):
    """Context in which one line is written to `stream` (default: stderr) when the first kernel of hybrid is compiled.

    There is no notice for kernels that are read from disk, nor for those of a user's own law.
    """
    return event.install_listener("numba:compile", _Notice(stream or sys.stderr))


class _Notice(event.Listener):
    def __init__(self, stream):
        self._stream, self._printed = stream, False

    def on_start(self, compiled):
        module = compiled.data["dispatcher"].py_func.__module__ or ""   # numba's own functions may have none
        if not self._printed and module.split(".")[0] == "hybrid":
            self._printed = True
            with suppress(OSError, ValueError, AttributeError):     # nobody reads the stream any more
                clear = "\r\x1b[2K" if self._stream.isatty() else ""   # the line of progress
                print(clear + TEXT, file=self._stream, flush=True)

    def on_end(self, compiled):
        """Required of a listener."""
