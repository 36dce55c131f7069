"""Keys that a scene leaves out are decided in one place, each with its reason; given values stay."""

import re
from dataclasses import fields, replace

import pytest
from small_scene import SCENE

from hybrid.runtime.errors import SceneError
from hybrid.scene import Layer, Material, Stage, Time
from hybrid.scene.defaults import GHOST, GHOST_FLOW, RULES, resolve
from hybrid.scene.file import load_scene, validate
from hybrid.setup.build import build
from hybrid.study.scenes import soil_scene, steel

CUBE = steel(0.2, 0.2, 0.2, position=(0.4, 0.4, 0.2))
PUBLISHED = {"soil.fbar": False, "soil.ghost": 0.0, "body.0.contact": "corners", "body.0.tangential": 1.0,
             "time.scheme": "newmark"}


def decided(scene):
    """{key: (value, reason)} of the decisions for a scene."""
    return {key: (value, reason) for key, value, reason in resolve(scene)[1]}


def test_every_key_left_out_is_decided_with_a_reason():
    scene, decisions = resolve(soil_scene([CUBE]))
    assert [d.key for d in decisions] == list(PUBLISHED) and all(d.reason for d in decisions)
    tables = {"soil": scene.soil, "body": scene.bodies[0], "time": scene.time}
    for key, value, _ in decisions:
        assert getattr(tables[key.split(".")[0]], key.split(".")[-1]) == value is not None
    assert scene.bodies[0].contact == "faces"
    assert resolve(scene) == (scene, ())


def test_only_keys_that_may_be_left_out_have_a_rule():
    for cls, name in RULES:
        assert next(f for f in fields(cls) if f.name == name).default is None


@pytest.mark.parametrize("method", ["default", "published"])
def test_given_values_stay(method):
    cube = replace(CUBE, contact="corners", tangential=0.5)
    scene = replace(soil_scene([cube], fbar=True, ghost=0.1, time=Time(0.1, scheme="energy-momentum")), method=method)
    assert resolve(scene) == (scene, ())


def test_each_body_is_decided_by_itself():
    scene, decisions = resolve(soil_scene([replace(CUBE, contact="corners"), CUBE]))
    assert [body.contact for body in scene.bodies] == ["corners", "faces"]
    assert [d.key for d in decisions if d.key.endswith("contact")] == ["body.1.contact"]


def test_points_without_domains_have_contact_at_corners():
    value, reason = decided(soil_scene([CUBE], basis="mpm"))["body.0.contact"]
    assert value == "corners" and "no faces" in reason


def test_the_published_method():
    found = decided(replace(soil_scene([CUBE]), method="published"))
    assert {key: value for key, (value, _) in found.items()} == PUBLISHED
    assert {reason for _, reason in found.values()} == {"the published method"}


CLAY = {"law": "von-mises", "strength": 2e4, "young": 1e6, "poisson": 0.49, "density": 1800.0}
SAND = Layer("sand", top=0.1, law="drucker-prager", material={"relative_density": 38.0})


@pytest.mark.parametrize("given, soil, limit", [
    ({"friction": 0.3}, {}, 1.0), ({"friction": 0.0}, {}, None), ({"friction": None}, {}, None),
    ({"friction": 0.3}, {"held": True}, None),
    ({"friction": 0.3}, {"layers": (SAND,)}, 1.0), ({"friction": 0.3, "adhesion": 0.5}, {}, 0.5)])
def test_friction_on_clay_is_limited_by_its_strength(given, soil, limit):
    """Not where nothing yields, where there is no s_u, or by the published method."""
    scene = soil_scene([replace(CUBE, **given)], **soil)
    scene = replace(scene, soil=replace(scene.soil, material=Material(**CLAY)))
    assert resolve(scene)[0].bodies[0].adhesion == limit
    assert resolve(replace(scene, method="published"))[0].bodies[0].adhesion == given.get("adhesion")


