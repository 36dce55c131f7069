"""VTK XML series of soil and bodies: frames in binary .vtu files, listed with their times in .pvd files.

| file                  | point data                                                            |
|-----------------------|-----------------------------------------------------------------------|
| soil_000005.vtu       | displacement, half_widths [m], velocity [m/s], stress, mean_stress,   |
|                       | deviatoric_stress [Pa], plastic_strain [-]                            |
| body_NAME_000005.vtu  | displacement [m], velocity [m/s], contact_force [N]                   |

In a run by several processes the soil is in pieces: `hybrid.output.pieces`.

Displacements count from the start of the run. Stress is Cauchy, positive in tension, in VTK's order
xx yy zz xy yz xz; mean stress is tr σ/3 and deviatoric stress is q = sqrt(3/2 s:s). Coordinates are in double
precision, fields in single precision: they are for the eye, the checkpoint keeps every digit.
"""

import os
import re
import xml.etree.ElementTree as xml
from pathlib import Path
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np

from hybrid.output import atomic
from hybrid.output.history import read_history
from hybrid.output.record import drawn, placed
from hybrid.scene.check import file_label

SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  # VTK's order of a symmetric tensor
GROUPS = {"body": 0, "contact": 1, "symmetry": 2}
PVD_BEGIN = """<?xml version='1.0' encoding='utf-8'?>
<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">
  <Collection>
"""
PVD_END = "  </Collection>\n</VTKFile>"


class Frames:
    """Observer that writes a frame at the start, every `scene.output.every` outer steps and at the end, unless the run is
    interrupted: resumed, it then has the frames of a run in one go.

    Held soil does not move, so its points are written once. `every = 0` writes nothing. Of several processes each writes its
    own part of the soil (`hybrid.output.pieces`); soil: whether the soil is written here.
    """

    def __init__(self, folder, soil=True):
        self.folder, self._with_soil = Path(folder), soil

    def start(self, simulation):
        if not simulation.scene.output.every:
            return
        self.first = step = simulation.state.step
        self.initial = simulation.initial_bodies
        names = [f"body_{file_label(name)}" for name in simulation.body_names]
        self.soil, *self.bodies = [name and Series(self.folder, name, step, simulation.scene.output.every)
                                   for name in (self._with_soil and "soil", *names)]
        if not step:
            self._write(simulation)

    def accepted(self, record, simulation):
        if frame_due(simulation):
            self._write(simulation)

    def finish(self, summary, simulation):
        if simulation.scene.output.every and summary["outcome"] != "interrupted" and simulation.state.step > self.first:
            self._write(simulation)

    def _write(self, simulation):
        state, soil = simulation.state, simulation.scene.soil
        if self._with_soil and len(state.points) and not (soil.held and self.soil.frames):
            self.soil.add(state.step, state.time, soil_mesh(*drawn(simulation)))
        for b, series in enumerate(self.bodies):
            surface, forces = simulation.surfaces[b], simulation.contact_forces(b)
            series.add(state.step, state.time, body_mesh(surface, state.bodies[b], self.initial[b], forces))


def frame_due(simulation):
    """Whether there is to be a frame of the present step."""
    every, step = simulation.scene.output.every, simulation.state.step
    return every > 0 and (step % every == 0 or step == simulation.total_steps)


def with_forces_if_drawn(simulation, call):
    """What Frames see of one of several processes: forces of all of them where a frame is due."""
    last = call == "finish" and simulation.scene.output.every
    return simulation.with_all_forces() if last or frame_due(simulation) else simulation


