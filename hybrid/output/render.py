"""Three-dimensional pictures of soil and bodies, coloured by vertical displacement since the run began.

The soil is drawn as the domains of its points (boxes x_p ± l_p), seen obliquely from the side of small y,
where a half model has its symmetry plane, so that the cut through soil and body faces the viewer.

VTK ends the whole process when it finds no OpenGL. A picture is therefore drawn by a child process (this file run as
a module), and a run only loses its picture, with a warning that says why. The run goes on while the child works; one
child works at a time.
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

from hybrid.output import atomic
from hybrid.output.history import NAME as HISTORY
from hybrid.output.history import body_names, read_history
from hybrid.output.record import drawn, initial_bodies, placed

log = logging.getLogger("hybrid")

LABEL = "vertical displacement [m]"
WINDOW = (2100, 1400)  # pixels, before cropping
VIEW = np.array([-0.3, -1.0, 0.42])  # from the focal point to the camera
TIME_LIMIT = 300.0  # seconds for one picture
# EGL needs no X server; where it is missing VTK may choose for itself.
TRIES = {"VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}, {}
REMEDY = "try: apt install libegl1 libgl1-mesa-dri (off-screen OpenGL), pip install pyvista"


class Pictures:
    """Observer that writes soil_step_005.png, ... at the steps `scene.output.pictures`, counted from the
    start of the last stage, and trajectory.png and line_tension.png at the end."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def start(self, simulation):
        self.before = sum(stage.steps for stage in simulation.scene.stages[:-1])
        self.initial = initial_bodies(simulation)
        self.drawing = None

    def accepted(self, record, simulation):
        step = record.step - self.before
        if step in simulation.scene.output.pictures:
            self._collect()
            caption = f"{record.stage}: step {step}, time {record.time:.2f} s"
            path = self.folder / f"soil_step_{step:03d}.png"
            self.drawing = Drawing(path, scene_arrays(simulation, self.initial), caption)

    def finish(self, summary, simulation):
        try:
            self._figures(simulation)
        finally:
            self._collect()

    def _figures(self, simulation):
        history = read_history(self.folder) if (self.folder / HISTORY).exists() else {}
        if not simulation.body_names or not len(history.get("step", ())):
            return
        from hybrid.output import figures  # late: matplotlib takes a while, and most of a run does without

        figures.trajectory(self.folder)
        if any(np.any(history[f"{name}_tension_N"]) for name in body_names(history)):
            figures.tension(self.folder)

    def _collect(self):
        if self.drawing:
            self.drawing.collect()
        self.drawing = None


def render(path, simulation, caption="", initial=None):
    """Write a picture of the simulation's present state to `path` (PNG). Returns whether that worked.

    initial: list of BodyState at the start of the run, default `simulation.initial_bodies`. When nothing can
    be drawn a warning names cause and remedy and the run goes on.
    """
    return Drawing(path, scene_arrays(simulation, initial or initial_bodies(simulation)), caption).collect()


