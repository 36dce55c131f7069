"""Soil that ends beside or below a body that is pressed into it, nearer than its failure mechanism reaches, is reported
before the run."""

from dataclasses import replace

import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits.margins import covered, narrow_above, narrow_ahead, narrow_margins, no_room_above
from hybrid.scene import Axis, Faces, Load, Material, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import box, collapsed, soil_scene

CLAY = Material(law="von-mises", young=1e6, poisson=0.3, density=1800.0, strength=1e4)
DOWN = {"driven": ("z",), "velocity": (0.0, 0.0, -0.1)}


def texts(x=(-1.0, 1.0), depth=0.4, size=0.05, load=None, material=CLAY, faces=(),
          limit=narrow_margins, above=6, **body):
    """Texts about half of a strip 0.4 m wide on soil in plane strain, whose middle is at x = 0."""
    strip = box(0.4, 0.2, 0.2, name="strip", **{"position": (0.0, 0.1, 0.0), "rest_on": 0.0} | ({} if load else DOWN) | body)
    scene = soil_scene([strip], x=Axis(*x, size), y=collapsed(0.2), z=Axis(-depth, above * size, size),
                       faces=Faces(z_min="fixed", **dict(faces)))
    scene = replace(scene, soil=replace(scene.soil, material=material),
                    stages=(Stage("go", 2, loads=(load,) if load else ()),))
    return limit_texts(limit, scene)


def test_a_side_near_the_body_is_told_with_its_distance_in_widths():
    text, = texts(x=(-1.0, 0.25))
    assert text.startswith("strip is 0.4 m wide, and the soil ends 0.05 m beside it at x = 0.25 m, 0.125 widths, limit "
                           "0.15") and "grid.x outwards" in text
    text, = texts(x=(0.0, 0.25))     # half a model: its width is that of the whole
    assert "strip is 0.4 m wide, and the soil ends 0.05 m beside it at x = 0.25 m" in text


@pytest.mark.parametrize("x, depth, velocity, told", [
    ((-1.0, 0.3), 0.5, 0.1, 1), ((-1.0, 0.35), 0.5, 0.1, 0), ((0.0, 0.3), 0.5, 0.1, 1), ((-1.0, 0.3), 0.3, 0.1, 0),
    ((-1.0, 0.3), 0.5, -0.1, 0), ((-1.0, 0.25), 0.1, 0.1, 0), ((-1.0, 0.65), 1.3, 0.1, 0)])
def test_a_side_near_a_body_that_is_lifted_is_told(x, depth, velocity, told):
    """With its base so deep, 0.2 m high; one is not covered, the last is so deep that a width counts."""
    found = texts(x=x, depth=1.5, rest_on=-depth, velocity=(0.0, 0.0, velocity), limit=narrow_above)
    assert len(found) == told
    assert all("ends 0.1 m beside it at x = 0.3 m, limit 0.135 m by the 0.3 m of soil" in text for text in found)


def test_a_base_near_the_body_is_told_for_the_end_of_its_way():
    text, = texts(depth=0.1, velocity=(0.0, 0.0, -1.0))
    assert "the soil ends 0.08 m below it at the end of its path, 0.2 widths, limit 0.25" in text
    assert "unless the soil is to end there" in text
    assert "0.05 m below it, 0.125 widths" in texts(depth=0.05, load=Load(force=(0.0, 0.0, -50.0)), held=("x", "ry"))[0]


def test_the_mechanism_under_a_rough_body_reaches_farther():
    assert not texts(x=(-1.0, 0.28), size=0.04, depth=0.2) and not texts(depth=0.15)
    assert "0.2 widths, limit 0.25" in texts(x=(-1.0, 0.28), size=0.04, depth=0.2, friction=0.4)[0]
    assert "limit 0.4" in texts(depth=0.15, adhesion=1.0)[0]


def test_the_mechanism_in_soil_with_friction_reaches_farther():
    soil = Material(law="mohr-coulomb", young=1e7, poisson=0.3, density=1800.0, friction_angle=30.0, dilation_angle=30.0,
                    cohesion=1e4)
    text, = texts(x=(-1.0, 0.55), material=soil, depth=1.0)
    assert "0.875 widths, limit 1:" in text and "limit 0.84" in texts(depth=0.3, material=soil)[0]
    assert not texts(x=(-1.0, 0.65), material=soil, depth=1.0)
    assert "limit 1.4" in texts(x=(-1.0, 0.65), material=soil, depth=1.0, friction=0.4)[0]


