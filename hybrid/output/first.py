"""Observers in a run by several processes: all of these have the same ones, in the same order, and call them together.

An observer that writes for all of them is of the first process alone: `First` stands for it in the others. It is shown the
simulation of the first process, with its own points; numbers in the record, and bodies, are those of the whole run
anyway. Only a picture needs the points of all, and a frame of a body the forces on all of its surface: they are collected
when one is due.
"""

from hybrid.output import errors_of
from hybrid.runtime import comm, ranks
from hybrid.runtime.stop_signals import Stopped


class First:
    """The observer that `make` gives in the first process. shown: function, which all processes call, of a simulation and
    the name of the method to be called, that gives what the observer sees; alone: whether `finish` may be called without
    the others."""

    def __init__(self, make, shown=lambda simulation, call: simulation, alone=True):
        self._observer, self._shown, self._alone = ranks.in_first(make), shown, alone

    def start(self, simulation):
        self._call("start", simulation)

    def accepted(self, record, simulation):
        self._call("accepted", simulation, record)

    def finish(self, summary, simulation):
        self._call("finish", simulation, summary)

    def finish_alone(self, summary, simulation):
        """`finish` where the first process does not know what the others do."""
        if self._observer and self._alone:
            self._notify("finish", simulation, summary)

    def _call(self, name, simulation, *given):
        shown = self._shown(simulation, name)
        ranks.in_first(lambda: self._notify(name, shown, *given))

    def _notify(self, name, simulation, *given):
        with errors_of(self._observer), comm.alone():
            getattr(self._observer, name)(*given, simulation)


class StopAfterStep:
    """Observer that stops all processes after a step in which a signal has come to any of them and has not stopped it
    already: one process has lost the exception if it came in a callback of a library, such as that of a kernel's
    compiler."""

    def __init__(self, signals):
        self._signals = signals

    def start(self, simulation):
        """Nothing to prepare."""

    def accepted(self, record, simulation):
        if number := int(comm.largest([self._signals.noted])):
            raise Stopped(number, of_all=ranks.started() > 1)

    def finish(self, summary, simulation):
        """Nothing to do."""
