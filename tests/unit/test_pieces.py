"""Frames of the soil in pieces, as one process sees them."""

from dataclasses import replace
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from fake_run import FakeSimulation

from hybrid.output import pieces, vtk
from hybrid.output.record import drawn, numbers_drawn
from hybrid.runtime import ranks
from hybrid.runtime.errors import SceneError
from hybrid.soil.split_merge import select
from hybrid.state import PointConstants, Population

pyvista = pytest.importorskip("pyvista")


def with_numbers(points, initial, number):
    mesh = vtk.soil_mesh(points, initial)
    mesh.point_data["number"] = number
    return mesh


def test_pieces_open_as_one_also_where_one_is_empty(tmp_path):
    simulation = FakeSimulation()
    points, n = simulation.state.points, len(simulation.state.points)
    whole = with_numbers(points, simulation.initial_position, np.arange(n))
    empty = meshio.Mesh(np.zeros((0, 3)), [("vertex", np.zeros((0, 1), np.int64))],
                        point_data={name: values[:0] for name, values in whole.point_data.items()})
    names = [pieces.piece(4, rank) for rank in range(2)]
    for name, mesh in zip(names, (whole, empty)):
        vtk.write_vtu(tmp_path / name, mesh)
    pieces.write_pvtu(tmp_path / "soil_000004.pvtu", whole, names)
    found = pyvista.read(tmp_path / "soil_000004.pvtu")
    assert found.n_points == n and set(found.point_data) == set(whole.point_data)
    np.testing.assert_array_equal(found.points, points.position)
    np.testing.assert_array_equal(found["stress"], whole.point_data["stress"])


def test_frames_after_the_step_of_a_resumed_run_go_with_their_pieces(tmp_path):
    simulation = FakeSimulation()
    mesh = vtk.soil_mesh(simulation.state.points, simulation.initial_position)
    series = pieces.Frameset(tmp_path, 0, 2)
    for step in (0, 2, 4):
        for rank in range(3):
            vtk.write_vtu(tmp_path / pieces.piece(step, rank), mesh)
        series.add(step, 0.1 * step, mesh)
    vtk.write_vtu(tmp_path / pieces.piece(6, 1), mesh)       # of a frame that was never complete
    again = vtk.Series(tmp_path, "soil", 2, 2)               # by one process
    again.add(3, 0.3, mesh)
    assert vtk.read_pvd(tmp_path / "soil.pvd") == [("soil_000000.pvtu", 0.0), ("soil_000002.pvtu", 0.2),
                                                   ("soil_000003.vtu", 0.3)]
    left = {path.name for path in tmp_path.glob("soil_0*")}
    assert left == {"soil_000003.vtu"} | {f"soil_00000{step}{end}" for step in (0, 2)
                                          for end in (".pvtu", "_r0.vtu", "_r1.vtu", "_r2.vtu")}


def test_what_one_process_does_together_with_itself():
    assert ranks.together(lambda: 3) == 3 and ranks.all_here()

    def fails(error):
        raise error

    for error in (SceneError("cells"), OSError(28, "No space left on device", "soil.vtu")):
        with pytest.raises(type(error)) as found:
            ranks.together(lambda error=error: fails(error))
        assert found.value is error


@pytest.mark.parametrize("lost", ["inside", "outside", "both"])
def test_numbers_are_those_of_the_points_drawn_also_where_only_some_have_left(lost):
    """Points outside the window of a moving grid, of which those on one side only may have become inactive."""
    simulation = FakeSimulation()
    points, n = simulation.state.points, len(simulation.state.points)
    constants = PointConstants(*np.zeros((2, n, 3)), *np.zeros((2, n)), number=np.arange(n))
    outside = select(Population(points, constants, np.zeros((n, 2))), np.arange(5))
    outside = replace(outside, constants=replace(outside.constants, number=np.arange(n, n + 5)))
    gone = np.arange(n) < 2
    if lost != "inside":
        outside = replace(outside, points=replace(outside.points, inactive=gone[:5]))
    if lost != "outside":
        points = replace(points, inactive=gone)
    ground = SimpleNamespace(constants=constants, rows=np.zeros((n, 2)), behind=outside)
    simulation.state = replace(simulation.state, points=points, ground=ground)
    simulation.model = SimpleNamespace(bodies=(), soil=SimpleNamespace(constants=constants))
    simulation.scene = SimpleNamespace(soil=SimpleNamespace(stray="remove"))
    number = numbers_drawn(simulation)
    assert len(number) == len(drawn(simulation)[0]) == n + 5 - 2 * (1 + (lost == "both"))
    assert (0 in number, n in number) == (lost == "outside", lost == "inside")