@pytest.mark.parametrize("values", [
    # a platen on all of the soil
    {}, {"x": (0.0, 0.3)}, {"x": (-1.0, 0.25), "faces": {"x_max": "free"}}, {"x": (-0.2, 0.2)},
    {"x": (-1.0, 0.25), "velocity": (0.1, 0.0, 0.0), "driven": ("x", "z")},
    {"x": (-1.0, 0.25), "velocity": (0.0, 0.0, 0.1)}, {"x": (-1.0, 0.25), "driven": (), "velocity": (0.0, 0.0, -0.1)},
    {"x": (-1.0, 0.25), "material": Material(law="hencky", young=1e6, poisson=0.3, density=1800.0)}])
def test_other_bodies_are_not(values):
    """Far from the ends, on a slope's crest, as wide as the soil, along it, out of it, free, or on elastic soil."""
    assert not texts(**values)


def test_a_deck_above_the_soil_does_not_widen_the_body(tmp_path):
    """A strip 0.4 m wide under a deck of 1.8 m: what the strip alone is told, unless the deck comes down to the soil."""
    (tmp_path / "tee.geo").write_text('SetFactory("OpenCASCADE"); Mesh.MeshSizeMin = 2; Mesh.MeshSizeMax = 2;\n'
                                      "Box(1) = {-0.2, -0.1, -0.1, 0.4, 0.2, 0.3};\n"
                                      "Box(2) = {-0.9, -0.1, 0.2, 1.8, 0.2, 0.1};\n"
                                      "BooleanUnion{ Volume{1}; Delete; }{ Volume{2}; Delete; }\n"
                                      'Physical Volume("body") = {1};\n'
                                      'Physical Surface("contact") = Abs(Boundary{ Volume{1}; });')
    deck = {"geometry": tmp_path / "tee.geo", "parameters": {}}
    assert not texts(**deck) and texts(x=(-1.0, 0.25)) == texts(x=(-1.0, 0.25), **deck)
    assert "strip is 1.8 m wide" in texts(**deck, velocity=(0.0, 0.0, -14.0))[0]


def test_a_footing_wider_than_the_grid_is_told_that_soil_cannot_flow_from_under_it():
    """Not one on soil that can, beside it or through a free face, nor a platen on elastic soil."""
    text, = texts(x=(-0.15, 0.15), limit=covered)
    assert "strip covers all of the soil, x = -0.15 to 0.15 m" in text and "grid.x outwards, unless compression" in text
    assert len(texts(x=(0.0, 0.2), limit=covered)) == 1 and not texts(x=(-0.15, 0.25), limit=covered)
    assert not texts(x=(-0.15, 0.15), limit=covered, faces={"x_max": "free"}) and not texts(x=(-0.15, 0.15), limit=covered,
                                                                                              velocity=(0.0, 0.0, 0.1))
    assert not texts(x=(-0.15, 0.15), limit=covered, material=replace(CLAY, law="hencky", strength=None))


def test_soil_that_fills_the_grid_has_no_room_to_heave():
    """Not where a row of cells is empty, the upper end is held, or the body moves by less than points are below it."""
    given = {"limit": no_room_above, "above": 0, "velocity": (0.0, 0.0, -1.0)}
    text, = texts(**given)
    assert "reaches the upper end of the grid, z = 0 m" in text and "Raise grid.z.end" in text
    assert not texts(**given | {"above": 1}) and not texts(**given, faces={"z_max": "fixed"})
    assert not texts(**given | {"velocity": (0.0, 0.0, -0.5)})
    assert not texts(**given, depth=1.2, position=(0.0, 0.1, -0.7), rest_on=None)       # deep in the soil


def test_a_window_is_an_end_of_the_soil_as_any_other():
    """0.04 m beside the strip, a tenth of its width, and none at all."""
    strip = box(0.4, 0.2, 0.2, name="strip", position=(0.0, 0.1, 0.0), rest_on=0.0, **DOWN)
    found = []
    for window in ((0.04, 0.04), (0.4, 0.4), (0.0, 0.0)):
        x = Axis(-1.0, 1.0, 0.02, window=window, doublings=1)
        faces = Faces(z_min="fixed", x_min="free", x_max="free")     # the ends of a window are held
        scene = soil_scene([strip], x=x, y=collapsed(0.2), z=Axis(-0.4, 0.3, 0.05), faces=faces)
        simulation = build(replace(scene, soil=replace(scene.soil, material=CLAY, geostatic=True)))
        found.append([text for limit in (narrow_margins, covered) for text in limit(simulation.scene, simulation.model)])
    assert "the end of its window" in found[0][0] and "Widen grid.x.window" in found[0][0] and not found[1]
    assert any("widen grid.x.window, unless compression" in text for text in found[2])