@pytest.mark.parametrize("collapsed, material, layers, cone", [
    ("y", {"law": "von-mises", "strength": 2e4}, (), "plane strain"),
    ("", {"law": "von-mises", "strength": 2e4}, (), "plane strain"),       # nowhere stronger than Tresca's
    ("", {"law": "drucker-prager", "relative_density": 38.0}, (), "compression"),
    ("xy", {"law": "von-mises", "strength": 2e4}, (), "compression"),      # sides that stay: triaxial compression
    ("y", {"law": "willam-warnke", "relative_density": 38.0}, (), None),
    ("y", {}, (Layer("sand", top=0.1, law="drucker-prager", material={"relative_density": 38.0}),), "plane strain"),
])
def test_cone_of_a_scene(collapsed, material, layers, cone):
    """As strong as the angles and the strength say in the states that the scene can be in."""
    scene = soil_scene([], layers=layers)
    values = {"young": None, "poisson": None} if "relative_density" in material else {}
    grid = replace(scene.grid, **{axis: replace(getattr(scene.grid, axis), collapsed=True, size=None) for axis in collapsed})
    soil = replace(scene.soil, material=replace(scene.soil.material, **values, **material))
    scene = validate(replace(scene, soil=soil, grid=grid))
    assert resolve(scene)[0].soil.material.cone == cone
    assert ("soil.material.cone" in decided(scene)) == (cone is not None)
    assert "soil.material.cone" not in decided(replace(scene, method="published")) or cone is not None