class Series:
    """Frames NAME_000000.vtu, ... of a folder, or NAME_000000.pvtu with their pieces, and the NAME.pvd that lists them,
    rewritten after each frame.

    Opened at step 0 the frames of an earlier run are deleted. Opened later those after `step` are deleted, and one at
    `step` itself that is not due every so many steps, where the run had ended; the rest are kept. Their times are those
    of the .pvd, or of history.csv where the .pvd is damaged.
    """

    ending = ".vtu"     # of new frames

    def __init__(self, folder, name, step=0, every=1):
        self.folder, self.name = Path(folder), name
        self.frames, self.files = {}, {}    # step -> time [s]; step -> name of the file
        self.lines = []     # of the .pvd, one for each of them
        matches = [re.fullmatch(re.escape(name) + r"_(\d{6,})(_r\d+)?\.p?vtu", path.name)
                   for path in self.folder.glob("*.*vtu")]
        found = [(int(match[1]), match[2], match[0]) for match in matches if match]
        times = self._times() if step and found else {}
        for number, part, file in found:
            if number not in times or number > step or number == step and step % every:
                (self.folder / file).unlink(missing_ok=True)
            elif not part:
                self.frames[number], self.files[number] = float(times[number]), file
        self.lines = [_listed(time, self.files[number]) for number, time in sorted(self.frames.items())]
        if found:
            self._write_pvd()

    def _times(self):
        """{step: time [s]} of the start, of history.csv and of the .pvd."""
        try:
            history = read_history(self.folder)
        except FileNotFoundError:
            history = {}
        times = {0: 0.0, **dict(zip(history.get("step", ()), history.get("time_s", ())))}
        try:
            listed = read_pvd(self.folder / f"{self.name}.pvd")
        except xml.ParseError:
            listed = []
        return times | {int(re.search(r"(\d+)\.p?vtu", file)[1]): time for file, time in listed}

    def add(self, step, time, mesh):
        """Write one frame and list it; a step that is already listed is not written again."""
        if step in self.frames:
            return
        file = f"{self.name}_{step:06d}{self.ending}"
        self.write(self.folder / file, mesh)
        self.frames[step], self.files[step] = float(time), file
        self.lines.append(_listed(float(time), file))
        self._write_pvd()

    def write(self, path, mesh):
        """Write the file of a frame."""
        write_vtu(path, mesh)

    def _write_pvd(self):
        text = "".join([PVD_BEGIN, *self.lines, PVD_END])
        with atomic(self.folder / f"{self.name}.pvd") as partial:
            partial.write_text(text, encoding="utf-8")


def _listed(time, file):
    """Line of a .pvd with a frame."""
    return f'    <DataSet timestep="{time!r}" group="" part="0" file={quoteattr(file)} />\n'


def read_pvd(path):
    """(file, time) of every frame that a .pvd lists; empty when there is none."""
    if not Path(path).exists():
        return []
    frames = xml.parse(path).getroot().iter("DataSet")
    return [(os.path.basename(frame.get("file")), float(frame.get("timestep"))) for frame in frames]


def soil_mesh(points, initial_position):
    """Material points as VTK vertices with the fields of the module's table. initial_position: (n, 3) [m]."""
    stress = points.stress
    mean = np.trace(stress, axis1=1, axis2=2) / 3
    deviator = stress - mean[:, None, None] * np.eye(3)
    fields = {
        "displacement": points.position - initial_position,
        "velocity": points.velocity,
        "stress": np.stack([stress[:, i, j] for i, j in SYMMETRIC], axis=1),
        "mean_stress": mean,
        "deviatoric_stress": np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2))),
        "plastic_strain": points.plastic_strain,
        "half_widths": points.half_width,
    }
    vertices = np.arange(len(points))[:, None]
    return meshio.Mesh(points.position, [("vertex", vertices)], point_data=_single(fields))


def body_mesh(surface, body, initial, forces):
    """Contact surface at the pose of `body`. initial: BodyState at the start; forces: (V, 3) on the body [N].

    Velocity of a vertex at r from the centre of mass, in the spatial frame: ċ + R (W × r).
    """
    vertices = surface.vertices
    now = placed(vertices, body)
    fields = {
        "displacement": now - placed(vertices, initial),
        "velocity": body.velocity + np.cross(body.spin, vertices) @ body.rotation.T,
        "contact_force": forces,
    }
    return meshio.Mesh(now, [("triangle", surface.triangles)], point_data=_single(fields))


def write_mesh(path, mesh):
    """Write a TetMesh in its geometry's coordinates; cell data "group": 0 body, 1 contact, 2 symmetry."""
    blocks = [("tetra", mesh.tets, "body"), ("triangle", mesh.contact, "contact")]
    blocks.append(("triangle", mesh.symmetry, "symmetry"))
    blocks = [block for block in blocks if len(block[1])]
    group = [np.full(len(cells), GROUPS[name], dtype=np.int32) for _, cells, name in blocks]
    cells = [(kind, cells) for kind, cells, _ in blocks]
    write_vtu(path, meshio.Mesh(mesh.points, cells, cell_data={"group": group}))


def write_vtu(path, mesh):
    """Write a meshio mesh as binary VTK XML; not compressed, which is nine times faster."""
    with atomic(path) as partial:
        meshio.write(partial, mesh, file_format="vtu", binary=True, compression=None)


def _single(fields):
    return {name: np.ascontiguousarray(values, dtype=np.float32) for name, values in fields.items()}