def scene_arrays(simulation, initial):
    """What the child draws: box centres and half-widths (n, 3) [m], body vertices (V, 3) [m] and triangles
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
        "position": points.position, "half": points.half, "soil": soil,
        "vertices": np.concatenate(vertices), "triangles": np.concatenate(triangles), "body": body,
        "limit": colour_limit(soil, body),
    }


def colour_limit(soil, body):
    """Round number for the ends of the colour scale: nearly all of the soil and half the body lie within."""
    typical = [np.quantile(np.abs(soil), 0.999)] if len(soil) else []
    typical += [np.median(np.abs(body))] if len(body) else []
    largest = max(typical, default=0.0)
    if largest < 1e-9:
        return 1e-3
    power = 10.0 ** math.floor(math.log10(largest))
    return next(m * power for m in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if m * power >= 0.999 * largest)


class Drawing:
    """A picture that a child process draws from `scene_arrays`; to be ended by `collect`."""

    def __init__(self, path, arrays, caption=""):
        self._path, self._caption, self._error = Path(path), caption, None
        self._folder = self._child = None
        try:
            self._folder = tempfile.TemporaryDirectory(prefix="hybrid-picture-")
            np.savez(os.path.join(self._folder.name, "given.npz"), **arrays)
            self._begin(TRIES[0])
        except OSError as error:
            self._error = error

    def collect(self):
        """Wait for the picture; returns whether there is one. Otherwise a warning names cause and remedy."""
        try:
            if self._error:
                raise self._error
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
        command = [sys.executable, "-m", "hybrid.output.render", os.path.join(folder, "given.npz"),
                   os.path.join(folder, "drawn.png"), self._caption]
        # A session of its own: who interrupts the run from the keyboard still gets the picture. What the child says
        # goes to a file, since nobody reads a pipe while the run goes on.
        with open(os.path.join(folder, "said"), "wb") as said:
            self._child = subprocess.Popen(command, env=environment, start_new_session=True, stderr=said,
                                           stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        self._deadline = time.monotonic() + TIME_LIMIT

    def _wait(self):
        """Put the picture in its place; RuntimeError with the child's last words when every try failed."""
        picture = Path(self._folder.name) / "drawn.png"
        for choice in (*TRIES[1:], None):
            code = self._child.wait(max(0.0, self._deadline - time.monotonic()))
            if code == 0 and picture.exists():
                with atomic(self._path) as partial:
                    shutil.copyfile(picture, partial)
                return
            if choice is not None:
                self._begin(choice)
        said = (Path(self._folder.name) / "said").read_text(errors="replace")
        plain = re.sub(r"\x1b\[[0-9;]*m", "", said)
        # What follows VTK's stamp of date and place.
        words = [line.split("|")[-1].strip() for line in plain.splitlines() if line.strip()]
        raise RuntimeError(words[-1] if words else f"the drawing process ended with code {code}")


# ---- below: in the child process ----


def main(given, drawn, caption=""):
    from hybrid.output import figures

    with np.load(given) as file:
        arrays = dict(file)
    image, ends, length = draw(arrays, figures.DIVERGING)
    limit, values = float(arrays["limit"]), np.concatenate([arrays["soil"], arrays["body"]])
    below, above = np.any(values < -limit), np.any(values > limit)
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[int(below), int(above)]
    figures.picture(drawn, image, limit, LABEL, caption, extend, (*ends, f"{length:g} m"))