@pytest.mark.parametrize("collapsed, values, law", [
    ("", {"relative_density": 38.0}, "willam-warnke"),
    ("", {"young": 1e7, "poisson": 0.3, "density": 1700.0, "friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 1e3},
     "mohr-coulomb"),
    ("", {"relative_density": 38.0, "cone": "compression"}, "drucker-prager"),
    ("y", {"relative_density": 38.0}, "drucker-prager"),
    ("xy", {"relative_density": 38.0}, "drucker-prager"),
    ("", {"young": 1e6, "poisson": 0.49, "density": 1700.0, "strength": 2e4}, "von-mises"),
])
def test_law_of_a_soil_whose_strength_is_given(collapsed, values, law):
    scene = soil_scene([])
    grid = replace(scene.grid, **{axis: replace(getattr(scene.grid, axis), collapsed=True, size=None) for axis in collapsed})
    scene = validate(replace(scene, grid=grid, soil=replace(scene.soil, material=Material(**values))))
    assert resolve(scene)[0].soil.material.law == law
    published = resolve(replace(scene, method="published"))[0].soil.material.law
    assert published == ("von-mises" if law == "von-mises" else "drucker-prager")


CLAY = {"law": "von-mises", "strength": 2e4}


@pytest.mark.parametrize("material, soil, fbar, reason", [
    ({}, {}, False, "elastic soil that changes its volume"),
    ({"poisson": 0.39}, {}, False, "elastic soil that changes its volume"),
    ({"poisson": 0.4}, {}, True, "nearly incompressible .*poisson = 0.4, limit 0.4"),
    ({"poisson": 0.49}, {"held": True}, False, "held soil does not deform"),
    (CLAY, {}, True, "plastic flow .*law = 'von-mises'"),
    (CLAY, {"basis": "mpm"}, False, "standard points"),
    ({}, {"layers": (Layer("clay", top=0.1, law="von-mises", material={"strength": 2e4}),)}, True, "plastic flow"),
    ({}, {"layers": (Layer("stiff", top=0.1, material={"poisson": 0.45}),)}, True, "nearly incompressible"),
    ({"law": "user", "young": None, "poisson": None}, {}, True, "law = 'user'"),
])
def test_fbar_follows_from_the_laws(material, soil, fbar, reason):
    described = soil_scene(geostatic=False, **soil)
    described = replace(described, soil=replace(described.soil, material=replace(described.soil.material, **material)))
    found = decided(described)
    value, why = found["soil.fbar"]
    assert value is fbar and re.search(reason, why)
    assert found["soil.ghost"][0] == (0.0 if soil.get("held") else 0.03 if "law" in material and "strength" in material
                                      else GHOST)


@pytest.mark.parametrize("material, bodies, ghost", [(CLAY, 1, GHOST_FLOW), (CLAY, 0, GHOST), ({}, 1, GHOST)])
def test_the_ghost_penalty_is_loose_where_soil_flows_along_bodies(material, bodies, ghost):
    described = soil_scene([CUBE] * bodies, geostatic=False, time=Time(1.0, inertia=False))
    described = replace(described, soil=replace(described.soil, material=replace(described.soil.material, **material)))
    assert decided(described)["soil.ghost"][0] == ghost
    plane = replace(described.grid, y=replace(described.grid.y, collapsed=True))
    assert decided(replace(described, grid=plane))["soil.ghost"][0] == GHOST


@pytest.mark.parametrize("material, soil, bodies, ghost", [
    ({}, {}, 0, 0.003), ({}, {}, 1, GHOST_FLOW), ({"young": 1e4}, {}, 0, GHOST),
    ({"strength_gradient": 1e3}, {}, 0, 0.0036),
    ({}, {"layers": (Layer("soft", top=-0.2, material={"strength": 1e3}),)}, 0, 0.003),
    ({}, {"layers": (Layer("sand", top=-0.2, law="drucker-prager", material={"friction_angle": 30.0}),)}, 0, GHOST)])
def test_the_ghost_penalty_of_clay_with_inertia_goes_by_its_strength(material, soil, bodies, ghost):
    """2 kPa and 1 MPa, 0.4 m deep."""
    described = soil_scene([CUBE] * bodies, geostatic=False, **soil)
    clay = replace(described.soil.material, law="von-mises", young=1e6, strength=2e3)
    described = replace(described, soil=replace(described.soil, material=replace(clay, **material)))
    assert decided(described)["soil.ghost"][0] == pytest.approx(ghost, rel=0.02)
    before = GHOST_FLOW if bodies else GHOST
    slow = replace(described, time=replace(described.time, inertia=False))
    assert decided(slow)["soil.ghost"][0] == before
    heavy = replace(described, gravity=(0.0, 0.0, -9.81))       # 0.2 m falls 0.25 of it in 71 ms
    for step, found in ((0.07, ghost), (0.073, before)):
        assert decided(replace(heavy, time=Time(step)))["soil.ghost"][0] == pytest.approx(found, rel=0.02)


@pytest.mark.parametrize("values, stages, scheme, reason", [
    ({"beta": 0.5625, "gamma": 1.0}, {}, "newmark", "beta and gamma are those of Newmark's"),
    ({"beta": 0.3}, {}, "newmark", "beta and gamma"),
    ({}, {"gamma": 1.0, "beta": 0.5625}, "generalised-alpha", "second order"),
    ({"spectral_radius": 0.5}, {}, "generalised-alpha", "second order"),
])
def test_the_scheme_follows_from_its_parameters(values, stages, scheme, reason):
    described = replace(soil_scene(time=Time(0.1, **values)), stages=(Stage("one", 1, **stages),))
    validate(described)
    value, why = decided(described)["time.scheme"]
    assert value == scheme and reason in why


@pytest.mark.parametrize("method, scheme", [("default", "generalised-alpha"), ("published", "newmark")])
def test_the_scheme_is_not_listed_without_inertia(method, scheme):
    """It has a value, as every key, and no effect."""
    scene, decisions = resolve(replace(soil_scene(time=Time(0.1, inertia=False)), method=method))
    assert scene.time.scheme == scheme and "time.scheme" not in {decision.key for decision in decisions}


def test_parameters_of_two_schemes_are_refused():
    with pytest.raises(SceneError, match="time.spectral_radius = 0.5: must be left out with scheme = 'newmark'"):
        validate(soil_scene(time=Time(0.1, gamma=0.6, spectral_radius=0.5)))


def test_an_unknown_method_is_refused_with_the_nearest_name(tmp_path):
    (tmp_path / "scene.toml").write_text('method = "publishd"\n' + SCENE, encoding="utf-8")
    with pytest.raises(SceneError, match="method = 'publishd': unknown .did you mean 'published'..; valid: default, "):
        load_scene(tmp_path / "scene.toml")


def test_the_model_sheet_shows_what_was_decided():
    simulation = build(soil_scene(fbar=True))
    rows = simulation.sheet()["modelled"]["decided"]
    assert rows == [str(d) for d in simulation.decisions] and not any(row.startswith("soil.fbar") for row in rows)
    assert simulation.scene.soil.ghost is not None and rows[0].startswith(f"soil.ghost = {simulation.scene.soil.ghost:g}: ")


def test_what_is_built_is_the_decided_scene():
    """A scene with its keys left out gives the model of the scene that names the decided values."""
    left_out = build(soil_scene([CUBE]))
    named = build(left_out.scene)
    assert left_out.scene == named.scene and named.decisions == ()
    assert left_out.model.bodies[0].penalty == named.model.bodies[0].penalty
    assert left_out.model.scheme == named.model.scheme


@pytest.mark.parametrize("ground, kept", [(((0.0, 0.0), (1.0, 0.0)), False), (((0.0, 0.1), (1.0, 0.0)), False),
                                          (((0.0, 0.0), (1.0, -0.01)), True)])
def test_ground_that_takes_nothing_away_from_the_soil_is_none(ground, kept):
    scene = soil_scene(ground=ground)
    assert (resolve(scene)[0].soil.ground is not None) == kept
