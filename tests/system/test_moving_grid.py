"""A grid that goes with a body: soil at rest stays at rest, and forces are those of the whole fine grid."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.api import run
from hybrid.contact import contact_points
from hybrid.runtime.errors import SceneError, StepError
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.scene.file import validate
from hybrid.setup.build import build
from hybrid.state import ContactHistory
from hybrid.step import moving_grid
from hybrid.study.scenes import box

SAND = Material(law="drucker-prager", relative_density=38.0)
ELASTIC = Material(law="hencky", young=2e6, poisson=0.3, density=1800.0)
GRADED = {"around": (0.4, 0.4)}
WINDOW = {"window": (1.0, 1.0)}


def flown_over(steps=60, behind="freeze", **soil):
    """A box that flies over sand that it does not touch, forwards and down."""
    body = box(0.6, 0.6, 0.6, position=(1.5, 0.3, 3.0), velocity=(4.0, 0.0, -1.0), driven=("x", "y", "z"),
               held=("rx", "ry", "rz"))
    axes = [Axis(0.0, 12.8, 0.2, growth=2.0, **GRADED, **WINDOW), Axis(0.0, 3.2, 0.2, growth=2.0, **GRADED),
            Axis(-3.2, 3.2, 0.2, growth=2.0, around=(0.4, 0.2))]
    return Scene(
        name="over", grid=Grid(*axes, Faces(z_min="fixed"), behind=behind), soil=Soil(SAND, top=0.0, **soil),
        bodies=(body,), time=Time(step=0.04), stages=(Stage("fly", steps),), solver=Solver(tolerance=1e-10),
        output=Output(every=0, checkpoint=0))


def plough(x=(), z=(), size=0.2, steps=30, inertia=True):
    """A box pressed into elastic soil while it slides along it, in plane strain and without friction."""
    body = box(0.8, 0.8, 0.6, position=(1.6, 0.0, 0.301), velocity=(1.0, 0.0, -0.05), driven=("x", "y", "z"),
               held=("rx", "ry", "rz"), penalty=500 / size)
    axes = [Axis(0.0, 6.4, size, growth=1.4, **dict(x)), Axis(-0.2, 0.2, collapsed=True),
            Axis(-3.2, 1.6, size, growth=1.4, **dict(z))]
    return Scene(
        name="plough", grid=Grid(*axes, Faces(z_min="fixed")), soil=Soil(ELASTIC, top=0.0), bodies=(body,),
        time=Time(step=0.04, beta=0.5625, gamma=1.0, inertia=inertia), stages=(Stage("go", steps),),
        output=Output(every=0, checkpoint=0), solver=Solver(tolerance=1e-6))


def forces(scene):
    """Force on the body over time (steps, 3) [N], and the simulation at the end."""
    simulation = build(scene)
    return np.array([record.bodies[0].contact_force for record in simulation.steps()]), simulation


@pytest.fixture(scope="module")
def whole():
    """Force on the plough with fine cells everywhere."""
    return forces(plough())[0][10:]


def difference(force, whole):
    """Largest difference in the vertical force relative to its mean; averages over the five steps in which the body, whose
    edge makes the force jump, passes a cell."""
    apart = np.convolve((force[10:] - whole)[:, 2], np.ones(5) / 5, mode="valid")
    return np.abs(apart).max() / np.abs(whole[:, 2]).mean()


def test_soil_at_rest_stays_at_rest_however_often_the_grid_is_laid_anew():
    simulation, counts, shapes = build(flown_over()), [], set()
    for record in simulation.steps():
        shapes.add(simulation.model.soil.grid.shape)
        counts.append(len(simulation.state.points))
        assert record.iterations == 0
        assert np.abs(simulation.state.points.velocity).max() < 1e-10
        assert abs(record.energies["error"]) < 1e-6
    assert len(shapes) > 10
    # blocks of 1.6 m: window and body take 3 or 4 of the 8, and never more, wherever the body is
    assert max(counts[-20:]) / min(counts[:20]) < 5 and simulation.state.bodies[0].position[0] > 10


def test_soil_is_laid_out_once_and_what_is_behind_is_kept():
    simulation = build(flown_over())
    for _ in simulation.steps():
        pass
    ground = simulation.state.ground
    laid = np.count_nonzero(ground.made.any(axis=(1, 2))) * 1.6 * 3.2 * 3.2
    here, behind = ground.constants.volume.sum(), ground.behind.constants.volume.sum()
    assert here + behind == pytest.approx(laid, rel=1e-12)
    assert behind > 0.3 * laid


def moved(simulation, x):
    """Model and state once the body of `simulation` has been carried to `x` [m]."""
    state = simulation.state
    body = replace(state.bodies[0], position=np.array([x, *state.bodies[0].position[1:]]))
    return simulation.moving_grid.follow(simulation.model, replace(state, bodies=[body]))[:2]


def test_a_body_that_comes_back_finds_the_soil_it_left():
    simulation = build(flown_over())
    start = simulation.state.points
    start_ground = simulation.state.ground
    for x in (5.0, 8.0, 5.0, 1.5):
        simulation.model, simulation.state = moved(simulation, x)
    again = simulation.state.points
    assert len(again) == len(start)
    order, old = (np.lexsort(np.round(points.position, 9).T) for points in (again, start))
    for name in ("position", "half_width", "stress", "b_elastic"):
        np.testing.assert_allclose(getattr(again, name)[order], getattr(start, name)[old], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(simulation.state.ground.constants.mass[order], start_ground.constants.mass[old])


def test_soil_that_was_removed_is_missed():
    simulation = build(flown_over(behind="remove"))
    simulation.model, simulation.state = moved(simulation, 8.0)
    assert simulation.state.ground.behind is None
    with pytest.raises(StepError, match="removed; set grid.behind"):
        moved(simulation, 1.5)


def test_graded_cells_give_the_force_of_fine_ones(whole):
    force, simulation = forces(plough(x={"around": (0.6, 0.8)}, z={"around": (0.8, 0.4)}))
    assert len(simulation.state.points) < 0.6 * 32 * 16 * 4
    assert difference(force, whole) < 0.01
    assert abs(simulation.state.work["left"]) < 1e-3 * simulation.model.soil.stored_energy(simulation.state.points)


def test_a_window_gives_the_force_of_all_of_the_soil_the_better_the_wider(whole):
    narrow, wide = (difference(forces(plough(x={"window": (width, width)}))[0], whole) for width in (0.4, 1.6))
    assert wide < 0.025 and wide < 0.6 * narrow


def test_coarse_cells_at_the_body_do_not(whole):
    """The comparison is sensitive: with cells of twice the size everywhere it fails."""
    assert difference(forces(plough(size=0.4))[0], whole) > 0.03


def test_a_quasi_static_grid_travels_too():
    whole = forces(plough(inertia=False, steps=20))[0][10:]
    force, _ = forces(plough(x=GRADED | WINDOW, z={"around": (0.6, 0.2)}, inertia=False, steps=20))
    assert difference(force, whole) < 0.05


def test_a_run_goes_on_where_its_grid_was(tmp_path):
    scene = replace(plough(x=GRADED | WINDOW, z={"around": (0.6, 0.2)}, steps=14), output=Output(every=0, checkpoint=1))
    straight = run(scene, tmp_path / "straight", quiet=True).state
    half = replace(scene, stages=(Stage("go", 8),))
    run(half, tmp_path / "halves", quiet=True)
    halves = run(scene, tmp_path / "halves", resume=True, quiet=True).state
    assert halves.step == straight.step == 14
    np.testing.assert_array_equal(halves.points.position, straight.points.position)
    np.testing.assert_array_equal(halves.points.stress, straight.points.stress)
    np.testing.assert_array_equal(halves.ground.behind.points.stress, straight.ground.behind.points.stress)


def test_a_run_that_goes_on_is_judged_by_where_it_started():
    """Its grid has left the place that the scene gives the body, which is no mistake of the scene."""
    scene = flown_over(25)
    flown, resumed = build(scene), build(scene)
    *_, last = flown.steps()
    resumed.resume(flown.state)
    assert last.bodies[0].position[0] > 5.0 and resumed.model.soil.grid.extent[0, 0] > 1.8
    assert not any("the grid" in text for text in resumed.warned)


def test_points_that_come_in_when_the_body_sinks():
    """As many as fill the grid of a body below the surface; none where the body stays up."""
    scene = plough(x=GRADED, z=GRADED)
    body, simulation = scene.bodies[0], build(scene)
    now, most = len(simulation.state.points), simulation.most_points
    sunk = replace(scene, bodies=(replace(body, position=(1.6, 0.0, -0.3)),), soil=replace(scene.soil, top=-0.8))
    assert most == len(simulation.moving_grid.lay_out(build(sunk).model.soil.grid)[0]) > 1.2 * now
    assert simulation.sheet()["modelled"]["most material points"].startswith(f"{most}, once")
    stays = build(replace(scene, bodies=(replace(body, driven=("x",), velocity=(1.0, 0.0, 0.0),
                                                 held=("y", "z", *body.held)),)))
    assert stays.most_points == now and "most material points" not in stays.sheet()["modelled"]


def test_a_face_where_the_window_ends_holds_the_soil_back():
    scene = flown_over()
    free = replace(scene, grid=replace(scene.grid, faces=Faces(*["free"] * 6)))
    grid = build(free).model.soil.grid
    fixed = grid.fixed.reshape(*grid.shape, 3)
    assert fixed[-1, ..., 0].all()      # the window begins where the axis does, and ends before it
    assert not fixed[:-1].any() and not fixed[..., 1:].any()


def test_contact_points_keep_their_soil_points_and_their_order():
    """Point 5 has gone, and the others have been put in another order."""
    origin = np.array([7, -1, 2, 0])
    point, place = np.array([0, 2, 2, 5, 7, 7]), np.array([3, 1, 5, 1, 0, 90])
    number = np.arange(6)
    history = ContactHistory(point, place, np.stack([number] * 3, axis=1).astype(float), number > 1,
                             np.zeros((6, 3)), np.zeros((6, 3)), np.arange(6.0))
    new = moving_grid._renumbered(history, origin, before=8)
    assert new.point.tolist() == [0, 0, 2, 2, 3] and new.place.tolist() == [0, 90, 1, 5, 3]
    np.testing.assert_array_equal(new.position[:, 0], [4, 5, 1, 2, 0])
    assert moving_grid._without_contact([new], len(origin)).tolist() == [False, True, False, False]
    assert new.touching.tolist() == [True, True, False, True, False]
    np.testing.assert_array_equal(new.rest, [4, 5, 1, 2, 0])


@pytest.mark.parametrize(("change", "text"), [
    (lambda s: replace(s, bodies=()), "grid.follow = None: must be a body of the scene"),
    (lambda s: replace(s, grid=replace(s.grid, follow="anker")),
     "grid.follow = anker: must be a body of the scene: body"),
    (lambda s: replace(s, grid=replace(s.grid, x=replace(s.grid.x, end=12.9))), "grid.x.end = 12.9: must be start = 0"),
    (lambda s: replace(s, grid=replace(s.grid, x=replace(s.grid.x, around=(-1.0, 0.4)))), "grid.x.around"),
    (lambda s: replace(s, grid=replace(s.grid, x=replace(s.grid.x, fine=(1.0, 2.0)))), "exclude each other"),
    (lambda s: replace(s, grid=replace(s.grid, x=replace(s.grid.x, doublings=0))), "grid.x.doublings"),
    (lambda s: replace(s, soil=replace(s.soil, geostatic=False)), "grid.x.window"),
    (lambda s: replace(s, soil=replace(s.soil, held=True)), "soil.held"),
    (lambda s: replace(s, grid=Grid(*[Axis(0.0, 1.6, 0.2)] * 3, follow="body")),
     "grid.follow = body: must be left out"),
])
def test_grids_that_cannot_travel_are_refused(change, text):
    with pytest.raises(SceneError, match=text.replace("(", r"\(")):
        validate(change(flown_over()))


@pytest.mark.parametrize("ends", [{"lower": (9.6, 0.0, -3.2)}, {"upper": (0.0, 3.2, 0.0), "lower": (-3.2, 0.0, -3.2)}])
def test_a_window_without_soil_is_refused(ends):
    """Soil that begins behind it or ends before it, which another part of the grid has."""
    described = flown_over(**ends)
    axis = replace(described.grid.x, start=-6.4)
    with pytest.raises(SceneError, match=r"grid\.x\.window: no soil lies between .* and .* m; let the body start"):
        build(replace(described, grid=replace(described.grid, x=axis)))


def test_a_plate_that_slides_along_elastic_soil_carries_what_one_that_stands_does(monkeypatch):
    """Soil that passes under its front edge comes to press; if it did not, the plate would sink in. One that stands but for
    1e-6 m/s has the same rounded edges."""
    sliding = plough(inertia=False)
    body = replace(sliding.bodies[0], velocity=(1e-6, 0.0, -0.05), position=(2.8, 0.0, 0.301))
    standing = replace(sliding, bodies=(body,))
    stands = forces(standing)[0]
    assert forces(sliding)[0][-1, 2] == pytest.approx(stands[-1, 2], rel=0.05)
    search = contact_points.new_points
    monkeypatch.setattr(contact_points, "new_points", lambda *given: {
        name: values[:None if not len(given[-1]) else 0] for name, values in search(*given).items()})
    assert forces(plough(inertia=False, steps=15))[0][-1, 2] < 0.8 * stands[14, 2]
