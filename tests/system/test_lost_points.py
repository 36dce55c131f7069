"""Points that leave the grid, are detached or distorted: reported by number, and handled according to `soil.stray`."""

import numpy as np
import pytest

from hybrid.grid.axes import FACES, make_grid
from hybrid.output import checkpoint
from hybrid.output.vtk import drawn
from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Grid, Stage
from hybrid.setup.build import build
from hybrid.soil import lost_points
from hybrid.soil.basis import evaluate_basis
from hybrid.state import Points
from hybrid.step.energy import balance_error, energies
from hybrid.study.scenes import FREE, elastic, scene

AXIS = Axis(start=0.0, end=2.0, size=0.2)
CASES = ["freeze", "remove"]


def thrown(policy, speed=3.0, steps=12, inertia=True, gravity=0.0):
    """A block of soil that is thrown at the end of the grid in x, to which gravity [m/s²] acts."""
    simulation = build(scene(
        "thrown", Grid(AXIS, AXIS, AXIS, FREE), elastic(1e5), [], 0.04, [Stage("fly", steps)],
        soil={"lower": (1.0, 0.8, 0.8), "upper": (1.4, 1.2, 1.2), "stray": policy}, time={"inertia": inertia},
        solver={"linear": "direct"}, gravity=(gravity, 0.0, 0.0)))
    simulation.state.points.velocity[:, 0] = speed
    return simulation


def test_the_run_stops_before_points_leave():
    """The message has their numbers, the limit and the remedy; all that was accepted stays, inside the grid."""
    simulation, records = thrown("stop"), []
    with pytest.raises(StepError, match=r"points \d+ at .* would leave the grid .*soil.stray") as failure:
        for record in simulation.steps():
            records.append(record)
    assert len(records) == simulation.state.step == 5
    assert not lost_points.outside_grid(simulation.state.points.position, simulation.model.soil.grid).any()
    named = int(str(failure.value).split()[1])
    position = simulation.state.points.position
    assert position[named, 0] == pytest.approx(position[:, 0].max())


@pytest.mark.parametrize("policy", CASES)
def test_points_that_leave_take_no_part_any_more(policy):
    """Layer by layer: the others fly on as they were, and mass, ids and number are reported each time they double."""
    simulation, notes, left = thrown(policy), [], []
    for record in simulation.steps():
        assert record.rejections == 0
        notes += record.notes
        points = simulation.state.points
        gone = np.zeros(len(points), bool) if points.inactive is None else points.inactive
        left.append(np.count_nonzero(gone))
        np.testing.assert_allclose(points.velocity[~gone, 0], 3.0, rtol=1e-9)
        assert (points.velocity[gone] == 0).all()
        assert not lost_points.outside_grid(points.position, simulation.model.soil.grid).any()
    assert left[4] == 0 and left[-1] == len(points) and set(left) == {0, 16, 32, 64}
    assert [int(text.split()[0]) for text in notes if "are inactive" in text] == [16, 32, 64]
    assert any("(16 kg, 0.25 of the mass): points 48 at (1.9" in text for text in notes)
    assert len(drawn(simulation)[0]) == (64 if policy == "freeze" else 0)


@pytest.mark.parametrize("policy", CASES)
def test_points_take_their_energy_with_them(policy):
    """All that they had is work "left", and none of it is in the energies any more."""
    simulation = thrown(policy, gravity=9.81)
    start = energies(simulation.model, simulation.state)
    *_, last = simulation.steps()
    assert not simulation.state.points.active.any()
    assert last.energies["left"] == pytest.approx(start["kinetic"]) == 0.5 * 64 * 3.0**2
    assert last.energies["kinetic"] == last.energies["elastic"] == last.energies["potential"] == 0.0
    assert abs(balance_error(last.energies, start)) < 1e-6 * start["kinetic"]