def draw(arrays, colours):
    """Image (rows, columns, 4: RGB and opacity), ruler ends (4,) in its pixels, ruler's length [m]."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=WINDOW, lighting="none")
    plotter.set_background("white")
    limit = float(arrays["limit"])
    shown = {"scalars": "uz", "cmap": colours, "clim": (-limit, limit), "show_scalar_bar": False}
    if len(arrays["position"]):
        soil = visible_faces(pyvista, arrays["position"], arrays["half"], arrays["soil"])
        plotter.add_mesh(soil, ambient=0.35, diffuse=0.65, specular=0.0, **shown)
    if len(arrays["vertices"]):
        add_body(pyvista, plotter, arrays, shown)
    light(pyvista, plotter)
    lower, upper = bounds(arrays)
    aim_camera(plotter, lower, upper)
    plotter.enable_anti_aliasing("ssaa")
    image = plotter.screenshot(None, return_img=True, transparent_background=True)
    length = ruler_length(upper[0] - lower[0])
    start = np.array([lower[0], lower[1], lower[2] - 0.02 * np.linalg.norm(upper - lower)])
    ends = np.concatenate([pixel(plotter, start), pixel(plotter, start + [length, 0, 0])])
    plotter.close()
    image, corner = cropped(image, ends)
    return image, ends - np.tile(corner, 2), length


def visible_faces(pyvista, centre, half, values):
    """The three faces of every box that look at the camera, with cell data "uz"; the rest is never seen."""
    faces = []
    for axis in range(3):
        side = math.copysign(1.0, VIEW[axis])
        u, v = (axis + 1) % 3, (axis + 2) % 3
        corners = np.empty((len(centre), 4, 3))
        corners[:, :, axis] = (centre[:, axis] + side * half[:, axis])[:, None]
        for i, (a, b) in enumerate(((-1, -1), (side, -side), (1, 1), (-side, side))):
            corners[:, i, u] = centre[:, u] + a * half[:, u]
            corners[:, i, v] = centre[:, v] + b * half[:, v]
        faces.append(corners)
    quads = np.concatenate(faces)
    numbers = np.arange(4 * len(quads)).reshape(-1, 4)
    mesh = pyvista.PolyData(quads.reshape(-1, 3), np.column_stack([np.full(len(quads), 4), numbers]).ravel())
    mesh.cell_data["uz"] = np.tile(values, 3)
    return mesh


def add_body(pyvista, plotter, arrays, shown):
    """Bodies with their sharp edges and silhouette; an open surface (half model) gets its cut face back."""
    triangles = np.column_stack([np.full(len(arrays["triangles"]), 3), arrays["triangles"]])
    surface = pyvista.PolyData(arrays["vertices"], triangles.ravel())
    surface.point_data["uz"] = arrays["body"]
    size = surface.length
    rim = surface.extract_feature_edges(
        boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False
    )
    finish = {"ambient": 0.35, "diffuse": 0.65, "specular": 0.0}  # a highlight would be read as displacement
    smooth = {"smooth_shading": True, "split_sharp_edges": True, "feature_angle": 30}
    plotter.add_mesh(surface, **smooth, **finish, **shown)
    if rim.n_cells:
        cap = rim.strip().triangulate_contours()
        # In front of the soil's own cut face, where both lie in the symmetry plane.
        cap.points += 2e-3 * size * VIEW / np.linalg.norm(VIEW)
        plotter.add_mesh(cap, lighting=False, **shown)
        rim.points += 3e-3 * size * VIEW / np.linalg.norm(VIEW)
        plotter.add_mesh(rim, color="black", line_width=7, lighting=False)
    edges = surface.extract_feature_edges(
        feature_angle=30, boundary_edges=False, manifold_edges=False, non_manifold_edges=False
    )
    if edges.n_cells:
        plotter.add_mesh(edges, color="#202020", line_width=4, lighting=False)
    plotter.add_silhouette(surface, color="black", line_width=5)


def light(pyvista, plotter):
    """Three far lights, one along each axis: white stays white on the cut face, and sides differ."""
    for position, strength in (((0, -1, 0), 1.0), ((0, 0, 1), 0.86), ((-1, 0, 0), 0.6)):
        plotter.add_light(pyvista.Light(position=position, focal_point=(0, 0, 0), intensity=strength))


def bounds(arrays):
    """Lower and upper corner (3,) [m] of everything drawn."""
    corners = [arrays["position"] - arrays["half"], arrays["position"] + arrays["half"], arrays["vertices"]]
    corners = np.concatenate([c for c in corners if len(c)])
    return corners.min(axis=0), corners.max(axis=0)


def aim_camera(plotter, lower, upper):
    """Parallel projection along VIEW that just holds the box [lower, upper]."""
    centre = (lower + upper) / 2
    away = VIEW / np.linalg.norm(VIEW)
    right = np.cross([0, 0, 1.0], away) / np.linalg.norm(np.cross([0, 0, 1.0], away))
    top = np.cross(away, right)
    reach = [np.abs(axis) @ (upper - lower) / 2 for axis in (right, top)]
    distance = 5 * np.linalg.norm(upper - lower)
    plotter.camera_position = [centre + distance * away, centre, (0, 0, 1)]
    plotter.camera.enable_parallel_projection()
    plotter.camera.parallel_scale = 1.06 * max(reach[1], reach[0] * WINDOW[1] / WINDOW[0])
    plotter.renderer.ResetCameraClippingRange()


def ruler_length(extent):
    """Round length [m] of about a sixth of the model's extent."""
    power = 10.0 ** math.floor(math.log10(extent / 6))
    return max(m * power for m in (1, 2, 5) if m * power <= extent / 6)


def pixel(plotter, point):
    """Column and row (2,) of the image at which a point (3,) [m] is seen."""
    renderer = plotter.renderer
    renderer.SetWorldPoint(*point, 1.0)
    renderer.WorldToDisplay()
    column, row, _ = renderer.GetDisplayPoint()
    return np.array([column, plotter.window_size[1] - row])


def cropped(image, ends, margin=24):
    """The image without its white border, and the pixel (column, row) of the new upper left corner."""
    inked = np.argwhere(image[:, :, 3] > 0)
    columns = np.concatenate([inked[:, 1], ends[0::2].astype(int)])
    rows = np.concatenate([inked[:, 0], ends[1::2].astype(int) + 2 * margin])
    left, top = max(0, columns.min() - margin), max(0, rows.min() - margin)
    right, bottom = min(image.shape[1], columns.max() + margin), min(image.shape[0], rows.max() + margin)
    return image[top:bottom, left:right], np.array([left, top])


if __name__ == "__main__":
    main(*sys.argv[1:])
