"""How far a run is: one line on a terminal, rewritten after each step; elsewhere a line now and then.

Notes, at the end those whose values have changed since, and the closing line, which says where the results are, are
permanent lines on both. A stream that can no longer be written is left alone: the run goes on without it.
"""

import shutil
import sys
import time

from hybrid.body.symmetry import copies, part_of_whole
from hybrid.runtime.units import force

IN_PLACE = "in place from the start"    # row of the model sheet that is reported before the first step
INTERVAL, SHARE = 30.0, 0.05    # without a terminal: seconds, and share of all steps, from one line to the next


class Progress:
    """Observer that writes to `stream` (default stderr); folder: of the results, for the closing line."""

    def __init__(self, stream=None, folder=None):
        self.stream = stream or sys.stderr
        self.folder = folder
        self.live = self._try(lambda: self.stream.isatty())

    def start(self, simulation):
        self.began = self.printed = time.perf_counter()
        self.first = self.step = simulation.state.step
        if not self.first:
            planes = part_of_whole(simulation.mirrors)
            if planes and any(stage.loads for stage in simulation.scene.stages):
                planes += f"; loads of stages act on this part, {copies(simulation.mirrors)} times as much on the whole"
            for text in [*simulation.start.get(IN_PLACE, ()), *([f"symmetry: {planes}"] if planes else [])]:
                self._print(text)
        self._show("starting the first step")

    def accepted(self, record, simulation):
        for note in record.notes:
            self._print(note)
        done, left = record.step - self.first, simulation.total_steps - record.step
        remaining = (time.perf_counter() - self.began) / done * left
        steps = {stage.name: stage.steps for stage in simulation.scene.stages}
        line = describe(record, steps.get(record.stage, "?"), remaining)
        self._show(line)
        if not self.live and left and self._due(record.step, simulation.total_steps):
            self._print(line)

    def _due(self, step, total):
        """Whether the next line of a stream that is no terminal is due."""
        now = time.perf_counter()
        due = now - self.printed >= INTERVAL or step - self.step >= max(1.0, SHARE * total)
        if due:
            self.printed, self.step = now, step
        return due

    def finish(self, summary, simulation):
        for note in simulation.later_notes.values():
            self._print(f"at the end: {note}")
        where = f"; results in {self.folder}" if self.folder else ""
        self._print(f"{simulation.scene.name}: {summary['outcome']}, {self._steps(simulation)}{where}")

    def _steps(self, simulation):
        """How many steps were made, which of a resumed run, and in what time."""
        step, seconds = simulation.state.step, time.perf_counter() - self.began
        if self.first >= simulation.total_steps:
            return (f"nothing was left to do: the checkpoint has step {self.first}, and the scene has "
                    f"{simulation.total_steps}")
        which = f", {self.first + 1} to {step}," if self.first and step > self.first else ""
        return f"{step - self.first} steps{which} in {clock(seconds)}"

    def _print(self, text):
        """Write a permanent line above the line of progress."""
        self._show("")
        self._write(text + "\n")

    def _show(self, line):
        if self.live:
            width = shutil.get_terminal_size().columns - 1
            self._write("\r\x1b[2K" + line[:width])

    def _write(self, text):
        def work():
            self.stream.write(text)
            self.stream.flush()

        if self.stream:
            self._try(work)

    def _try(self, work):
        """Result of `work` with the stream; None, and no stream from then on, where it cannot be used."""
        try:
            return work()
        except (OSError, ValueError, AttributeError):   # the reader is gone; closed; none at all
            self.stream = None
            return None


def describe(record, steps, remaining):
    """The line for one record. steps: outer steps of its stage; remaining: estimated time left [s].

    The most important values come first, as a narrow terminal cuts off the end.
    """
    parts = [
        f"{record.stage} {record.stage_step}/{steps}",
        f"{clock(remaining)} left",
        f"t {record.time:.6g} s",
        f"dt {record.dt:.3g} s",
        f"{record.iterations} iterations",
        f"residual {record.residual:.1e}",
        f"{record.contacts} contacts",
    ]
    parts += [f"tension {force(copies(body.mirrors) * body.line_tension)}{' of the whole' * bool(body.mirrors)}"
              for body in record.bodies if body.line_tension]
    return "  ".join(parts)


def clock(seconds):
    """Duration as m:ss or h:mm:ss."""
    minutes, seconds = divmod(int(round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
