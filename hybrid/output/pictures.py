"""Three-dimensional pictures of soil and bodies, coloured by vertical displacement since the run began.

The soil is drawn as the domains of its points (boxes x_p ± l_p), viewed obliquely from the side of small y,
where a half model has its symmetry plane, so that the cut through soil and body faces the viewer.

VTK ends the whole process when it finds no OpenGL. A picture is therefore drawn by a child process
(`hybrid.output.picture_worker`): without OpenGL a run only loses its pictures, with a warning that gives the reason.
The run continues while the child works; one child works at a time.
"""

import logging
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from hybrid.body.embedded_line import shape_in_soil
from hybrid.body.rigid import line_ends
from hybrid.body.symmetry import copies
from hybrid.output import atomic
from hybrid.output.history import NAME as HISTORY
from hybrid.output.history import body_names, read_history
from hybrid.output.record import drawn, placed

log = logging.getLogger("hybrid")

TIME_LIMIT = 300.0  # seconds for one picture
SHARES = (1.0, 0.5, 0.25)    # of the pull at the end of a run, at which lines in soil are drawn
GRACE = 3.0         # seconds that an interrupted run still waits for one
NOTHING = 1e-8       # cells of displacement that is drawn as none
# EGL needs no X server; where it is missing VTK may choose for itself.
TRIES = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}, {}
REMEDY = "try: apt install libegl1 libgl1-mesa-dri (off-screen OpenGL), pip install pyvista"


