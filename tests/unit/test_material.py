"""Values of materials and layers: what a law uses, what a layer inherits, and refusals that say what to do."""

from dataclasses import replace

import numpy as np
import pytest
from small_scene import refused

from hybrid.runtime.errors import SceneError
from hybrid.scene import Layer, Material
from hybrid.scene.defaults import STANDARD_GRAVITY
from hybrid.scene.file import load_scene, scene_from_dict
from hybrid.scene.soil import KEYS, NUMBERS, USES, of_layer
from hybrid.scene.table import described
from hybrid.setup.build import build

CLAY = {"law": "von-mises", "young": 5e6, "poisson": 0.49, "density": 1700.0, "strength": 20e3}
SAND = {"young": 5e6, "poisson": 0.3, "density": 1700.0, "friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 1e3}
USER = {"law": "user", "density": 1700.0}


def scene_of(material, **soil):
    """A Scene with one cell of soil of that material, read as from a file."""
    axis = {"start": 0.0, "end": 1.0, "size": 1.0}
    return scene_from_dict({
        "name": "cell", "grid": {"x": axis, "y": axis, "z": axis}, "soil": {"material": material, **soil},
        "time": {"step": 0.1}, "stage": [{"name": "one", "steps": 1}]})


def message(material, **soil):
    with pytest.raises(SceneError) as error:
        scene_of(material, **soil)
    return str(error.value)


@pytest.mark.parametrize("material", [
    CLAY, CLAY | {"strength": 0.0, "strength_gradient": 2e3}, CLAY | {"hardening": 1e5, "cone": "plane strain"},
    CLAY | {"hardening": -1e5, "residual_strength": 5e3}, SAND | {"law": "willam-warnke"},
    SAND | {"hardening": -1e4, "residual_cohesion": 0.0}, SAND | {"dilation_angle": 30.0},
    {"law": "willam-warnke", "relative_density": 60.0}, {"law": "hencky", "relative_density": 60.0},
])
def test_materials_that_build(material):
    assert len(build(scene_of(material)).model.soil.law.young) == 8


@pytest.mark.parametrize("material, words", [
    (CLAY | {"friction_angle": 30.0}, ["friction_angle = 30: must be left out with law = 'von-mises'", "uses young"]),
    (CLAY | {"relative_density": 38.0}, ["relative_density", "left out with law = 'von-mises'"]),
    (SAND | {"strength": 1e3}, ["strength = 1000: must be left out with law = 'mohr-coulomb'"]),
    (SAND | {"law": "hencky"}, ["3 faults", "cohesion = 1000: must be left out with law = 'hencky'"]),
    (SAND | {"law": "willam-warnke", "cone": "extension"}, ["cone = extension", "left out"]),
    (SAND | {"stiffness_exponent": 0.5}, ["young and stiffness_exponent exclude each other"]),
    (SAND | {"buoyant": True}, ["buoyant = true", "without relative_density"]),
    (SAND | {"hardening": -1e4}, ["missing residual_cohesion for hardening = -10000"]),
    (SAND | {"residual_cohesion": 10.0}, ["left out without softening", "negative hardening"]),
    (SAND | {"hardening": -1e4, "residual_cohesion": 2e3}, ["cohesion = 2000: must be at most cohesion = 1000"]),
    (SAND | {"friction_angle": 0.0, "hardening": -1e4, "residual_cohesion": 0.0}, ["law = 'von-mises' for clay"]),
    (CLAY | {"strength": 0.0}, ["strength = 0: must be positive without a positive strength_gradient"]),
    (CLAY | {"strength": -1.0}, ["strength = -1: must be at least 0 Pa"]),
    (CLAY | {"hardening": -1e4, "residual_strength": 0.0}, ["residual_strength = 0: must be positive"]),
    ({"law": "von-mises"}, ["missing poisson, density, strength, young for law 'von-mises'; give them"]),
    (USER | {"young": 1e6}, ["young = 1000000: must be left out with law = 'user', which uses the density alone"]),
    (USER, ["missing k0 for law 'user'"]),
    (SAND | {"strenght": 1.0}, ["'strength'"]),
    (SAND | {"law": "mises"}, ["write 'von-mises'"]),
])
def test_materials_that_contradict_themselves(material, words):
    found = message(material)
    assert all(word in found for word in words), found


@pytest.mark.parametrize("layer, words", [
    ({"top": 0.5, "bottom": 0.5}, ["soil.layer.0.bottom = 0.5: must be below its top = 0.5"]),
    ({"material": {"yuong": 1e6}}, ["soil.layer.0.material.yuong' (did you mean 'young'?)", "valid in a layer: relative_"]),
    ({"material": {"strength": 1e3}}, ["soil.layer.0.material.strength", "left out with law = 'mohr-coulomb'"]),
    ({"material": {"poisson": 0.5}}, ["soil.layer.0.material.poisson = 0.5: must be above -1 and below 0.5"]),
    ({"material": {"young": "stiff"}}, ["soil.layer.0.material.young = 'stiff': expected a number"]),
    ({"material": {"young": True}}, ["soil.layer.0.material.young = True: expected a number"]),
    ({"material": {"buoyant": 1.0}}, ["soil.layer.0.material.buoyant = 1.0: expected true or false"]),
    ({"material": {"law": "von-mises"}}, ["soil.layer.0.material.law = 'von-mises'", "write soil.layer.0.law"]),
    ({"law": "von-mises"}, ["soil.layer.0.material: missing strength for law 'von-mises'"]),
    ({"law": "user"}, ["soil.layer.0.law = 'user': must be left out"]),
    ({"k0": 0.0}, ["soil.layer.0.k0 = 0: must be positive"]),
    ({"colour": 1}, ["'soil.layer.0.colour'", "valid in [soil.layer.0]: name, top, bottom"]),
])
def test_layers_that_contradict_themselves(layer, words):
    found = message(SAND, layer=[{"name": "one", **layer}])
    assert all(word in found for word in words), found


def test_a_ratio_of_stresses_belongs_to_soil_that_starts_with_some():
    """Without stress it acts where the stiffness follows that of the weight alone."""
    assert "soil.k0 = 0.6: must be left out with geostatic = false" in message(CLAY, geostatic=False, k0=0.6)
    build(scene_of(CLAY, k0=0.6))
    scene_of({"relative_density": 60.0}, geostatic=False, k0=0.6)


def test_a_layer_of_clay_that_is_to_be_buoyant_is_told_so_once():
    layer = {"name": "one", "law": "von-mises", "bottom": 0.5,
             "material": {"young": 1e6, "poisson": 0.49, "density": 1800.0, "strength": 1e4, "buoyant": True}}
    found = message(SAND, layer=[layer])
    assert "without relative_density; give the buoyant density" in found and "faults" not in found


def test_layers_do_not_overlap_and_have_names_of_their_own():
    found = message(SAND, layer=[{"name": "one", "bottom": 0.4}, {"name": "one", "top": 0.5}])
    assert "soil.layer.1: must not overlap layer.0, z = 0.4 to 1 m, but goes from 0 to 0.5 m" in found
    assert "soil.layer.1.name = 'one': must be different" in found


def test_layers_that_cover_the_soil_need_no_material_below_them():
    layers = [{"name": "up", "bottom": 0.5, "material": {"young": 1e6}},
              {"name": "low", "top": 0.5, "material": {"young": 2e6}}]
    simulation = build(scene_of({k: v for k, v in SAND.items() if k != "young"}, layer=layers))
    assert set(simulation.model.soil.law.young) == {1e6, 2e6}
    assert "missing young" in message({k: v for k, v in SAND.items() if k != "young"}, layer=layers[:1])


def test_what_a_layer_inherits():
    sand = Material("drucker-prager", **SAND, cone="extension")
    loose = of_layer(sand, Layer("a", material={"cohesion": 5.0}))
    assert loose == Material("drucker-prager", **SAND | {"cohesion": 5.0}, cone="extension")
    stiff = of_layer(sand, Layer("a", material={"reference_young": 1e7, "stiffness_exponent": 0.5}))
    assert stiff.young is None and stiff.friction_angle == 30.0
    dense = of_layer(sand, Layer("a", material={"relative_density": 80.0}))
    assert dense == Material("drucker-prager", relative_density=80.0, cone="extension")
    clay = of_layer(sand, Layer("a", law="von-mises", material={"strength": 1e4}))
    assert clay == Material("von-mises", young=5e6, poisson=0.3, density=1700.0, strength=1e4, cone="extension")


def test_sand_is_dry_above_a_water_table_and_buoyant_below():
    dry = Material("willam-warnke", relative_density=40.0)
    assert of_layer(dry, Layer("wet", material={"buoyant": True})) == replace(dry, buoyant=True)
    wet = {"name": "wet", "top": 0.5, "material": {"buoyant": True}}
    points = build(scene_of({"relative_density": 40.0}, layer=[wet])).model.soil.constants
    density = points.mass / points.volume
    below = points.position[:, 2] < 0.5
    assert np.allclose(density[~below], 16.6e3 / STANDARD_GRAVITY)       # 15 + 0.04 Dr, 19 + 0.016 Dr - g [kN/m³]
    assert np.allclose(density[below], 19.64e3 / STANDARD_GRAVITY - 1e3)


def test_layers_in_a_file(path):
    path.write_text(path.read_text() + "[[soil.layer]]\nname = 'crust'\nbottom = -0.5\n"
                    "[soil.layer.material]\nrelative_density = 80\n")
    (crust,) = load_scene(path).soil.layers
    assert crust == Layer("crust", bottom=-0.5, material={"relative_density": 80.0})
    assert load_scene(path, ["soil.layer.0.bottom=-1"]).soil.layers[0].bottom == -1.0
    assert "relative_density = 200" in refused(path, "soil.layer.0.material.relative_density=200")


def test_every_number_has_a_use():
    used = {name for names in USES.values() for name in names} | {"density"}
    assert set(NUMBERS) <= used
    assert {n for n in NUMBERS if not described(KEYS[n]).range} == {"hardening", "strength_gradient"}


def test_the_sheet_has_law_hardening_and_layers():
    layers = [{"name": "clay", "top": 0.5, "law": "von-mises", "k0": 0.9, "material": {
        "strength": 20e3, "strength_gradient": 1e3, "hardening": -1e4, "residual_strength": 5e3, "poisson": 0.4}}]
    sheet = build(scene_of(SAND | {"law": "drucker-prager"}, layer=layers)).sheet()
    assert sheet["modelled"]["soil law"] == "drucker-prager, cone matched in compression"
    (line,) = sheet["modelled"]["soil layers"]
    assert line.startswith("clay: z = 0 to 0.5 m, von-mises, cone matched in compression, strength 20000 Pa and 1000 "
                           "Pa/m of depth, softening by 10000 Pa down to 5000 Pa, ") and line.endswith("k0 = 0.9")
    assert not any("hardening" in text for text in sheet["not modelled"])
    plain = build(scene_of(SAND)).sheet()
    assert "soil layers" not in plain["modelled"] and "hardening: the strength is constant" in plain["not modelled"]
    elastic = build(scene_of({"law": "hencky", "young": 1e6, "poisson": 0.3, "density": 1e3})).sheet()
    assert elastic["modelled"]["soil law"] == "hencky" and "plasticity: the law is elastic" in elastic["not modelled"]
