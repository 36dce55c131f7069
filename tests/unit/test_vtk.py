"""VTK series: readable by others, true to the state, listed only when complete."""

from dataclasses import replace
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from fake_run import DT, FakeScene, FakeSimulation, Output, Soil, turn

from hybrid.output import vtk
from hybrid.output.history import History
from hybrid.output.record import placed


def test_soil_frame_holds_the_state(tmp_path):
    simulation = FakeSimulation()
    simulation.run([vtk.Frames(tmp_path)], until=4)
    points = simulation.state.points
    mesh = meshio.read(tmp_path / "soil_000004.vtu")
    np.testing.assert_array_equal(mesh.points, points.position)
    data = mesh.point_data
    near = dict(rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(data["displacement"], points.position - simulation.initial_position, **near)
    np.testing.assert_allclose(data["half_widths"], points.half_width, **near)
    np.testing.assert_allclose(data["stress"][:, 3], points.stress[:, 0, 1], **near)
    xx, yy, zz, xy, yz, xz = data["stress"].astype(float).T
    mises = np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3 * (xy**2 + yz**2 + xz**2))
    np.testing.assert_allclose(data["deviatoric_stress"], mises, rtol=1e-5)
    np.testing.assert_allclose(data["mean_stress"], (xx + yy + zz) / 3, rtol=1e-4, atol=1e-3)


def test_body_frame_moves_with_the_body(tmp_path):
    simulation = FakeSimulation()
    simulation.run([vtk.Frames(tmp_path)], until=4)
    body, vertices = simulation.state.bodies[0], simulation.surfaces[0].vertices
    mesh = meshio.read(tmp_path / "body_anchor_000004.vtu")
    np.testing.assert_allclose(mesh.points, body.position + (body.rotation @ vertices.T).T, atol=1e-14)
    np.testing.assert_allclose(mesh.point_data["contact_force"], simulation.contact_forces(0))
    # The velocity field is the time derivative of the placed vertices.
    later = replace(body, position=body.position + 1e-6 * body.velocity, rotation=turn(0.08 + 0.5e-6))
    rate = (placed(vertices, later) - placed(vertices, body)) / 1e-6
    np.testing.assert_allclose(mesh.point_data["velocity"], rate, atol=1e-6)


def test_pvd_lists_only_complete_frames_at_every_moment(tmp_path):
    simulation, observer = FakeSimulation(), vtk.Frames(tmp_path)
    observer.start(simulation)
    for step in range(1, 6):
        simulation.state = simulation.state_at(step)
        observer.accepted(simulation.record(), simulation)
        for name in ("soil", "body_anchor"):
            frames = vtk.read_pvd(tmp_path / f"{name}.pvd")
            assert [time for _, time in frames] == [k * DT for k in range(0, step + 1, 2)]
            assert all((tmp_path / file).exists() for file, _ in frames)
    observer.finish({"outcome": "failed"}, simulation)
    assert vtk.read_pvd(tmp_path / "soil.pvd")[-1] == ("soil_000005.vtu", 5 * DT)


def test_frames_resume_and_start_afresh(tmp_path):
    FakeSimulation().run([vtk.Frames(tmp_path)])
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(3)
    resumed.run([vtk.Frames(tmp_path)], until=5)
    assert [file[9:11] for file, _ in vtk.read_pvd(tmp_path / "soil.pvd")] == ["00", "02", "04", "05"]
    assert not (tmp_path / "soil_000006.vtu").exists()
    FakeSimulation().run([vtk.Frames(tmp_path)], until=2)
    assert sorted(path.name for path in tmp_path.glob("soil_*.vtu")) == ["soil_000000.vtu", "soil_000002.vtu"]


def frames(folder):
    return [int(file[5:11]) for file, _ in vtk.read_pvd(folder / "soil.pvd")]


def test_an_interrupted_run_has_the_frames_of_a_run_in_one_go(tmp_path):
    FakeSimulation().run([vtk.Frames(tmp_path)], until=3, outcome="interrupted")
    assert frames(tmp_path) == [0, 2]
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(3)
    resumed.run([vtk.Frames(tmp_path)])
    assert frames(tmp_path) == [0, 2, 4, 6]


def test_a_frame_at_which_a_run_failed_goes_when_it_is_resumed(tmp_path):
    FakeSimulation().run([vtk.Frames(tmp_path)], until=3, outcome="failed")
    assert frames(tmp_path) == [0, 2, 3]
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(3)
    resumed.run([vtk.Frames(tmp_path)])
    assert frames(tmp_path) == [0, 2, 4, 6] and not (tmp_path / "soil_000003.vtu").exists()


@pytest.mark.parametrize("damage", ["cut", "gone", "one frame not listed"])
def test_a_damaged_pvd_is_made_again_from_the_history(tmp_path, damage):
    FakeSimulation().run([History(tmp_path), vtk.Frames(tmp_path)], until=4)
    whole = (tmp_path / "soil.pvd").read_text()
    if damage == "gone":
        (tmp_path / "soil.pvd").unlink()
    else:
        (tmp_path / "soil.pvd").write_text(
            whole[:150] if damage == "cut" else "".join(line for line in whole.splitlines(True) if "000004" not in line))
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(4)
    history, observer = History(tmp_path), vtk.Frames(tmp_path)
    history.start(resumed)
    observer.start(resumed)
    assert (tmp_path / "soil.pvd").read_text() == whole


def test_held_soil_is_written_once_and_every_zero_writes_nothing(tmp_path):
    FakeSimulation(FakeScene(soil=Soil(held=True))).run([vtk.Frames(tmp_path / "held")])
    assert len(list((tmp_path / "held").glob("soil_*.vtu"))) == 1
    assert len(list((tmp_path / "held").glob("body_*.vtu"))) == 4
    FakeSimulation(FakeScene(output=Output(every=0))).run([vtk.Frames(tmp_path / "none")])
    assert not (tmp_path / "none").exists()


def test_vtk_itself_reads_the_files(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    simulation = FakeSimulation()
    simulation.run([vtk.Frames(tmp_path)], until=2)
    soil = pyvista.read(tmp_path / "soil.pvd")[0]
    assert soil.n_points == len(simulation.initial_position) and soil["stress"].shape[1] == 6


def test_tetrahedra_are_written_with_their_groups(tmp_path):
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [1, 2, 3], [0, 3, 2]])
    tets, cut = np.array([[0, 1, 2, 3]]), np.array([[0, 1, 3]])
    mesh = SimpleNamespace(points=corners, tets=tets, contact=faces, symmetry=cut)
    vtk.write_mesh(tmp_path / "mesh.vtu", mesh)
    read = meshio.read(tmp_path / "mesh.vtu")
    assert np.concatenate(read.cell_data["group"]).tolist() == [0, 1, 1, 1, 2]