def test_a_checkpoint_keeps_who_is_out(tmp_path):
    """And the policy may change on the way: a run that stopped goes on."""
    simulation = thrown("stop")
    with pytest.raises(StepError):
        list(simulation.steps())
    checkpoint.save(tmp_path / "c.npz", simulation.state, simulation.scene)
    again = thrown("freeze")
    again.state = checkpoint.load(tmp_path / "c.npz", again.scene)
    for record in again.steps():
        if record.step == 7:
            break
    checkpoint.save(tmp_path / "d.npz", again.state, again.scene)
    loaded = checkpoint.load(tmp_path / "d.npz", again.scene)
    np.testing.assert_array_equal(loaded.points.inactive, again.state.points.inactive)
    assert again.state.points.inactive.any()


def test_soil_adrift_is_told_of_and_refused_where_nothing_carries_it():
    """Two blocks: with inertia the smaller is reported; a quasi-static run stops, or goes on without it."""
    def pair(policy, inertia, held=False):
        faces = FREE if not held else type(FREE)(**{f: "fixed" if f == "x_min" else "free" for f in FACES})
        simulation = build(scene(
            "pair", Grid(AXIS, AXIS, AXIS, faces), elastic(1e5), [], 0.04, [Stage("rest", 2)],
            soil={"lower": (0.0, 0.8, 0.8), "upper": (1.0, 1.2, 1.2), "stray": policy}, time={"inertia": inertia},
            solver={"linear": "direct"}))
        away = simulation.state.points.position[:, 0] > 0.8
        simulation.state.points.position[away, 0] += 0.7
        return simulation, away

    simulation, away = pair("stop", True)
    notes = [note for record in simulation.steps() for note in record.notes]
    assert len(notes) == 1 and notes[0].startswith(f"{away.sum()} of {len(away)} points are detached")
    simulation, away = pair("stop", False, held=True)
    with pytest.raises(StepError, match="no held node.*time.inertia"):
        list(simulation.steps())
    simulation, away = pair("freeze", False, held=True)
    list(simulation.steps())
    np.testing.assert_array_equal(simulation.state.points.inactive, away)


def test_pieces_of_soil():
    axes = (np.arange(8.0),) * 3
    grid = make_grid(axes, np.array([(0.0, 7.0)] * 3), dict.fromkeys(FACES, "free") | {"x_max": "roller"})
    place = np.array([[0.5, 0.5, 0.5], [1.5, 1.5, 1.5], [1.5, 0.5, 0.5],
                      [4.5, 4.5, 4.5], [6.5, 0.5, 0.5], [6.5, 1.5, 0.5]])
    basis = evaluate_basis(place, np.full((6, 3), 0.4), grid.axes)
    piece, held = lost_points.detached_pieces(basis, grid)
    assert (piece[:3] == 0).all() and piece[3] != piece[4] == piece[5] != 0
    assert held[piece[4]] and not held[piece[3]]
    piece, _ = lost_points.detached_pieces(basis, grid, np.arange(6) < 3)
    assert not piece.any()


def test_stretched_points():
    deformation = np.tile(np.eye(3), (5, 1, 1))
    deformation[1, 0, 1] = 11.0
    deformation[2] *= 0.4
    deformation[3, 0, 1] = 5.0
    deformation[4] *= 3.0
    assert lost_points.distorted(deformation).tolist() == [False, True, True, False, True]
    assert isinstance(thrown("stop").state.points, Points)


def test_inverted_points_are_named():
    """The message names the points at which an update inverts the soil (det ΔF <= 0)."""
    simulation = thrown("stop", steps=1)
    points = simulation.state.points
    points.velocity[:, 0] = -1e5 * (points.position[:, 0] - 1.2)
    with pytest.raises(StepError, match=r"inside out at points 0, 1, 2, 3, 4 and 59 more"):
        list(simulation.steps())


def test_points_may_leave_in_the_first_step():
    """When they carry no gradients of the rates yet: those that stay behind have none."""
    simulation = thrown("freeze", speed=17.0, steps=2)
    next(simulation.steps())
    points = simulation.state.points
    assert 0 < points.inactive.sum() < len(points)
    assert points.affine.dtype == float and (points.affine[points.inactive] == 0).all()
