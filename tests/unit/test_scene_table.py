"""Declared keys: ranges, docstrings, other words for them, and the texts of numbers out of range."""

import dataclasses
from pathlib import Path
from typing import get_args, get_type_hints

import pytest

from hybrid.runtime.errors import SceneError
from hybrid.scene.body import Body
from hybrid.scene.read import build_table
from hybrid.scene.reference import tables
from hybrid.scene.soil import Material, Soil
from hybrid.scene.stage import Stage
from hybrid.scene.table import Range, described, file_name, key, need, range_faults, required_in_file, shown, table


@table
class Spring:
    """A spring."""

    stiffness: float = key("of the spring", "N/m", above=0, remedy="1e6 is usual")
    ends: tuple[float, float] = key("shares at both ends", "-", default=(1.0, 1.0), at_least=0, at_most=1,
                                    remedy="leave it out for all of it")


@table(kw_only=True)
class Frame:
    """A frame of springs."""

    springs: tuple[Spring, ...] = key("the springs", default=(), name="spring")
    spare: Spring | None = key("another one", default=None)
    name: str = key("label", in_file=False)


def test_classes_are_frozen_and_check_nothing():
    spring = Spring(-1.0)
    assert dataclasses.replace(spring, stiffness=2.0) == Spring(2.0) and hash(spring) == hash(Spring(-1.0))
    with pytest.raises(dataclasses.FrozenInstanceError):
        spring.stiffness = 1.0
    with pytest.raises(TypeError, match="positional"):
        Frame((), None, "a")


def test_the_docstring_lists_the_keys():
    assert Spring.__doc__.splitlines() == [
        "A spring.", "", "    stiffness               [N/m] of the spring",
        "    ends                    [-] shares at both ends"]


def test_names_and_what_a_file_must_have():
    springs, spare, name = dataclasses.fields(Frame)
    assert [file_name(f) for f in (springs, spare, name)] == ["spring", "spare", "name"]
    assert [required_in_file(f) for f in (springs, spare, name, dataclasses.fields(Spring)[0])] == [
        False, False, False, True]
    assert described(dataclasses.fields(Spring)[0]).range == Range(above=0)


def test_a_range_needs_a_remedy():
    with pytest.raises(AssertionError, match="a range needs a remedy"):
        key("of the spring", "N/m", above=0)


def test_faults_of_tables_in_tables():
    frame = Frame(name="a", springs=(Spring(1.0), Spring(-1.0)), spare=Spring(2.0, (0.0, 1.5)))
    assert list(range_faults(frame)) == [
        "spring.1.stiffness = -1: must be positive, in N/m; 1e6 is usual",
        "spare.ends = [0, 1.5]: must be from 0 to 1 each; leave it out for all of it"]
    assert list(range_faults(Frame(name="a"))) == []


@pytest.mark.parametrize("value, text", [
    (True, "true"), (0.1, "0.1"), (2.0, "2"), ("sand", "sand"), ((1, 2.5), "[1, 2.5]")])
def test_values_are_shown_as_in_a_file(value, text):
    assert shown(value) == text
    assert need(False, "a.b", value, "other", "change it") == [f"a.b = {text}: must be other; change it"]


def test_another_word_for_a_key_is_refused_with_its_name():
    @table
    class Sample:
        """A table."""

        stiffness: float = key("of the spring", "N/m", also=("spring", "hardness"))

    assert build_table(Sample, {"stiffness": 2}, "body.0", Path()) == Sample(2.0)
    with pytest.raises(SceneError, match="unknown key 'body.0.Hardness': write 'stiffness', of the spring .N/m."):
        build_table(Sample, {"Hardness": 2.0, "stiffness": 2.0}, "body.0", Path())


@pytest.mark.parametrize("heading, cls", list(tables()))
def test_other_words_stand_for_one_key_and_are_none_themselves(heading, cls):
    words = [word for f in dataclasses.fields(cls) for word in described(f).also]
    assert len(words) == len(set(words)) and words == [word.lower() for word in words]
    assert not set(words) & {file_name(f) for f in dataclasses.fields(cls)}


def test_words_of_the_field_lead_to_the_keys():
    with pytest.raises(SceneError) as error:
        build_table(Material, {"law": "von-mises", "E": 1e7, "undrained_strength": 2e4, "unit_weight": 17e3},
                    "soil.material", Path())
    for words in ("'soil.material.E': write 'young', constant Young's modulus [Pa]", "write 'strength', undrained shear",
                  "write 'density', bulk density [kg/m³]"):
        assert words in str(error.value)


@pytest.mark.parametrize("given, words, inside, outside", [
    ({"above": 0}, "positive", 1e-9, 0), ({"at_least": 0}, "at least 0", 0, -1e-9), ({"below": 2}, "below 2", 1, 2),
    ({"at_least": 0, "at_most": 1}, "from 0 to 1", 1, 1.1), ({"at_least": 0, "below": 90}, "from 0 to below 90", 0, 90),
    ({"above": 1, "at_most": 2}, "above 1 and at most 2", 2, 1), ({"at_most": 3}, "at most 3", 3, 3.1),
    ({"above": -1, "below": 0.5}, "above -1 and below 0.5", 0, -1), ({}, "", 7, None)])
def test_ranges(given, words, inside, outside):
    assert str(Range(**given)) == words and inside in Range(**given)
    assert outside is None or outside not in Range(**given)
    assert bool(Range(**given)) == bool(given) and float("nan") not in Range(above=0)


@pytest.mark.parametrize("heading, cls", list(tables()))
def test_other_words_for_values_stand_for_valid_ones(heading, cls):
    hints = get_type_hints(cls)
    for f in dataclasses.fields(cls):
        valid = [value for option in get_args(hints[f.name]) for value in get_args(option) or [option]]
        for word, value in described(f).words.items():
            assert value in valid and word not in valid and word == word.lower()


@pytest.mark.parametrize("key_, table_", [("density", "soil.material"), ("su", "soil.material"), ("law", "soil.material")])
def test_a_key_in_the_wrong_table_is_led_to_its_own(key_, table_):
    with pytest.raises(SceneError, match=f"unknown key 'soil.{key_}': it belongs to the table {table_}"):
        build_table(Soil, {"material": {"law": "hencky"}, key_: 1.0}, "soil", Path())


def test_words_for_a_kind_of_soil_lead_to_its_law():
    for word, law in (("clay", "von-mises"), ("Sand", "mohr-coulomb"), ("Linear-Elastic", "hencky")):
        with pytest.raises(SceneError, match=f"soil.material.law = '{word}': write '{law}'; hencky: elastic; drucker"):
            build_table(Material, {"law": word, "density": 1.0}, "soil.material", Path())


@pytest.mark.parametrize("make, words", [
    (lambda: Stage("press", 3, motion=()), "Stage(motion=...): unknown argument (did you mean 'motions'?)"),
    (lambda: Stage("press", 3, load=()), "did you mean 'loads'?"),
    (lambda: Body("box.geo", 2400.0, frictoin=0.3), "Body(frictoin=...): unknown argument (did you mean 'friction'?)"),
    (lambda: Material(qqqq=1), "Material(qqqq=...): unknown argument; valid: law,")])
def test_unknown_arguments_are_refused_with_the_nearest_name(make, words):
    """In Python as in a file; names of a file are known too."""
    with pytest.raises(SceneError) as error:
        make()
    assert words in str(error.value)
