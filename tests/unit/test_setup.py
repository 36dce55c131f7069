"""What `hybrid.setup` makes of a scene: grid, soil and law, bodies; and its refusals name key, value and remedy."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import hybrid
from hybrid.body.rigid import FREEDOMS
from hybrid.contact.search import distances
from hybrid.laws.sand import material_values
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Grid, Layer, Material, Pull, Scene, Soil, Stage, Time
from hybrid.scene.accuracy import apply_accuracy
from hybrid.setup import bodies, law
from hybrid.setup import grid as setup_grid
from hybrid.setup import soil as setup_soil
from hybrid.setup.build import build
from hybrid.study.scenes import box, collapsed, soil_scene

ELASTIC = Material(law="hencky", young=1e6, poisson=0.25, density=1500.0)
GEOMETRY = Path(hybrid.__file__).parents[1] / "geometry" / "box.geo"


def scene(z=Axis(-1.0, 1.0, 0.5), soil=Soil(ELASTIC, top=0.0), **values):
    side = Axis(0.0, 1.0, 0.5)
    return Scene(name="cell", grid=Grid(side, side, z), soil=soil, time=Time(0.1), stages=(Stage("one", 1),), **values)


# ---------------------------------------------------------------- grid


@pytest.mark.parametrize("axis, nodes", [
    (Axis(0.0, 1.0, 0.4), [0, 1 / 3, 2 / 3, 1]),                    # equal cells, no larger than the size
    (Axis(0.0, 2.0, collapsed=True), [1]),
    (Axis(nodes=(0.0, 1.0, 2.5)), [0, 1, 2.5]),
    (Axis(0.0, 4.0, 1.0, fine=(1.0, 2.0), growth=1.3), None),
])
def test_nodes_of_an_axis(axis, nodes):
    found = setup_grid.axis_nodes(axis)
    if nodes is None:
        assert {0.0, 1.0, 2.0, 4.0} <= set(found) and np.diff(found).max() <= 1.3 + 1e-12
    else:
        np.testing.assert_allclose(found, nodes)


def test_a_grid_that_stands_still_has_no_layouts():
    grid, moving_grid, layouts = setup_grid.build_grid(scene())
    assert grid.shape == (3, 3, 5) and moving_grid is None and layouts is None
    assert not grid.fixed.reshape(3, 3, 5, 3)[1, 1, -1].any()       # z_max is free, the others are rollers


# ---------------------------------------------------------------- soil and law


@pytest.mark.parametrize("soil, words", [
    ({"top": -0.2}, "soil.top = -0.2: must be on a grid line, .* nearest line along z is at 0 m; set soil.top to that, "
                    "or choose grid.z.start and grid.z.size"),
    ({"top": 0.0, "lower": (0.3, 0.0, -1.0)}, r"soil.lower\[0\] = 0.3: .* grid.x.size"),
    ({"top": 0.0, "upper": (1.0, 0.7, 0.0)}, r"soil.upper\[1\] = 0.7: .* along y is at 0.5 m"),
])
def test_soil_ends_on_grid_lines(soil, words):
    with pytest.raises(SceneError, match=words):
        build(scene(soil=Soil(ELASTIC, **soil)))


def test_fine_cells_of_a_graded_axis_do_not_end_on_the_surface():
    with pytest.raises(SceneError, match=r"soil.top = 0: .* use grid\.z\.fine = \[-0.6, 1\]"):
        build(scene(z=Axis(-2.0, 1.0, 0.2, fine=(-0.5, 1.0), growth=1.3)))
    with pytest.raises(SceneError, match=r"a line lies at 0 m, with whole cells between the ends of grid\.z\.fine"):
        build(scene(z=Axis(-2.0, 1.0, 0.2, fine=(-1.5, -0.5), growth=1.3)))


def test_the_box_of_soil_is_cut_by_the_grid():
    grid = SimpleNamespace(extent=np.array([[0.0, 1.0], [0.0, 1.0], [-1.0, 1.0]]),
                           lines=(np.array([0.5]), np.linspace(0, 1, 3), np.linspace(-1, 1, 5)))
    described = Soil(ELASTIC, top=0.5, lower=(0.3, -5.0, -0.5), upper=(7.0, 0.5, 0.9))     # x is collapsed: any end
    lower, upper = setup_soil.soil_box(described, grid)
    assert lower.tolist() == [0.3, 0.0, -0.5] and upper.tolist() == [1.0, 0.5, 0.5]       # top overrides upper[2]


def test_cells_that_accuracy_changed_fill_their_axes():
    """Blocks of 2^2 cells of 1 m do not fill 6 m, and of 0.75 m they do not end where the soil does."""
    body = Body(GEOMETRY, 1000.0, rest_on=0.0)
    moving = scene(z=Axis(-4.0, 2.0, 0.5, around=(1.0, 1.0), doublings=2), bodies=(body,))
    assert apply_accuracy(replace(moving, accuracy="draft"))[0].grid.z.size == pytest.approx(0.5)
    assert apply_accuracy(scene(soil=Soil(ELASTIC, top=-0.5), accuracy="draft"))[0].grid.z.size == pytest.approx(0.5)


def test_what_accuracy_changed_is_said_where_a_scene_is_invalid():
    with pytest.raises(SceneError, match="(?s)soil.top = -0.5123: must be on a grid line.*accuracy = 'draft' changed them"):
        build(scene(soil=Soil(ELASTIC, top=-0.5123), accuracy="draft"))


def test_stress_at_rest_is_the_weight_above():
    described = Soil(ELASTIC, top=0.0, k0=0.4)
    grid, *_ = setup_grid.build_grid(scene())
    constants, stress, _ = setup_soil.lay_out(described, grid, np.array([0.0, 0.0, -10.0]))
    np.testing.assert_allclose(stress[:, 2], 1500.0 * 10.0 * constants.position[:, 2])
    np.testing.assert_allclose(stress[:, :2], 0.4 * stress[:, 2:] * np.ones((1, 2)))
    with pytest.raises(SceneError, match="gravity along -z"):
        setup_soil.lay_out(described, grid, np.array([1.0, 0.0, -10.0]))


def test_points_belong_to_the_layer_of_their_centre():
    stiff = Layer("stiff", bottom=-0.5, material={"young": 5e6})
    strata = setup_soil.find_strata(Soil(ELASTIC, top=0.0, layers=(stiff,)), np.array([-0.1, -0.5, -0.9]), 0.0)
    assert [(s.name, s.points.tolist(), s.values["young"]) for s in strata] == [
        ("stiff", [0, 1], 5e6), ("soil", [2], 1e6)]


def test_values_of_a_material():
    """A value that is given replaces that of the preset; one stiffness replaces the other kind."""
    values = material_values(Material(relative_density=40.0, cohesion=5.0, young=1e7))
    assert values["cohesion"] == 5.0 and values["friction_angle"] == 33.0 and "reference_young" not in values
    assert law.coefficient_at_rest("mohr-coulomb", {"friction_angle": 30.0}) == pytest.approx(0.5)
    sand = {"friction_angle": 30.0, "dilation_angle": 0.0, "cone": "plane strain"}
    assert law.coefficient_at_rest("drucker-prager", sand) == pytest.approx(0.5)
    assert law.coefficient_at_rest("hencky", {"poisson": 0.25}) == pytest.approx(1 / 3)
    assert law.coefficient_at_rest("user", {}) == 1.0


def test_stiffness_follows_the_horizontal_stress():
    values = material_values(Material(relative_density=40.0, stiffness_exponent=0.5))
    stratum = setup_soil.Stratum("sand", "hencky", values, 0.5, 0.0, np.arange(2))
    found = law.build_law(stratum, np.array([25e3, 100e3]), np.array([1.0, 4.0]))
    np.testing.assert_allclose(found.young, [12e6, 24e6])
    with pytest.raises(SceneError, match="sand: reference_young = 2.4e.07 Pa.*leaves E = 0 Pa.*give young"):
        law.build_law(stratum, np.zeros(2), np.array([1.0, 4.0]))


# ---------------------------------------------------------------- bodies


def test_a_body_of_plane_faces_rests_on_its_lowest_vertex():
    described = Body(GEOMETRY, 1000.0, rest_on=0.25, rotation=(0.0, 1.0, 0.0, 30.0), held=("x",), driven=("z",),
                     velocity=(0.0, 0.0, -0.5))
    body, motion = bodies.build_body(described, bodies.mesh_of(described), np.array([0.0, 0.0, -9.81]))
    heights = motion.position[2] + (body.surface.vertices @ motion.rotation.T)[:, 2]
    assert heights.min() == pytest.approx(0.25)
    assert [name for name, free in zip(FREEDOMS, body.free) if free] == ["y", "rx", "ry", "rz"]
    assert body.drive.tolist() == [0.0, 0.0, -0.5, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("name, angle, height", [("sphere", 40.0, 0.25), ("cylinder", 90.0, 0.25)])
def test_a_round_body_rests_on_its_surface_and_not_on_its_facets(name, angle, height):
    """Turned so that no vertex is at the bottom; and there it does not overlap soil that ends at this height."""
    described = Body(GEOMETRY.with_name(f"{name}.geo"), 1000.0, rest_on=1.0, rotation=(1.0, 0.3, 0.0, angle))
    body, motion = bodies.build_body(described, bodies.mesh_of(described), np.array([0.0, 0.0, -9.81]))
    if name == "cylinder":      # lying obliquely, on its rim
        axis, radius, half = motion.rotation[2, 2], 0.25, 0.5
        height = half * abs(axis) + radius * np.sqrt(1 - axis**2)
    assert motion.position[2] == pytest.approx(1.0 + height, abs=2e-4)
    under = motion.position + np.random.default_rng(0).uniform(-0.3, 0.3, (2000, 3))
    under[:, 2] = 1.0
    gaps = distances((under - motion.position) @ motion.rotation, body.surface)[0]
    assert 0.0 < gaps.min() + 1e-4 < 0.01
    vertices = motion.position[2] + (body.surface.vertices @ motion.rotation.T)[:, 2]
    assert vertices.min() > 1.0002


def test_a_line_is_fixed_to_a_point_of_the_geometry():
    described = Body(GEOMETRY, 1000.0, pull=Pull("nose", (1.0, 0.0, 0.0), 1e6, 10.0))
    with pytest.raises(SceneError, match="body.pull.point = 'nose' is not a physical point of box.geo; it has "):
        bodies.build_line(described, SimpleNamespace(named_points={}), None)


@pytest.mark.parametrize("soil, contact", [({"held": True}, None), ({"basis": "mpm"}, None), ({}, "corners")])
def test_soil_that_cannot_be_cut_refuses_a_body_inside_it(soil, contact):
    sunk = scene(bodies=(Body(GEOMETRY, 1000.0, position=(0.5, 0.5, -0.2), contact=contact),))
    sunk = replace(sunk, soil=replace(sunk.soil, **soil))
    with pytest.raises(SceneError, match="body 'body' overlaps the soil at the start: .* set body.rest_on"):
        build(sunk)


def test_a_thin_body_between_the_corners_of_held_soil_is_refused():
    """No corner of a domain lies in it."""
    plate = {"length": 0.3, "width": 0.3, "height": 0.1}
    sunk = scene(bodies=(Body(GEOMETRY, 1000.0, position=(0.5, 0.5, -0.15), parameters=plate),))
    with pytest.raises(SceneError, match="it lies between the corners of the points' domains, and the soil is held"):
        build(replace(sunk, soil=replace(sunk.soil, held=True)))


# ---------------------------------------------------------------- contact


def in_plane_strain(length, y=0.5, **more):
    """(Simulation, force [N]) of a box pressed 1 mm into a slice from y = 0 to 1 m, in cells of 0.2 m."""
    pressed = box(0.8, length, 0.4, held=("x",), driven=("z",), velocity=(0.0, 0.0, -1e-3), position=(0.4, y, 0.0),
                  rest_on=0.0, **more)
    described = soil_scene([pressed], y=collapsed(1.0), steps=1, time=Time(1.0, inertia=False))
    simulation = build(described)
    return simulation, next(simulation.steps()).bodies[0].contact_force[2]


@pytest.mark.parametrize("contact", ["faces", "corners"])
@pytest.mark.parametrize("length, y", [(0.3, 0.5), (1.0, 0.5), (1.0, 2.5), (4.0, 0.5)])
def test_in_a_slice_the_length_and_place_of_a_body_do_not_matter(contact, length, y):
    """The force on a body of any length, and its mass, are those on the thickness of the slice."""
    simulation, force = in_plane_strain(length, y, contact=contact)
    assert force == pytest.approx(in_plane_strain(1.2, contact=contact)[1], rel=1e-9) and force > 100.0
    body = simulation.model.bodies[0]
    assert body.mass.mass == pytest.approx(1000.0 * 0.8 * 1.0 * 0.4)
    assert [name for name, free in zip(FREEDOMS, body.free) if free] == ["ry"]
    assert simulation.sheet()["modelled"]["body unknowns"] == 1


@pytest.mark.parametrize("shape", [
    {"rotation": (1.0, 0.0, 0.0, 20.0)}, {"geometry": GEOMETRY.with_name("sphere.geo"), "parameters": {"radius": 0.4}}])
def test_a_body_in_a_slice_is_a_prism(shape):
    reason = (r"body 'body' is no prism along the collapsed axis y: .* Use a prism, such as geometry/box.geo, .*"
              r"grid\.y\.collapsed = false")
    with pytest.raises(SceneError, match=reason):
        in_plane_strain(1.0, **shape)


def test_a_body_in_a_slice_may_turn_in_its_plane():
    assert in_plane_strain(1.0, rotation=(0.0, 1.0, 0.0, 20.0))[0].model.bodies[0].free[4]


ALONG = {"driven": ("x", "z"), "velocity": (0.01, 0.0, -0.01)}


@pytest.mark.parametrize("more, expected", [
    ({}, 500 / 0.2), ({"driven": ("z",), "velocity": (0.0, 0.0, -0.01)}, 2000 / 0.2), ({"penalty": 7.0}, 7.0),
    ({"contact": "corners"}, 50.0), ({**ALONG, "friction": 0.5}, 2000 / 0.2)])
def test_the_penalty_follows_from_the_cells(more, expected):
    """p_f = 500/h on soil that deforms, 2000/h of driven planes; 50 /m is the published one."""
    body = build(soil_scene([box(0.4, 0.4, 0.4, position=(0.4, 0.4, 0.0), rest_on=0.0, **more)])).model.bodies[0]
    assert body.penalty == pytest.approx(expected)
    np.testing.assert_allclose(body.contact_pressure, expected * 1e6)


@pytest.mark.parametrize("friction, expected", [(0.5, 100 / 0.2), (0.0, 2000 / 0.2)])
def test_plates_that_shear_soil_in_plane_strain_have_softer_springs(friction, expected):
    body = build(soil_scene([box(0.4, 0.4, 0.4, position=(0.4, 0.4, 0.0), rest_on=0.0, friction=friction, **ALONG)],
                            y=Axis(0.0, 0.8, collapsed=True))).model.bodies[0]
    assert body.penalty == pytest.approx(expected)


@pytest.mark.parametrize("wide, poisson, driven, expected", [
    (1.2, 0.48, ("z",), 25.0 * 8.78 / 0.8), (0.7, 0.49, ("z",), 20 / 0.2), (1.2, 0.0, ("z",), 20 / 0.2),
    (1.2, 0.4999, ("z",), 100 / 0.2), (1.2, 0.49, ("x", "z"), 20 / 0.2)])
def test_springs_on_a_thin_layer_that_yields_follow_its_stiffness(wide, poisson, driven, expected):
    """25 M/(E H) under a base wider than the layer, of 0.8 m, is high; no less than 20/h and no more than 100/h."""
    velocity = tuple(-0.01 * (axis in driven) for axis in "xyz")
    described = soil_scene([box(wide, 0.8, 0.4, position=(1.0, 0.4, 0.0), rest_on=0.0, driven=driven, velocity=velocity)],
                           x=Axis(0.0, 2.0, 0.2), y=Axis(0.0, 0.8, collapsed=True), z=(-0.8, 0.4))
    clay = replace(described.soil.material, law="von-mises", strength=1e4, poisson=poisson)
    described = replace(described, soil=replace(described.soil, material=clay))
    body, = build(described).model.bodies
    assert body.penalty == pytest.approx(expected, rel=1e-3)
    stuck = replace(described.bodies[0], tension="full")    # drawn up again it bears the clay of few cells
    assert build(replace(described, bodies=(stuck,))).model.bodies[0].penalty == pytest.approx(20 / 0.2)


@pytest.mark.parametrize("young, height", [(1e8, 0.4), (5e6, 0.8)])
def test_a_thin_layer_may_lie_on_stiff_soil(young, height):
    """Rock 100 and 5 times as stiff, 0.4 m under the base: the first one counts as the base of the grid does."""
    described = soil_scene([box(1.2, 0.8, 0.4, position=(1.0, 0.4, 0.0), rest_on=0.0, driven=("z",),
                                velocity=(0.0, 0.0, -0.01))],
                           x=Axis(0.0, 2.0, 0.2), y=Axis(0.0, 0.8, collapsed=True), z=(-0.8, 0.4))
    clay = replace(described.soil.material, law="von-mises", strength=1e4, poisson=0.47)
    rock = Layer("rock", top=-0.4, law="hencky", material={"young": young, "poisson": 0.2})
    body, = build(replace(described, soil=replace(described.soil, material=clay, layers=(rock,)))).model.bodies
    assert body.penalty == pytest.approx(25.0 * 6.009 / height, rel=1e-3)


@pytest.mark.parametrize("young, driven, softer", [(1e9, (), True), (1e9, ("z",), False), (1e4, (), False)])
def test_a_body_that_rolls_on_stiff_soil_does_not_feel_single_places(young, driven, softer):
    """Its penalty is that on held soil, where this is the softer one and the weight is the load."""
    ball = replace(box(0.4, 0.4, 0.4, rest_on=0.0, driven=driven), geometry=GEOMETRY.with_name("sphere.geo"),
                   parameters={"radius": 0.2, "size": 0.1})
    deforming, held = (build(soil_scene([ball], held=held, young=young, gravity=(0.0, 0.0, -9.81))).model.bodies[0]
                       for held in (False, True))
    expected = held.contact_pressure if softer else 500 / 0.2 * young
    np.testing.assert_allclose(deforming.contact_pressure, expected)
    assert (deforming.places.per_edge == held.places.per_edge) == (not driven)


@pytest.mark.parametrize("radius, law, per_edge", [(0.05, "von-mises", 8), (0.2, "von-mises", 8), (0.5, "von-mises", 4),
                                                   (0.05, "hencky", 32)])
def test_places_in_soil_that_yields_do_not_follow_what_is_finer_than_a_cell(radius, law, per_edge):
    """In cells of 0.2 m and domains of 0.1 m; elastic soil may carry a ball on a patch as narrow as its radius asks for."""
    ball = replace(box(0.4, 0.4, 0.4, rest_on=0.0, driven=("z",)), geometry=GEOMETRY.with_name("sphere.geo"),
                   parameters={"radius": radius, "size": 0.5 * radius})
    described = soil_scene([ball], gravity=(0.0, 0.0, -9.81))
    strength = 1e4 if law == "von-mises" else None
    material = replace(described.soil.material, law=law, strength=strength)
    body, = build(replace(described, soil=replace(described.soil, material=material))).model.bodies
    assert body.places.per_edge == per_edge


@pytest.mark.parametrize("young", [1e5, 1e9])
def test_on_held_soil_the_modulus_does_not_matter(young):
    """The pressure per overlap follows from the weight of the body; a given p_f is a factor on E."""
    cube = box(0.4, 0.4, 0.4, position=(0.4, 0.4, 0.0), rest_on=0.0)
    bodies = cube, replace(cube, penalty=2.0)
    derived, given = (build(soil_scene([body], held=True, young=young, gravity=(0.0, 0.0, -9.81))).model.bodies[0]
                      for body in bodies)
    reference = build(soil_scene([cube], held=True, gravity=(0.0, 0.0, -9.81))).model.bodies[0]
    np.testing.assert_allclose(derived.contact_pressure, reference.contact_pressure)
    np.testing.assert_allclose(given.contact_pressure, 2.0 * young)
