"""Ground that is not level: points cut to it, the start in equilibrium, bodies on it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import SceneError, StepError
from hybrid.scene import Axis, Body, Faces, Grid, Layer, Material, Pull, Scene, Soil, Stage, Time
from hybrid.scene.defaults import resolve
from hybrid.scene.file import validate
from hybrid.scene.ground import heights, heights_at, mean_heights
from hybrid.setup import settle
from hybrid.setup.build import build
from hybrid.setup.soil import lay_out
from hybrid.study.random.fresh.sand import bank

SAND = Material(law="drucker-prager", cone="plane strain", young=2e7, poisson=0.3, density=1700.0, friction_angle=35.0,
                dilation_angle=5.0, cohesion=1e3)
CLAY = Material(law="von-mises", young=1e7, poisson=0.49, density=1700.0, strength=2e4)
SLOPE = ((0.0, 1.5), (3.0, 1.5), (6.0, 0.0), (10.0, 0.0))


def scene(ground, material=SAND, size=0.5, **more):
    slice_ = Axis(start=0.0, end=0.5, collapsed=True)
    z = Axis(start=-3.0, end=3.0, size=size)
    return Scene(name="ground", grid=Grid(Axis(start=0.0, end=10.0, size=size), slice_, z, Faces(z_min="fixed")),
                 soil=Soil(material, top=2.0, ground=ground), time=Time(1.0, inertia=False), stages=(Stage("rest", 1),),
                 **more)


def test_heights_of_a_profile_are_exact_and_walls_are_vertical():
    surface = heights(((0.0, 1.0), (2.0, 1.0), (2.0, 0.0), (4.0, 2.0)))
    lower, upper = np.array([[-1.0, 0.0], [1.5, 0.0], [2.0, 0.0],
                             [3.0, 0.0]]), np.array([[0.0, 1.0], [2.5, 1.0], [4.0, 1.0], [6.0, 1.0]])
    np.testing.assert_allclose(mean_heights(surface, lower, upper), [1.0, (0.5 + 0.125) / 1.0, 1.0, (1.5 + 2 * 2.0) / 3])
    np.testing.assert_allclose(heights_at(surface, np.array([[2.0, 0.0], [3.0, 5.0], [9.0, 0.0]])), [1.0, 1.0, 2.0])


def test_a_grid_of_heights_from_a_file(tmp_path):
    file = tmp_path / "seabed.csv"
    x, y = np.meshgrid([0.0, 1.0, 3.0], [0.0, 2.0], indexing="ij")
    plane = 0.3 * x - 0.2 * y + 1.0
    file.write_text("x, y, z\n" + "\n".join(f"{a},{b},{c}" for a, b, c in zip(x.ravel(), y.ravel(), plane.ravel())))
    place = np.array([[0.5, 0.5], [2.0, 1.7]])
    np.testing.assert_allclose(heights_at(heights(file), place), 0.3 * place[:, 0] - 0.2 * place[:, 1] + 1.0)
    np.testing.assert_allclose(mean_heights(heights(file), place - 0.2, place + 0.2), heights_at(heights(file), place))
    file.write_text("0,0,1\n1,0,1\n1,1,1")
    with pytest.raises(SceneError, match="3 points are no grid of 2 x 2"):
        heights(file)


def test_soil_may_end_at_its_upper_corner_instead_of_its_top():
    """Bodies lie on it, lines are in it, and layers may cover it."""
    pull = Pull((0.0, 0.0, 0.0), (0.05, 0.0, 0.0), 1e5, 6.0, diameter=0.04)
    block = Body(GEOMETRY / "box.geo", 1000.0, parameters={"length": 1.0, "width": 0.5, "height": 0.5, "size": 20.0},
                 position=(4.5, 0.25, 0.0), rest_on="ground", pull=pull)
    level = replace(scene(None, bodies=(block,)), soil=Soil(CLAY, top=0.5))
    found = [build(replace(level, soil=Soil(CLAY, **ends)))
             for ends in ({"top": 0.5}, {"lower": (0.0, 0.0, -3.0), "upper": (10.0, 0.5, 0.5)})]
    assert found[0].state.bodies[0].position[2] == found[1].state.bodies[0].position[2] == pytest.approx(0.75)
    assert [one.model.bodies[0].line.soil.mudline for one in found] == [0.5, 0.5]
    layer = Layer("clay", 0.5, law="von-mises", material={key: getattr(CLAY, key) for key in (
        "young", "poisson", "density", "strength")})
    build(replace(scene(None), soil=Soil(Material(), lower=(0.0, 0.0, -3.0), upper=(10.0, 0.5, 0.5),
                                         layers=(layer,))))


def test_level_ground_is_that_of_soil_top():
    """To round-off, and nothing has to settle."""
    given = build(scene(((0.0, 0.5), (10.0, 0.5))))
    level = build(replace(scene(None), soil=Soil(SAND, top=0.5)))
    np.testing.assert_allclose(given.state.points.stress, level.state.points.stress, atol=1e-6)
    np.testing.assert_array_equal(given.state.points.position, level.state.points.position)
    assert given.imbalance.share < 1e-9


@pytest.mark.parametrize("ground, volume",
                         [(SLOPE, 36.75), (((0.0, 1.5), (4.0, 1.5), (4.0, 0.37), (6.0, 0.37), (6.0, 1.5)), 42.74)])
def test_soil_is_cut_to_the_ground_and_its_start_is_settled(ground, volume):
    """The volume is that under the ground; stress on the base carries the weight, and the moment of it."""
    simulation = build(scene(ground, replace(SAND, cohesion=2e4)))
    points, soil = simulation.state.points, simulation.model.soil
    assert soil.constants.volume.sum() == pytest.approx(volume * 0.5, rel=2e-3)
    place = np.column_stack([points.position[:, 0], np.zeros(len(points))])
    assert (points.position[:, 2] < heights_at(heights(ground), place) + 0.13).all()
    assert simulation.imbalance.share < 5e-3
    text = simulation.sheet()["modelled"]["settled at the start"]
    assert text.startswith("quasi-static, from ") and "out of balance: points move by up to" in text
    record = next(simulation.steps())
    assert record.notes == () or "initial imbalance" not in " ".join(record.notes)


def test_strength_counts_from_the_ground_above():
    clay = Material(law="von-mises", young=1e7, poisson=0.45, density=1700.0, strength=1e3, strength_gradient=2e3)
    described, _ = resolve(scene(SLOPE, clay))
    from hybrid.setup.grid import build_grid
    constants, _, law = lay_out(replace(described.soil, geostatic=False), build_grid(described)[0],
                                np.array([0.0, 0.0, -9.81]))
    column = np.flatnonzero(np.isclose(constants.position[:, 0], constants.position[-1, 0]))
    far = np.flatnonzero(np.isclose(constants.position[:, 0], constants.position[0, 0]))
    strength = law.cohesion(np.zeros(len(constants)))
    ratio = strength[column[-1]] / strength[far[-1]]    # the same depth of the topmost points below their own ground
    assert ratio == pytest.approx(1.0)


@pytest.mark.parametrize("ground, message", [
    (((0.0, 2.5), (10.0, 0.0)), r"soil.ground = 0 to 2.5 m: must be above -3 m, .* at most soil.top = 2 m"),
    (((5.0, 0.0), (1.0, 0.0)), "soil.ground: x = 5, 1 ... must not decrease; sort the points"),
    (((5.0, 0.0),), "soil.ground: has 1 points, must be at least 2"),
])
def test_ground_that_is_none_is_refused(ground, message):
    with pytest.raises(SceneError, match=message):
        validate(scene(ground))


def test_a_profile_along_an_axis_that_is_left_out_is_refused():
    """It would be level in the slice; heights at x and y may be given."""
    along_x = scene(SLOPE)
    along_y = replace(along_x, grid=replace(along_x.grid, x=along_x.grid.y, y=along_x.grid.x))
    validate(along_x)
    with pytest.raises(SceneError, match="soil.ground = a profile along x: must be along an axis that is modelled"):
        validate(along_y)


def test_a_slope_too_steep_for_its_strength_is_refused():
    weak = replace(SAND, friction_angle=10.0, dilation_angle=0.0, cohesion=100.0)
    with pytest.raises(SceneError, match="no equilibrium at the start.* flatten soil.ground or raise the strength|more "
                                         "than the law can carry"):
        build(replace(scene(((0.0, 2.0), (4.0, 2.0), (4.5, -2.0), (10.0, -2.0)), weak),
                      soil=replace(scene(((0.0, 2.0), (4.0, 2.0), (4.5, -2.0), (10.0, -2.0)), weak).soil)))


def test_a_bank_steeper_than_its_friction_angle_slides_and_a_note_says_so():
    """Sand of 34 degrees built at 40, 26 and 55: it has slid in the settling, stands, and finds no start."""
    notes = next(build(bank(40.0).scene).steps()).notes
    assert re.search(r"initial imbalance: [3-9]\.\d % .* limit 2 %\. Settling at the start, .* slides from the start on\. "
                     r"If it should stand, flatten soil\.ground", " ".join(notes))
    assert "initial imbalance" not in " ".join(next(build(bank(26.0).scene).steps()).notes)
    with pytest.raises(SceneError, match="finds no equilibrium at the start.* flatten soil.ground or raise the strength"):
        build(bank(55.0).scene)


def test_where_newtons_method_fails_near_the_geostatic_stress_gravity_grows_from_none(monkeypatch, caplog):
    """A stable slope then settles by more, as its weight acts on it anew, to nearly the same stress; a bank that slides is
    refused all the same."""
    direct, settled = build(scene(SLOPE)), settle._settled

    def fails_at_first(*given):
        if given[5] == settle.FIRST:
            raise StepError("no convergence")
        return settled(*given)

    monkeypatch.setattr(settle, "_settled", fails_at_first)
    with caplog.at_level("INFO", logger="hybrid"):
        grown = build(scene(SLOPE))
    assert "now gravity grows from none, in about 20 steps" in caplog.text
    text, = grown.sheet()["modelled"]["settled at the start"] if isinstance(
        grown.sheet()["modelled"]["settled at the start"], list) else [grown.sheet()["modelled"]["settled at the start"]]
    assert "under gravity that grows from none" in text and "imbalance" not in " ".join(next(grown.steps()).notes)
    vertical = [simulation.state.points.stress[:, 2, 2] for simulation in (direct, grown)]
    np.testing.assert_allclose(vertical[1], vertical[0], atol=0.1 * np.abs(vertical[0]).max())
    with pytest.raises(SceneError, match="finds no equilibrium at the start"):
        build(bank(55.0).scene)


@pytest.mark.parametrize("ground, height", [(SLOPE, None), (None, 2.0 + 0.25)])
def test_a_body_rests_on_the_ground_below_it(ground, height):
    turn = (0.0, 1.0, 0.0, np.degrees(np.arctan(0.5))) if ground else None
    box = Body(GEOMETRY / "box.geo", 2000.0, parameters={"length": 1.0, "width": 0.5, "height": 0.5, "size": 0.25},
               position=(4.5, 0.25, 0.0), rest_on="ground", rotation=turn, held=("x", "y", "z", "rx", "ry", "rz"))
    simulation = build(scene(ground, replace(SAND, cohesion=2e4), bodies=(box,)))
    expected = height or 0.75 + 0.25 * np.sqrt(1.25)    # of the middle of a box on the slope, 0.25 m off it
    assert simulation.state.bodies[0].position[2] == pytest.approx(expected, abs=1e-5)
