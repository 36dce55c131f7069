"""Scene files: TOML to Scene, command-line overrides, and the checks every scene passes.

The reader follows the type hints of `hybrid.scene`: a field added there needs nothing here. Whole numbers are
taken for floats and lists for tuples; booleans are not numbers; NaN and infinity are refused everywhere.
"""

import difflib
import math
import tomllib
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Literal, Union, get_args, get_origin, get_type_hints

from hybrid.runtime.data import shipped_hint
from hybrid.runtime.errors import SceneError
from hybrid.scene import Scene
from hybrid.scene.check import faults


def load_scene(path, overrides=()):
    """Scene of the TOML file at `path`, with `overrides` such as "body.0.friction=0.3" applied in order.

    The scene is named after the file unless it gives a name. Raises SceneError naming the file.
    """
    path = Path(path)
    try:
        tables = _tables(path)
        for override in overrides:
            apply_override(tables, override)
        tables.setdefault("name", path.stem)
        return scene_from_dict(tables, path.parent)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None


def scene_from_dict(tables, base_dir="."):
    """Checked Scene of nested dicts as a TOML reader gives them; paths are relative to `base_dir`."""
    return _checked(_build(Scene, tables, "", Path(base_dir)))


def validate(scene):
    """The scene with every value in its declared type (arrays become tuples, paths absolute).

    Raises SceneError with *all* values out of range, each with its limit and a remedy.
    """
    if not isinstance(scene, Scene):
        raise SceneError(f"expected a Scene, got {type(scene).__name__}; read a file with load_scene(path)")
    return _checked(_build(Scene, scene, "", Path()))


def _checked(scene):
    found = list(faults(scene))
    if found:
        raise SceneError(found[0] if len(found) == 1 else "\n  - ".join([f"{len(found)} faults", *found]))
    return scene


def _tables(path):
    """Raw tables of a TOML file."""
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise SceneError("no such scene file" + (_similar_file(path) or shipped_hint(path))) from None
    except UnicodeDecodeError as error:
        raise SceneError(f"not a UTF-8 text file ({error.reason} at byte {error.start})") from None
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}") from None
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        # A value cut short by the end of the file is reported by tomllib without its line.
        last = f"at end of document, line {len(text.splitlines())}"
        reason = str(error).replace("at end of document", last)
        raise SceneError(f"not valid TOML: {reason}") from None


def _similar_file(path):
    """A hint at the scene file in the same folder whose name is nearest."""
    return _hint(path.name, [other.name for other in path.parent.glob("*.toml")])


# ------------------------------------------------------------------ overrides


def apply_override(tables, override):
    """Set one value, "a.b.c=value", in nested dicts and lists; a number picks an item of a list.

    The value is read as TOML and, where that fails, taken as text. Missing tables are made.
    """
    key, equals, text = override.partition("=")
    names = [name.strip() for name in key.split(".")]
    if not equals or not all(names):
        raise SceneError(f"override {override!r}: expected key.path=value, for example time.step=0.02")
    place = tables
    for depth, name in enumerate(names[:-1]):
        index = _index(place, name, override, names[:depth])
        if index is None:  # a bare [body] is item 0 of its own list
            continue
        if isinstance(place, dict):
            place.setdefault(index, {})
        place = place[index]
    place[_index(place, names[-1], override, names[:-1])] = toml_value(text)


def _index(place, name, override, above):
    """What `name` selects in `place`; None where it selects `place` itself."""
    if isinstance(place, dict):
        return None if name == "0" and name not in place and above in (["body"], ["stage"]) else name
    path = ".".join(above)
    if not isinstance(place, list):
        raise SceneError(f"override {override!r}: {path} = {place!r} is a value and has no {name!r} in it")
    if not name.isdecimal():
        raise SceneError(f"override {override!r}: {path} is a list of {len(place)}; write {path}.0.{name}")
    if int(name) >= len(place):
        raise SceneError(f"override {override!r}: {path} has {len(place)} in it, counted from 0")
    return int(name)


def toml_value(text):
    """`text` as a TOML value, or itself where it is not one."""
    try:
        read = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text.strip()
    return read["value"] if len(read) == 1 else text.strip()


# ------------------------------------------------------------------ values by type hint


def _build(cls, given, key, base):
    """Dataclass `cls` from a table, or from an instance whose values are to be converted."""
    if isinstance(given, cls):
        given = {_name(f): getattr(given, f.name) for f in fields(cls)}
    if not isinstance(given, dict):
        raise _wrong(key, given, cls)
    known = {_name(f): f for f in fields(cls)}
    table = f"[{key}]" if key else "the top level"
    for name in given:
        if name not in known:
            raise SceneError(f"unknown key {_join(key, name)!r}{_hint(name, known)}; "
                             f"valid in {table}: {', '.join(known)}")
    missing = [n for n, f in known.items()
               if n not in given and f.default is MISSING and f.default_factory is MISSING]
    if missing:
        raise SceneError(f"missing in {table}: {', '.join(missing)}")
    hints = get_type_hints(cls)
    return cls(**{known[n].name: _convert(value, hints[known[n].name], _join(key, n), base)
                  for n, value in given.items()})