def pushed(x, material=CLAY, z=-0.4, window=None, height=0.3, at=-0.05, ground=None, steps=10):
    """Texts about a blade 0.1 m thick, which reaches 0.2 m deep and is pushed 0.1 m along x from x = 0.05 m."""
    blade = box(0.1, 0.2, height, name="blade", position=(0.0, 0.1, at), driven=("x",), velocity=(1.0, 0.0, 0.0),
                held=("z", "ry"))
    axis = Axis(*x, 0.05, window=window, doublings=1) if window else Axis(*x, 0.05)
    scene = soil_scene([blade], x=axis, y=collapsed(0.2), z=Axis(z, 0.3, 0.05), faces=Faces(z_min="fixed"), steps=steps)
    soil = replace(scene.soil, material=material, geostatic=True, ground=ground, top=None if ground else 0.0)
    simulation = build(replace(scene, soil=soil, gravity=(0.0, 0.0, -9.81)))
    return list(narrow_ahead(simulation.scene, simulation.model))


def test_soil_that_ends_ahead_of_a_blade_is_told_for_the_end_of_its_way():
    sand = Material(law="drucker-prager", young=1e7, poisson=0.3, density=1800.0, friction_angle=30.0,
                    dilation_angle=0.0, cohesion=0.0)
    text, = pushed((-1.0, 0.3))
    assert "ends 0.15 m ahead of it at x = 0.3 m, 0.75 of that, limit 1" in text and "Move the end of grid.x" in text
    assert not pushed((-1.0, 0.4)) and "1.3 of that, limit 1.7" in pushed((-1.0, 0.4), sand)[0]
    assert not pushed((-0.1, 1.0)) and not pushed((-1.0, 0.3), z=-0.2)      # behind it; a piston
    assert "window, 0.5 of that" in pushed((-1.0, 1.0), window=(0.3, 0.1))[0]
    assert not pushed((-1.0, 1.0), window=(0.1, 0.3)) and "x = 0.3 m" in pushed((-1.0, 0.3), window=(0.3, 0.3))[0]
    assert "0.05 m ahead of it at x = 0.3 m" in pushed((-1.0, 0.3), window=(0.3, 0.14), steps=20)[0]
    assert not pushed((-1.0, 0.3), ground=((-1.0, 0.0), (0.05, 0.0), (0.05, -0.2), (0.3, -0.2)))     # over an empty pit


def test_the_window_is_that_of_the_body_it_follows_and_a_pile_in_plan_has_its_width():
    """Two blades, the second 0.3 m ahead of the one that is followed; a pile 0.2 m wide."""
    two = [box(0.1, 0.2, 0.3, name=name, position=(x, 0.1, -0.05), driven=("x",), velocity=(1.0, 0.0, 0.0), held=("z", "ry"))
           for name, x in (("one", 0.0), ("two", 0.3))]
    axis = Axis(-1.0, 1.5, 0.05, window=(0.3, 0.4), doublings=1)
    described = soil_scene(two, x=axis, y=collapsed(0.2), z=Axis(-0.4, 0.3, 0.05), faces=Faces(z_min="fixed"), steps=10)
    soil = replace(described.soil, material=CLAY, geostatic=True)
    simulation = build(replace(described, soil=soil, gravity=(0.0, 0.0, -9.81)))
    text, = narrow_ahead(simulation.scene, simulation.model)
    assert text.startswith("two is driven") and "0.1 m ahead of it at the end of grid.x.window" in text
    pile = box(0.2, 0.2, 1.0, name="pile", position=(0.0, 0.0, 0.0), driven=("x",), velocity=(1.0, 0.0, 0.0),
               held=("y", "rz"))
    for end, count in ((0.3, 1), (0.6, 0)):
        described = soil_scene([pile], x=Axis(-1.0, end, 0.05), y=Axis(-1.0, 1.0, 0.05), z=collapsed(1.0), steps=10)
        simulation = build(replace(described, soil=replace(described.soil, material=CLAY, top=None)))
        found = list(narrow_ahead(simulation.scene, simulation.model))
        assert len(found) == count and all("0.2 m of it wide" in text and "4 % too low" in text for text in found)


def test_soil_that_ends_beside_what_it_covers_is_told_on_both_sides():
    text, = pushed((-0.1, 1.0), height=0.1, z=-0.8, at=-0.4)
    assert "0.1 m of it high, which ends 0.05 m behind it at x = -0.1 m" in text and "4 % too low" in text
    assert not pushed((-0.25, 1.0), height=0.1, z=-0.8, at=-0.4)
