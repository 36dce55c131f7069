"""Frames of the soil in pieces: each process of several writes its own points, the first one the file that joins them.

| file                | has                                                                                 |
|---------------------|-------------------------------------------------------------------------------------|
| soil_000005_r2.vtu  | the points of process 2, fields as in `hybrid.output.vtk` and their number in the run |
| soil_000005.pvtu    | the names of the pieces and of their fields: what ParaView opens                    |
| soil.pvd            | all frames with their times, of runs by one process and by several                  |

A frame is listed when all of its pieces are on disk.
"""

import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np

from hybrid.output import atomic
from hybrid.output.record import drawn, numbers_drawn
from hybrid.output.vtk import Series, frame_due, soil_mesh, write_vtu
from hybrid.runtime import ranks

VTK_TYPES = {"float64": "Float64", "float32": "Float32", "int64": "Int64"}


class Pieces:
    """Observer in every process of several, with the points of its own; writes frames when `hybrid.output.vtk.Frames`
    does."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def start(self, simulation):
        self.every, self.first = simulation.scene.output.every, simulation.state.step
        if self.every:
            self.series = ranks.together(lambda: None if ranks.rank() else Frameset(self.folder, self.first, self.every))
            if not self.first:
                self._write(simulation)

    def accepted(self, record, simulation):
        if frame_due(simulation):
            self._write(simulation)

    def finish(self, summary, simulation):
        if self.every and summary["outcome"] != "interrupted" and simulation.state.step > self.first:
            self._write(simulation)

    def _write(self, simulation):
        state = simulation.state
        if simulation.scene.soil.held and state.step:
            return      # it has not moved
        points, initial = drawn(simulation)
        mesh = soil_mesh(points, initial)
        mesh.point_data["number"] = numbers_drawn(simulation)
        ranks.together(lambda: write_vtu(self.folder / piece(state.step, ranks.rank()), mesh))
        ranks.together(lambda: self.series and self.series.add(state.step, state.time, mesh))


class Frameset(Series):
    """Series of the soil whose new frames are .pvtu files; opened and written by the first process."""

    ending = ".pvtu"

    def __init__(self, folder, step, every):
        super().__init__(folder, "soil", step, every)

    def write(self, path, mesh):
        write_pvtu(path, mesh, [piece(int(path.stem.split("_")[1]), rank) for rank in range(ranks.started())])


def piece(step, rank):
    """Name of the file of a process at a step."""
    return f"soil_{step:06d}_r{rank}.vtu"


def write_pvtu(path, mesh, pieces):
    """Write the .pvtu file that joins the files `pieces`, all with the fields of `mesh`."""
    root = xml.Element("VTKFile", type="PUnstructuredGrid", version="0.1", byte_order="LittleEndian")
    grid = xml.SubElement(root, "PUnstructuredGrid", GhostLevel="0")
    _array(xml.SubElement(grid, "PPoints"), "Points", mesh.points)
    fields = xml.SubElement(grid, "PPointData")
    for name, values in mesh.point_data.items():
        _array(fields, name, values)
    for name in pieces:
        xml.SubElement(grid, "Piece", Source=name)
    xml.indent(root)
    with atomic(path) as partial:
        xml.ElementTree(root).write(partial, encoding="utf-8", xml_declaration=True)


def _array(parent, name, values):
    xml.SubElement(parent, "PDataArray", type=VTK_TYPES[values.dtype.name], Name=name,
                   NumberOfComponents=str(int(np.prod(values.shape[1:]))))