class Pictures:
    """Observer that writes soil_step_005.png, ... at the steps `scene.output.pictures`, counted from the
    start of the last stage, and trajectory.png, line_tension.png, resistance.png, parts.png and line_in_soil.png at the
    end."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def start(self, simulation):
        self.initial = simulation.initial_bodies
        self.drawing = None

    def accepted(self, record, simulation):
        if picture_due(simulation):
            step = step_of_last_stage(simulation)
            self._collect()
            caption = f"{record.stage}: step {step}, time {record.time:.4g} s"
            path = self.folder / f"soil_step_{step:03d}.png"
            self.drawing = Drawing(path, scene_arrays(simulation, self.initial), caption)

    def finish(self, summary, simulation):
        if summary["outcome"] == "interrupted":
            self._collect(GRACE)    # the figures of the whole run come with its end
            return
        try:
            self._figures(simulation)
        finally:
            self._collect()

    def _figures(self, simulation):
        history = read_history(self.folder) if (self.folder / HISTORY).exists() else {}
        if not simulation.body_names or not len(history.get("step", ())):
            return
        # late: matplotlib takes a while, and most of a run does without
        from hybrid.output import body_figures, figures, trajectory

        trajectory.trajectory(self.folder, simulation.model.soil.grid.smallest_cell)
        if any(np.any(history[f"{name}_tension_N"]) for name in body_names(history)):
            figures.tension(self.folder)
        initial = {name: state.position for name, state in zip(simulation.body_names, simulation.initial_bodies)}
        body_figures.resistance(self.folder, initial)
        body_figures.parts(self.folder, initial, _part_areas(simulation))
        body_figures.line_in_soil(self.folder, _line_shapes(simulation))

    def _collect(self, limit=TIME_LIMIT):
        if self.drawing:
            self.drawing.collect(limit)
        self.drawing = None


def step_of_last_stage(simulation):
    """Number of the present step from the start of the last stage."""
    return simulation.state.step - sum(stage.steps for stage in simulation.scene.stages[:-1])


def picture_due(simulation):
    """Whether there is to be a picture of the present step."""
    return step_of_last_stage(simulation) in simulation.scene.output.pictures


def with_points_if_drawn(simulation, call):
    """What Pictures see of one of several processes: the points of all where a picture is due."""
    return simulation.with_all_points() if call == "accepted" and picture_due(simulation) else simulation


def _part_areas(simulation):
    """Areas of the parts of bodies, as `hybrid.output.body_figures.parts` takes them."""
    areas = {}
    for body, motion in zip(simulation.model.bodies, simulation.state.bodies):
        if body.parts:
            times = copies([mirror for mirror in body.mirrors if mirror.cut])
            seen = {axis: times * np.array([body.parts.across(-row), body.parts.across(row)])
                    for axis, row in zip("xyz", motion.rotation)}
            areas[body.name] = {name: (times * area, {axis: both[:, k] for axis, both in seen.items()})
                                for k, (name, area) in enumerate(zip(body.parts.names, body.parts.area))}
    return areas


def _line_shapes(simulation):
    """Shapes of lines that cut through soil, at shares of the present pull, as `body_figures.line_in_soil` takes them."""
    shapes = {}
    for body, motion in zip(simulation.model.bodies, simulation.state.bodies):
        if body.line and body.line.soil and motion.target is not None:
            line = body.line
            depth = line.soil.mudline - (motion.position + motion.rotation @ line.attachment)[2]
            pull, angle = line_ends(line, motion)[:2]
            if pull > 0.0 and depth > 0.0:
                shapes[body.name] = [(f"{100 * share:g} % of the pull", shape_in_soil(share * pull, angle, depth, line.soil))
                                     for share in SHARES]
    return shapes


def scene_arrays(simulation, initial):
    """Arrays that the child draws: box centres and half-widths (n, 3) [m], body vertices (V, 3) [m] and triangles
    (t, 3) of all bodies together, vertical displacements `soil` (n,) and `body` (V,) [m], colour `limit`."""
    (points, before), state = drawn(simulation), simulation.state
    soil = points.position[:, 2] - before[:, 2]
    vertices, triangles, moved, count = [np.zeros((0, 3))], [np.zeros((0, 3), int)], [np.zeros(0)], 0
    for surface, body, first in zip(simulation.surfaces, state.bodies, initial):
        now = placed(surface.vertices, body)
        vertices.append(now)
        triangles.append(surface.triangles + count)
        moved.append(now[:, 2] - placed(surface.vertices, first)[:, 2])
        count += len(now)
    body = np.concatenate(moved)
    return {
        "position": points.position, "half": points.half_width, "soil": soil,
        "vertices": np.concatenate(vertices), "triangles": np.concatenate(triangles), "body": body,
        "limit": colour_limit(soil, body, simulation.model.soil.grid.smallest_cell),
    }


def colour_limit(soil, body, cell):
    """Round number for the ends of the colour scale: nearly all of the soil and half the body lie within; a hundredth of a
    `cell` [m] where nothing moves."""
    typical = [np.quantile(np.abs(soil), 0.999)] if len(soil) else []
    typical += [np.median(np.abs(body))] if len(body) else []
    largest = max(typical, default=0.0)
    if largest < NOTHING * cell:
        largest = 0.01 * cell
    power = 10.0 ** math.floor(math.log10(largest))
    return next(m * power for m in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if m * power >= 0.999 * largest)


class Drawing:
    """A picture that a child process draws from `scene_arrays`; `collect` ends it."""

    def __init__(self, path, arrays, caption):
        self._path, self._caption, self._error = Path(path), caption, None
        self._folder = self._child = None
        try:
            self._folder = tempfile.TemporaryDirectory(prefix="hybrid-picture-")
            np.savez(os.path.join(self._folder.name, "given.npz"), **arrays)
            self._begin(TRIES[0])
        except OSError as error:
            self._error = error

    def collect(self, limit=TIME_LIMIT):
        """Wait for the picture, for at most `limit` seconds from now; returns whether there is one. If not, a warning has
        cause and remedy."""
        try:
            if self._error:
                raise self._error
            self._deadline = min(self._deadline, time.monotonic() + limit)
            self._wait()
        except (OSError, RuntimeError, subprocess.TimeoutExpired) as error:
            log.warning("no picture %s: %s; %s", self._path.name, error, REMEDY)
            return False
        finally:
            if self._child and self._child.poll() is None:
                self._child.kill()
                self._child.wait()
            if self._folder:
                self._folder.cleanup()
        return True

    def _begin(self, choice):
        package = str(Path(__file__).resolve().parents[2])
        environment = dict(os.environ, OMP_NUM_THREADS="1", MPLBACKEND="Agg", **choice)
        environment["PYTHONPATH"] = os.pathsep.join(filter(None, [package, environment.get("PYTHONPATH")]))
        folder = self._folder.name
        command = [sys.executable, "-m", "hybrid.output.picture_worker", os.path.join(folder, "given.npz"),
                   os.path.join(folder, "drawn.png"), self._caption]
        # A session of its own, so that an interrupt from the keyboard does not end the child. Messages go to a file, as
        # a pipe is not read while the run continues.
        with open(os.path.join(folder, "messages"), "wb") as messages:
            self._child = subprocess.Popen(command, env=environment, start_new_session=True, stderr=messages,
                                           stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        self._deadline = time.monotonic() + TIME_LIMIT

    def _wait(self):
        """Move the picture to its path; RuntimeError with the child's last message if all tries failed."""
        picture = Path(self._folder.name) / "drawn.png"
        for choice in (*TRIES[1:], None):
            code = self._child.wait(max(0.0, self._deadline - time.monotonic()))
            if code == 0 and picture.exists():
                with atomic(self._path) as partial:
                    shutil.copyfile(picture, partial)
                return
            if choice is not None:
                self._begin(choice)
        messages = (Path(self._folder.name) / "messages").read_text(errors="replace")
        plain = re.sub(r"\x1b\[[0-9;]*m", "", messages)
        # The part of each line after VTK's stamp of date and place.
        words = [line.split("|")[-1].strip() for line in plain.splitlines() if line.strip()]
        raise RuntimeError(words[-1] if words else f"the drawing process ended with code {code}")
