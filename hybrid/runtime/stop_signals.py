"""SIGINT, SIGTERM and SIGHUP stop a run as Ctrl-C does: an exception at the next Python instruction, whose handling writes
the checkpoint. A second signal ends the process at once; files are moved into place only when complete, so it does no
harm.

What PETSc calls back must not be left by an exception: it would take it for an error of its own, and keep its vectors
locked. A signal during a linear solution is held back until that has ended.

Several processes must not leave one another in the middle of an exchange: while they compute, a signal to any of them is
noted, and all of them stop after the outer step.
"""

import signal
import threading
from contextlib import contextmanager

STOPPING = signal.SIGINT, signal.SIGTERM, signal.SIGHUP


class Stopped(KeyboardInterrupt):
    """A signal has ended the run. number: of the signal; exit_code: as shells report it; kept: number of the step of the
    checkpoint on disk, None if there is none; of_all: whether all processes of several stop here."""

    kept = None

    def __init__(self, number, of_all=False):
        super().__init__(signal.Signals(number).name)
        self.of_all = of_all
        self.number, self.exit_code = number, 128 + number


class _HeldBack:
    """Whether signals are held back, and the number of the one that has come since, 0 of none."""

    active, number = False, 0


@contextmanager
def held_back():
    """Context at the end of which a stopping signal that has come in it raises Stopped."""
    _HeldBack.active = True
    try:
        yield
    finally:
        number, _HeldBack.active, _HeldBack.number = _HeldBack.number, False, 0
        if number:
            raise Stopped(number)


@contextmanager
def stop_signals():
    """Context in which the stopping signals raise Stopped; gives its Signals. Those that the parent has set to be ignored
    (nohup) stay ignored. Only the main thread gets signals: elsewhere the context does nothing."""
    signals = Signals()
    signals.take()
    try:
        yield signals
    finally:
        signals.release()


class Signals:
    """The handlers of the stopping signals. noted: number of the one that has come, 0 of none."""

    noted = 0

    def __init__(self):
        own = threading.current_thread() is threading.main_thread()
        self._before = {number: signal.getsignal(number) for number in STOPPING
                        if own and signal.getsignal(number) is not signal.SIG_IGN}

    def take(self):
        """Have the signals raise Stopped."""
        for number in self._before:
            signal.signal(number, self._stop)

    def note(self):
        """Have the signals noted instead; returns this object."""
        for number in self._before:
            signal.signal(number, self._note)
        return self

    def _note(self, number, _):
        self.noted = number
        for each in self._before:
            signal.signal(each, signal.SIG_DFL)

    def release(self):
        """Give the signals back to whoever had them."""
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)

    def _stop(self, number, _):
        self._note(number, _)
        if _HeldBack.active:
            _HeldBack.number = number
        else:
            raise Stopped(number)