def _convert(value, hint, key, base):
    """`value` as the type that `hint` declares, or a SceneError naming key, value and what was expected."""
    if hasattr(value, "tolist"):  # numpy arrays and scalars, in scenes written in Python
        value = value.tolist()
    kind = get_origin(hint) or hint
    if is_dataclass(kind):
        return _build(kind, value, key, base)
    if kind in (Union, UnionType):
        return _one_of(value, hint, key, base)
    if kind is Literal:
        choices = get_args(hint)
        if not isinstance(value, str):
            raise _wrong(key, value, hint)
        if value not in choices:
            raise SceneError(f"{key} = {value!r}: unknown{_hint(value, choices)}; "
                             f"valid: {', '.join(choices)}")
        return value
    if kind is tuple:
        return _sequence(value, hint, key, base)
    if kind is dict:
        if not isinstance(value, dict):
            raise _wrong(key, value, hint)
        item_hint = get_args(hint)[1]
        return {name: _convert(item, item_hint, _join(key, name), base) for name, item in value.items()}
    if kind is Path and isinstance(value, (str, Path)) and str(value).strip():
        return (base / value).resolve()
    return _scalar(value, kind, key)


def _scalar(value, kind, key):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind is float and number:
        if not math.isfinite(value):
            raise SceneError(f"{key} = {value}: must be a finite number")
        return float(value)
    if kind in (bool, str) and isinstance(value, kind) or kind is int and number and isinstance(value, int):
        return value
    raise _wrong(key, value, kind)


def _one_of(value, hint, key, base):
    options = [option for option in get_args(hint) if option is not NoneType]
    if value is None and len(options) < len(get_args(hint)):
        return None
    if len(options) == 1:
        return _convert(value, options[0], key, base)
    if isinstance(value, (list, tuple)):  # the option that is a list gives the more precise message
        options = [option for option in options if get_origin(option) is tuple] or options
        return _convert(value, options[0], key, base)
    for option in options:  # and so does a table, or one of some names
        if is_dataclass(option) and isinstance(value, dict) or get_origin(option) is Literal and isinstance(value, str):
            return _convert(value, option, key, base)
    for option in options:
        try:
            return _convert(value, option, key, base)
        except SceneError:
            continue
    raise _wrong(key, value, hint)


def _sequence(value, hint, key, base):
    items = get_args(hint)
    endless = items[-1] is Ellipsis
    if endless and is_dataclass(items[0]) and isinstance(value, dict):
        value = [value]  # a single [body] table is a list of one
    if not isinstance(value, (list, tuple)) or not endless and len(value) != len(items):
        raise _wrong(key, value, hint)
    kinds = [items[0]] * len(value) if endless else items
    return tuple(_convert(item, kind, _join(key, i), base)
                 for i, (item, kind) in enumerate(zip(value, kinds)))


# ------------------------------------------------------------------ words


def _name(f):
    """Key of a dataclass field in a scene file."""
    return f.metadata.get("key", f.name)


def _join(key, name):
    return f"{key}.{name}" if key else str(name)


def _hint(name, choices):
    near = difflib.get_close_matches(str(name).lower(), list(choices), 1, 0.5)
    return f" (did you mean {near[0]!r}?)" if near else ""


def _wrong(key, value, hint):
    shown = {True: "true", False: "false"}.get(value, repr(value)) if isinstance(value, bool) else repr(value)
    return SceneError(f"{key or 'scene'} = {shown}: expected {_words(hint)}")


def _words(hint, plural=False):
    """What a type hint asks for, in words."""
    kind, items = get_origin(hint) or hint, get_args(hint)
    if kind is Literal:
        return "one of " + ", ".join(map(repr, items))
    if kind in (Union, UnionType):
        return " or ".join(_words(item) for item in items if item is not NoneType)
    if kind is tuple:
        count = "" if items[-1] is Ellipsis else f"{len(items)} "
        return f"a list of {count}{_words(items[0], plural=True)}"
    if is_dataclass(kind):
        return "tables" if plural else f"a table ({', '.join(_name(f) for f in fields(kind))})"
    one, many = {
        bool: ("true or false",) * 2, int: ("a whole number", "whole numbers"),
        float: ("a number", "numbers"), str: ("text", "texts"), Path: ("a path", "paths"),
        dict: ("a table of named numbers", "tables"),
    }[kind]
    return many if plural else one
