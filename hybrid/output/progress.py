"""One line of progress on the terminal, rewritten after each step of a run."""

import shutil
import sys
import time


class Progress:
    """Observer that rewrites one line of `stream` (default stderr) after every accepted outer step.

    Where the stream is not a terminal only notes and one closing line are written, and only if `announce` is set.
    """

    def __init__(self, stream=None, announce=False, live=True):
        self.stream = stream or sys.stderr
        self.announce = announce
        self.live = live and self.stream.isatty()
        self.line = ""

    def start(self, simulation):
        self.began = time.perf_counter()
        self.first = simulation.state.step
        self._show("starting the first step")

    def accepted(self, record, simulation):
        for note in record.notes:
            self._print(note)
        done, left = record.step - self.first, simulation.total_steps - record.step
        remaining = (time.perf_counter() - self.began) / done * left
        steps = {stage.name: stage.steps for stage in simulation.scene.stages}
        self._show(describe(record, steps.get(record.stage, "?"), remaining))

    def finish(self, summary, simulation):
        steps, seconds = simulation.state.step - self.first, time.perf_counter() - self.began
        reason = f": {summary['reason']}" if summary.get("reason") else ""
        self._print(f"{simulation.scene.name}: {summary['outcome']}, {steps} steps in {clock(seconds)}{reason}")

    def _print(self, text):
        """Write a permanent line above the line of progress."""
        self._show("")
        if self.live or self.announce:
            print(text, file=self.stream, flush=True)

    def _show(self, line):
        if self.live:
            width = shutil.get_terminal_size().columns - 1
            self.stream.write("\r\x1b[2K" + line[:width])
            self.stream.flush()


def describe(record, steps, remaining):
    """The line for one record. steps: outer steps of its stage; remaining: estimated time left [s].

    The most important values come first, as a narrow terminal cuts off the end.
    """
    parts = [
        f"{record.stage} {record.stage_step}/{steps}",
        f"{clock(remaining)} left",
        f"t {record.time:.3f} s",
        f"dt {record.dt:.3g} s",
        f"{record.iterations} iterations",
        f"residual {record.residual:.1e}",
        f"{record.contacts} contacts",
    ]
    parts += [f"tension {force(body.line_tension)}" for body in record.bodies if body.line_tension]
    return "  ".join(parts)


def force(newtons):
    """A force with a suitable unit, such as "12.3 kN"."""
    for limit, unit in ((1e6, "MN"), (1e3, "kN")):
        if abs(newtons) >= limit:
            return f"{newtons / limit:.3g} {unit}"
    return f"{newtons:.3g} N"


def clock(seconds):
    """Duration as m:ss or h:mm:ss."""
    minutes, seconds = divmod(int(round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
