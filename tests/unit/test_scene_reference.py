"""The declared keys as a JSON Schema and as a page: both are current, and the schema agrees with the reader."""

import copy
import json
import tomllib
from pathlib import Path

import pytest
from small_scene import SCENE

from hybrid.cli import main
from hybrid.runtime.errors import SceneError
from hybrid.scene import Layer, Material, Scene
from hybrid.scene.file import apply_override, scene_from_dict
from hybrid.scene.reference import json_schema, page, tables

DEMOS = Path(__file__).parents[2] / "demos"


@pytest.fixture(scope="module")
def schema():
    """Function that gives the messages of a JSON Schema validator for the tables of a scene."""
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator.check_schema(json_schema())
    validator = jsonschema.Draft202012Validator(json_schema())
    return lambda tables: [error.message for error in validator.iter_errors(tables)]


def test_the_page_is_current():
    text = (DEMOS / "scene-reference.md").read_text(encoding="utf-8")
    assert text == page(), "make it anew: hybrid schema --page --out demos/scene-reference.md"


def test_the_page_has_every_table_and_key():
    text = page()
    for heading, cls in tables():
        assert heading in text
    assert ("| `tolerance` | number | - | `0.0001` | from 1e-14 to below 1 "
            "| tolerance of the residual, relative to the forces acting |") in text
    assert "| `steps` | whole number | - | *required* | at least 1 | outer steps |" in text
    assert text.count("\n| `") >= sum(len(cls.__dataclass_fields__) for cls in {cls for _, cls in tables()})
    assert ("| `hencky` | `poisson`, `density`; `young`, or `reference_young` and `stiffness_exponent` "
            "| `relative_density`, `buoyant`, `young`") in text
    assert "| `drucker-prager` | `poisson`, `density`, `friction_angle`, `dilation_angle`, `cohesion`; " in text


def test_headings_are_those_of_a_scene_file():
    found = [heading for heading, _ in tables()]
    assert found[:5] == ["top level", "[grid]", "[grid.x]", "[grid.y]", "[grid.z]"]
    assert {"[[soil.layer]]", "[[body]]", "[body.pull]", "[[stage]]", "[accuracy]", "[output]"} <= set(found)


@pytest.mark.parametrize("demo", sorted(DEMOS.glob("*.toml")), ids=lambda demo: demo.stem)
def test_every_demo_fits_the_schema(schema, demo):
    assert schema(tomllib.loads(demo.read_text(encoding="utf-8"))) == []


def test_the_schema_refuses_unknown_keys_in_every_table(schema):
    whole = tomllib.loads(SCENE)
    whole["soil"]["layer"] = [{"name": "one", "material": {"young": 1e6}}]
    whole |= {"accuracy": {"like": "column", "error": 0.1, "length": 1.0}, "solver": {}, "output": {}}
    assert schema(whole) == []
    places = [(), ("grid",), ("grid", "x"), ("grid", "faces"), ("soil",), ("soil", "material"), ("soil", "layer", 0),
              ("soil", "layer", 0, "material"), ("body", 0), ("body", 0, "pull"), ("time",), ("stage", 1),
              ("accuracy",), ("solver",), ("output",)]
    for place in places:
        changed = copy.deepcopy(whole)
        inner = changed
        for name in place:
            inner = inner[name]
        inner["colour"] = 1
        assert schema(changed), place
    objects = [cls for _, cls in tables()]
    assert all(not json_schema()["$defs"][cls.__name__]["additionalProperties"] for cls in objects if cls is not Scene)


@pytest.mark.parametrize("override", [
    "time.step=fast", "time.step=true", "time.step=0", "stage.0.steps=0", "stage.0.steps=2.5", "gravity=[0, -9.81]",
    "body.0.friction=-0.1", "body.0.held=['y', 'rxy']", "body.0.pull.point=3", "soil.material.law=drucker", "grid=3",
    "soil.points_per_axis=[2, 2]", "soil.points_per_axis=0", "grid.x.growth=1", "accuracy=drafts", "solver.tolerance=1",
    "output.pictures=[0]", "stage.0.gravity=[0, 11]", "body.0.parameters.radius=big", "soil.material.poisson=0.5"])
def test_schema_and_reader_refuse_the_same(schema, path, override):
    given = tomllib.loads(SCENE)
    apply_override(given, override)
    assert schema(given)
    with pytest.raises(SceneError):
        scene_from_dict({"name": "x", **given}, path.parent)


def test_a_single_body_table_and_a_missing_key(schema):
    assert schema(tomllib.loads(SCENE.replace("[[body]]", "[body]"))) == []
    assert "'step' is a required property" in schema(tomllib.loads(SCENE.replace("step = 0.04\n", "")))


def test_units_and_defaults_are_in_the_schema():
    body = json_schema()["$defs"]["Body"]
    penalty = body["properties"]["penalty"]
    assert penalty.pop("description").startswith("[1/m] p_f: contact has a pressure of p_f E per unit of overlap")
    assert penalty == {"type": "number", "exclusiveMinimum": 0}
    assert body["properties"]["velocity"]["default"] == [0.0, 0.0, 0.0]
    assert body["required"] == ["geometry", "density"]
    assert json_schema()["required"] == ["grid", "soil", "time", "stage"]
    assert set(json_schema()["$defs"]["Layer"]["properties"]["material"]["properties"]) >= {"young", "strength"}
    assert Layer("a").material == {} and Material().law is None


def test_the_command(capsys, tmp_path):
    assert main(["schema"]) == 0 and json.loads(capsys.readouterr().out) == json_schema()
    assert main(["schema", "--page", "--out", str(tmp_path / "keys.md")]) == 0
    assert (tmp_path / "keys.md").read_text(encoding="utf-8") == page()
    assert main(["schema", "--out", str(tmp_path / "no" / "folder.json")]) == 2
    assert "cannot be written (No such file or directory); name a file in an existing" in capsys.readouterr().err
