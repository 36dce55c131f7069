"""Files that a run leaves behind: complete, readable by others, true to the state, also when interrupted."""

import csv
import io
import json
import logging
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

from hybrid.output import atomic, checkpoint, figures, history, progress, render, summary, vtk
from hybrid.output.record import BodyRecord, Record, placed
from hybrid.state import BodyState, ContactHistory, Points, State

DT = 0.04


@dataclass(frozen=True)
class Stage:
    name: str
    steps: int


@dataclass(frozen=True)
class Output:
    every: int = 2
    pictures: tuple = (2,)
    checkpoint: int = 2


@dataclass(frozen=True)
class Soil:
    young: float = 2e7
    held: bool = False


@dataclass(frozen=True)
class FakeScene:
    name: str = "fake"
    soil: Soil = Soil()
    stages: tuple = (Stage("settle", 2), Stage("drag", 4))
    output: Output = Output()


def turn(angle):
    """Rotation by `angle` about y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def open_box(size):
    """Half box without its face in the symmetry plane y = 0: vertices (8, 3), outward triangles (10, 3)."""
    lower, upper = np.array([-0.5, 0, -0.5]) * size, np.array([0.5, 0.5, 0.5]) * size
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (2, 3, 7, 6), (0, 4, 5, 1)[::-1], (1, 5, 7, 3)]
    quads[3] = (0, 2, 6, 4)
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return SimpleNamespace(vertices=lower + corners * (upper - lower), triangles=np.array(triangles))


class FakeSimulation:
    """A lattice of points and a half box that is dragged through it along a path given in closed form."""

    def __init__(self, scene=FakeScene(), shape=(10, 4, 5), spacing=0.1):
        self.scene, self.total_steps = scene, sum(stage.steps for stage in scene.stages)
        lattice = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
        self.initial_position = (lattice + 0.5) * spacing - [0, 0, shape[2] * spacing]
        self.initial_half = np.full_like(self.initial_position, spacing / 2)
        self.surfaces, self.body_names = [open_box(np.array([0.3, 0.3, 0.2]))], ["anchor"]
        self.random = np.random.default_rng(1)
        self.state = self.state_at(0)
        self.initial_bodies = self.state.bodies

    def state_at(self, step):
        x, n = self.initial_position, len(self.initial_position)
        centre = np.array([0.3 + 0.02 * step, 0.0, -0.004 * step])
        rise = 0.01 * step * (x[:, 0] - centre[0]) * np.exp(-10 * np.sum((x - centre) ** 2, axis=1)) * 3
        stress = self.random.normal(size=(n, 3, 3))
        points = Points(
            position=x + rise[:, None] * [0, 0, 1], velocity=rise[:, None] * [0, 0, 1.0],
            acceleration=np.zeros((n, 3)), half=self.initial_half * 0.98,
            deformation=np.tile(np.eye(3), (n, 1, 1)),
            elastic=np.tile(np.eye(3), (n, 1, 1)), stress=1e3 * (stress + stress.transpose(0, 2, 1)),
            plastic_strain=np.abs(rise),
        )
        body = BodyState(
            position=centre, rotation=turn(0.02 * step),
            velocity=np.array([0.5, 0.0, -0.1]), acceleration=np.zeros(3),
            spin=np.array([0, 0.5, 0]), spin_rate=np.zeros(3), target=np.array([5.0, 0, 0]) if step else None,
        )
        id = np.arange(0, 8 * n, 5)
        place, anchor, side, probe = self.random.random((4, len(id), 3))
        pressure = self.random.random(len(id))
        contact = ContactHistory(id, place, pressure < 0.1, anchor, side, pressure, id[:7], probe[:7], pressure[:7])
        return State(step * DT, step, points, [body], [contact], {"pull": 1 / 3 * step})

    def contact_forces(self, b):
        return np.outer(np.arange(8), [1.0, 2.0, 3.0])

    def sheet(self):
        return {"points": np.int64(len(self.initial_position)), "unknowns": 1234}

    def run(self, observers, until=None, outcome="completed"):
        """Go on from the present state, as the time loop would; with `until`, stop there."""
        for observer in observers:
            observer.start(self)
        for step in range(self.state.step + 1, (until or self.total_steps) + 1):
            self.state = self.state_at(step)
            record = self.record()
            for observer in observers:
                observer.accepted(record, self)
        for observer in observers:
            observer.finish({"outcome": outcome, "reason": ""}, self)

    def record(self):
        step, body = self.state.step, self.state.bodies[0]
        stage = 0 if step <= self.scene.stages[0].steps else 1
        half_turn = 0.01 * step
        mine = BodyRecord(
            "anchor", body.position, np.array([np.cos(half_turn), 0, np.sin(half_turn), 0]),
            body.velocity, body.spin, np.array([-1.0, 0, 2.0]) * step, np.zeros(3), 1000.0 * step * stage,
        )
        return Record(
            step, self.scene.stages[stage].name, step - 2 * stage, self.state.time, DT, 1, 3, 0, 1e-7, 17,
            seconds={"contact search": 0.1, "solve": 0.3}, energies={"kinetic": 1 / 7}, bodies=[mine],
        )


def lines(folder):
    with open(Path(folder) / "history.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


# ---- record and history ----


def test_row_names_every_unit_and_keeps_every_digit():
    simulation = FakeSimulation()
    simulation.state = simulation.state_at(3)
    row = simulation.record().row()
    for name in ("time_s", "dt_s", "anchor_x_m", "anchor_qw", "anchor_vx_m_per_s", "anchor_spin_y_rad_per_s",
                 "anchor_contact_fx_N", "anchor_contact_mz_Nm", "anchor_tension_N", "energy_kinetic_J",
                 "seconds_solve", "seconds_contact_search"):
        assert name in row
    assert float(str(row["energy_kinetic_J"])) == 1 / 7


def test_history_is_on_disk_after_each_step(tmp_path):
    simulation, observer = FakeSimulation(), history.History(tmp_path)
    observer.start(simulation)
    for step in (1, 2, 3):
        simulation.state = simulation.state_at(step)
        observer.accepted(simulation.record(), simulation)
        assert [row["step"] for row in lines(tmp_path)] == [str(k) for k in range(1, step + 1)]
    columns = history.read_history(tmp_path)
    assert columns["energy_kinetic_J"][0] == 1 / 7
    assert list(columns["stage"]) == ["settle", "settle", "drag"]
    assert history.body_names(columns) == ["anchor"]


def test_history_resumes_without_second_header_and_drops_later_rows(tmp_path):
    FakeSimulation().run([history.History(tmp_path)], until=5)
    with open(tmp_path / "history.csv", "a", encoding="utf-8") as file:
        file.write("6,drag,4,0.2")  # the machine went down here
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(3)
    resumed.run([history.History(tmp_path)])
    assert [int(row["step"]) for row in lines(tmp_path)] == [1, 2, 3, 4, 5, 6]
    assert (tmp_path / "history.csv").read_text().count("stage_step") == 1


def test_fresh_run_replaces_history_and_new_columns_widen_it(tmp_path):
    FakeSimulation().run([history.History(tmp_path)])
    simulation, observer = FakeSimulation(), history.History(tmp_path)
    observer.start(simulation)
    for step in (1, 2):
        simulation.state = simulation.state_at(step)
        record = simulation.record()
        if step == 2:
            record.seconds["contact"] = 0.5
        observer.accepted(record, simulation)
    columns = history.read_history(tmp_path)
    assert len(columns["step"]) == 2
    np.testing.assert_array_equal(columns["seconds_contact"], [np.nan, 0.5])
    assert columns["seconds_solve"][1] == 0.3


# ---- VTK ----


def test_soil_frame_holds_the_state(tmp_path):
    simulation = FakeSimulation()
    simulation.run([vtk.Frames(tmp_path)], until=4)
    points = simulation.state.points
    mesh = meshio.read(tmp_path / "soil_000004.vtu")
    np.testing.assert_array_equal(mesh.points, points.position)
    data = mesh.point_data
    near = dict(rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(data["displacement"], points.position - simulation.initial_position, **near)
    np.testing.assert_allclose(data["half_widths"], points.half, **near)
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
    observer.finish({}, simulation)
    assert vtk.read_pvd(tmp_path / "soil.pvd")[-1] == ("soil_000005.vtu", 5 * DT)


def test_frames_resume_and_start_afresh(tmp_path):
    FakeSimulation().run([vtk.Frames(tmp_path)])
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(3)
    resumed.run([vtk.Frames(tmp_path)], until=5)
    assert [file[9:11] for file, _ in vtk.read_pvd(tmp_path / "soil.pvd")] == ["00", "02", "03", "04", "05"]
    assert not (tmp_path / "soil_000006.vtu").exists()
    FakeSimulation().run([vtk.Frames(tmp_path)], until=2)
    assert sorted(path.name for path in tmp_path.glob("soil_*.vtu")) == ["soil_000000.vtu", "soil_000002.vtu"]


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


# ---- checkpoint ----


def assert_same(left, right):
    for item in fields(left):
        a, b = getattr(left, item.name), getattr(right, item.name)
        assert (a is None) == (b is None)
        if a is not None:
            assert a.dtype == b.dtype and a.tobytes() == b.tobytes()


def test_checkpoint_returns_every_bit(tmp_path):
    simulation = FakeSimulation()
    for step in (0, 5):
        state = simulation.state_at(step)
        checkpoint.save(tmp_path / "c.npz", state, extra={"dt": 0.1 / 3, "stage": "drag"})
        back = checkpoint.load(tmp_path / "c.npz")
        assert (back.time, back.step, back.work) == (state.time, state.step, state.work)
        assert_same(back.points, state.points)
        assert_same(back.bodies[0], state.bodies[0])
        assert_same(back.contacts[0], state.contacts[0])
        assert checkpoint.read_extra(tmp_path / "c.npz") == {"dt": 0.1 / 3, "stage": "drag"}


def test_checkpoint_refuses_another_scene_and_names_the_difference(tmp_path):
    simulation, path = FakeSimulation(), tmp_path / "c.npz"
    checkpoint.save(path, simulation.state, simulation.scene)
    longer = FakeScene(stages=(Stage("settle", 2), Stage("drag", 9)), output=Output(every=1))
    assert checkpoint.load(path, longer).step == 0
    with pytest.raises(checkpoint.CheckpointError, match=r"soil\.young: checkpoint 2.*\.0, scene 1.*\.0"):
        checkpoint.load(path, FakeScene(soil=Soil(young=1e7)))
    with pytest.raises(checkpoint.CheckpointError, match=r"stages\.0\.steps"):
        checkpoint.load(path, FakeScene(stages=(Stage("settle", 3), Stage("drag", 4))))


def test_geometry_counts_by_content(tmp_path):
    scenes = []
    for name, text in (("a", "Box"), ("b", "Box"), ("c", "Sphere")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "body.geo").write_text(text)
        scenes.append(SimpleNamespace(bodies=[SimpleNamespace(geometry=tmp_path / name / "body.geo")]))
    first, moved, other = map(checkpoint.fingerprint, scenes)
    assert first == moved != other


def test_broken_checkpoint_is_refused(tmp_path):
    with pytest.raises(checkpoint.CheckpointError, match="no run to resume"):
        checkpoint.load(tmp_path / "none.npz")
    (tmp_path / "bad.npz").write_bytes(b"PK\x03\x04 half a file")
    with pytest.raises(checkpoint.CheckpointError, match="not a readable checkpoint"):
        checkpoint.load(tmp_path / "bad.npz")


def test_interrupted_write_keeps_the_old_file(tmp_path):
    (tmp_path / "f").write_text("old")
    with pytest.raises(KeyboardInterrupt), atomic(tmp_path / "f") as partial:
        partial.write_text("half")
        raise KeyboardInterrupt
    assert [path.read_text() for path in tmp_path.iterdir()] == ["old"]


def test_checkpoints_are_saved_every_so_often_and_at_the_end(tmp_path):
    simulation = FakeSimulation()
    simulation.run([checkpoint.Checkpoints(tmp_path)], until=5, outcome="interrupted")
    assert checkpoint.load(tmp_path / "checkpoint.npz", simulation.scene).step == 5
    FakeSimulation(FakeScene(output=Output(checkpoint=0))).run([checkpoint.Checkpoints(tmp_path / "none")])
    assert not (tmp_path / "none").exists()


# ---- progress and summary ----


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_progress_is_one_line_on_a_terminal_and_silent_elsewhere():
    screen, pipe, closing = Terminal(), io.StringIO(), io.StringIO()
    FakeSimulation().run(
        [progress.Progress(screen), progress.Progress(pipe), progress.Progress(closing, announce=True)]
    )
    assert screen.getvalue().count("\n") == 1 and "drag 4/4" in screen.getvalue()
    assert pipe.getvalue() == ""
    assert closing.getvalue().startswith("fake: completed, 6 steps in 0:00")
    simulation = FakeSimulation()
    simulation.state = simulation.state_at(6)
    line = progress.describe(simulation.record(), 4, 75)
    assert line == "drag 4/4  1:15 left  t 0.240 s  dt 0.04 s  3 it  res 1.0e-07  17 contacts  tension 6 kN"
    assert progress.clock(3671) == "1:01:11"


def test_summary_adds_up_over_a_resumed_run(tmp_path):
    observers = [history.History(tmp_path), summary.Summary(tmp_path)]
    FakeSimulation().run(observers, until=4, outcome="interrupted")
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(4)
    resumed.versions = {"gmsh": "4.8"}
    resumed.run([history.History(tmp_path), summary.Summary(tmp_path)])
    content = json.loads((tmp_path / "summary.json").read_text())
    assert content["outcome"] == "completed" and content["step"] == 6 and content["resumed_from_step"] == 4
    assert content["totals"]["steps"] == 6 and content["totals"]["iterations"] == 18
    assert content["totals"]["seconds"] == pytest.approx({"contact_search": 0.6, "solve": 1.8})
    assert content["sizes"] == {"points": 200, "unknowns": 1234}
    assert content["versions"]["numpy"] == np.__version__ and content["versions"]["gmsh"] == "4.8"
    assert content["machine"]["cpus"] >= 1


# ---- figures and pictures ----


def test_figures_are_drawn_from_the_history_alone(tmp_path):
    FakeSimulation().run([history.History(tmp_path)])
    for path in (figures.trajectory(tmp_path), figures.tension(tmp_path),
                 figures.tension(tmp_path, tmp_path / "drag.pdf", against="distance")):
        assert path.stat().st_size > 5000
    turned = figures.pitch(history.read_history(tmp_path), "anchor")
    np.testing.assert_allclose(turned, np.degrees(0.02 * np.arange(1, 7)), atol=1e-10)


def test_pitch_counts_full_turns(tmp_path):
    angle = np.linspace(0, 20, 200)
    columns = {"b_qw": np.cos(angle / 2), "b_qx": 0 * angle, "b_qy": np.sin(angle / 2), "b_qz": 0 * angle}
    np.testing.assert_allclose(figures.pitch(columns, "b"), np.degrees(angle))


def test_comparison_of_two_quantities(tmp_path):
    time = np.linspace(0.01, 1, 100)
    values = [(k * time**2, k * time) for k in (1, 2)]
    curves = [figures.Curve(f"$\\mu = {k}$", time, pair, pair) for k, pair in enumerate(values)]
    assert figures.comparison(tmp_path / "rolling.png", curves).stat().st_size > 5000


def test_errors_against_the_step_in_one_or_two_panels(tmp_path):
    steps = 0.1 / 2.0 ** np.arange(3)
    curves = {name: [(steps, steps**order), (steps / 2, steps**order)] for name, order in (("a", 1), ("b", 2))}
    for count in (1, 2):
        one = {name: pairs[:count] for name, pairs in curves.items()}
        path = figures.convergence(tmp_path / f"{count}.png", one, ("here", "there")[:count], "error [m]")
        assert path.stat().st_size > 5000


def test_colour_limit_is_round_and_never_zero():
    assert render.colour_limit(np.array([0.0, -0.23]), np.zeros(0)) == pytest.approx(0.3)
    assert render.colour_limit(np.zeros(5), np.full(3, -3.4)) == 4
    assert render.colour_limit(np.zeros(5), np.zeros(0)) == 1e-3


def test_pictures_show_soil_and_cut_body(tmp_path):
    pytest.importorskip("pyvista")
    from matplotlib.image import imread

    simulation = FakeSimulation()
    simulation.run([history.History(tmp_path), render.Pictures(tmp_path)])
    if not (tmp_path / "soil_step_002.png").exists():
        pytest.skip("no off-screen OpenGL on this machine")
    image = imread(tmp_path / "soil_step_002.png")[:, :, :3]
    assert image.shape[1] > 1500
    red, blue = image[:, :, 0] - image[:, :, 2] > 0.3, image[:, :, 2] - image[:, :, 0] > 0.3
    assert red.mean() > 0.005 and blue.mean() > 0.005
    assert (tmp_path / "trajectory.png").exists() and (tmp_path / "line_tension.png").exists()


def test_missing_renderer_is_a_warning_not_an_end(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(render.sys, "executable", "/bin/false")
    with caplog.at_level(logging.WARNING):
        assert render.render(tmp_path / "a.png", FakeSimulation()) is False
    assert "no picture a.png" in caplog.text and "apt install" in caplog.text
    assert list(tmp_path.iterdir()) == []
