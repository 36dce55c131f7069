"""Values of a scene by the type hints of its classes: from a TOML reader's dicts and lists, or from Python.

A key declared in the classes of `hybrid.scene` needs nothing here. Whole numbers are taken for floats and lists for
tuples; booleans are not numbers; NaN, infinity and numbers beyond LARGEST and MOST are refused everywhere.
"""

import math
import os
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Literal, Union, get_args, get_origin, get_type_hints

from hybrid.runtime.data import shipped_geometry
from hybrid.runtime.errors import SceneError
from hybrid.scene.table import described, did_you_mean, file_name

LARGEST = 1e30      # of any quantity in SI units: squares and products of such numbers stay finite
MOST = 10**9        # whole numbers, which count things
MANY = 20           # faults in a message
SHOWN = 80          # characters of a value in a message


class Faults(SceneError):
    """Several faults as one error, which lists the first MANY; texts: one of each."""

    def __init__(self, texts):
        self.texts = texts
        more = [f"and {len(texts) - MANY} more"] if len(texts) > MANY else []
        super().__init__(texts[0] if len(texts) == 1 else "\n  - ".join([f"{len(texts)} faults", *texts[:MANY], *more]))


def build_table(cls, given, path, base):
    """Dataclass `cls` from a table, or from an instance whose values are to be converted.

    path: of the table, in dotted keys; base: folder that paths in it are relative to. Raises Faults with all keys that
    are unknown, missing or of another type.
    """
    if isinstance(given, cls):
        given = {file_name(f): getattr(given, f.name) for f in fields(cls)}
    if not isinstance(given, dict):
        raise _wrong(path, given, cls)
    known = {file_name(f): f for f in fields(cls)}
    where = f"[{path}]" if path else "the top level"
    found = [unknown(cls, _join(path, name), name, where) for name in given if name not in known]
    missing = [name for name, f in known.items()
               if name not in given and f.default is MISSING and f.default_factory is MISSING]
    if missing:
        found.append(f"missing in {where}: {', '.join(missing)}")
    hints, items = get_type_hints(cls), []
    for name, f in known.items():
        if name in given and (meant := _meant(f, given[name])):
            found.append(f"{_join(path, name)} = {clipped(given[name])}: write {meant!r}; {described(f).meaning}")
        elif name in given:
            items.append((f.name, given[name], hints[f.name], _join(path, name)))
    values = _convert_all(items, base, found)
    return cls(**values)


def unknown(cls, path, name, where, known=None):
    """Message about a key that table `cls` does not have: what it is called here, or the nearest of those `known`, which
    are all of `cls` if not given. where: the table in words."""
    known = [file_name(f) for f in fields(cls)] if known is None else known
    for f in fields(cls):
        if str(name).lower() in described(f).also and file_name(f) in known:
            unit = f" [{described(f).unit}]" if described(f).unit else ""
            return f"unknown key {clipped(path)}: write {file_name(f)!r}, {described(f).meaning}{unit}"
    if table := _table_of(cls, name):
        return f"unknown key {clipped(path)}: it belongs to the table {_join(path.rpartition('.')[0], table)}"
    return f"unknown key {clipped(path)}{did_you_mean(name, known)}; valid in {where}: {', '.join(known)}"


def _table_of(cls, name):
    """Name of the table in table `cls` that has a key of this name, or another word for it; "" where none has."""
    for f in fields(cls):
        inner = get_type_hints(cls)[f.name]
        if is_dataclass(inner) and any(name == file_name(g) or name in described(g).also for g in fields(inner)):
            return file_name(f)
    return ""


def _meant(f, value):
    """The value of a field for which `value` is another word, None where it is none."""
    return described(f).words.get(value.lower()) if isinstance(value, str) else None


def _convert_all(items, base, found=()):
    """{name: value} of `items` (name, given, hint, path). Raises Faults with all their faults after those `found`."""
    values, found = {}, list(found)
    for name, given, hint, path in items:
        try:
            values[name] = _convert(given, hint, path, base)
        except SceneError as error:
            found += getattr(error, "texts", [str(error)])
    if found:
        raise Faults(found)
    return values


def _convert(value, hint, path, base):
    """`value` as the type that `hint` declares, or a SceneError naming path, value and what was expected."""
    if hasattr(value, "tolist"):  # numpy arrays and scalars, in scenes written in Python
        value = value.tolist()
    kind = get_origin(hint) or hint
    if is_dataclass(kind):
        return build_table(kind, value, path, base)
    if kind in (Union, UnionType):
        return _one_of(value, hint, path, base)
    if kind is Literal:
        choices = get_args(hint)
        if not isinstance(value, str):
            raise _wrong(path, value, hint)
        if value not in choices:
            raise SceneError(f"{path} = {clipped(value)}: unknown{did_you_mean(value, choices)}; "
                             f"valid: {', '.join(choices)}")
        return value
    if kind is tuple:
        return _sequence(value, hint, path, base)
    if kind is dict:
        if not isinstance(value, dict):
            raise _wrong(path, value, hint)
        return _convert_all([(name, item, get_args(hint)[1], _join(path, name)) for name, item in value.items()], base)
    if kind is Path and isinstance(value, (str, Path)) and str(value).strip():
        return _path(value, path, base)
    return _scalar(value, kind, path)


def _scalar(value, kind, path):
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind is float and number:
        if isinstance(value, float) and not math.isfinite(value):
            raise SceneError(f"{path} = {value}: must be a finite number")
        return float(_limited(value, LARGEST, path))
    if kind is int and number and isinstance(value, int):
        return _limited(value, MOST, path)
    if kind in (bool, str) and isinstance(value, kind):
        return value
    raise _wrong(path, value, kind)


def _limited(number, most, path):
    if abs(number) > most:
        raise SceneError(f"{path} = {clipped(number)}: must be from -{most:g} to {most:g}; all values are in SI units")
    return number


def _path(value, path, base):
    place, reason = base / value, "it has a null character" if "\0" in str(value) else ""
    try:
        reason or os.stat(place)
    except (FileNotFoundError, NotADirectoryError):     # whether there has to be a file is checked with the whole scene
        place = shipped_geometry(value) or place
    except OSError as error:    # too long; links in a circle
        reason = error.strerror
    if reason:
        raise SceneError(f"{path} = {clipped(value)}: must be the path of a file, but: {reason}")
    return place.resolve()


def _one_of(value, hint, path, base):
    options = [option for option in get_args(hint) if option is not NoneType]
    if value is None and len(options) < len(get_args(hint)):
        return None
    if len(options) == 1:
        return _convert(value, options[0], path, base)
    if isinstance(value, (list, tuple)):  # the option that is a list gives the more precise message
        options = [option for option in options if get_origin(option) is tuple] or options
        if isinstance(next(iter(value), None), (list, tuple)):     # rows of numbers
            options = [option for option in options if get_origin(next(iter(get_args(option)), None)) is tuple] or options
        return _convert(value, options[0], path, base)
    for option in options:  # and so does a table, or one of some names
        tables = is_dataclass(option) or get_origin(option) is dict
        number = option is float and isinstance(value, float)
        if number or tables and isinstance(value, dict) or get_origin(option) is Literal and isinstance(value, str):
            return _convert(value, option, path, base)
    for option in options:
        try:
            return _convert(value, option, path, base)
        except SceneError:
            continue
    raise _wrong(path, value, hint)


def _sequence(value, hint, path, base):
    items = get_args(hint)
    endless = items[-1] is Ellipsis
    if endless and is_dataclass(items[0]) and isinstance(value, dict):
        value = [value]  # a single [body] table is a list of one
    if not isinstance(value, (list, tuple)) or not endless and len(value) != len(items):
        raise _wrong(path, value, hint)
    kinds = [items[0]] * len(value) if endless else items
    found = _convert_all([(i, item, kind, _join(path, i)) for i, (item, kind) in enumerate(zip(value, kinds))], base)
    return tuple(found.values())


# ------------------------------------------------------------------ words


def _join(path, name):
    return f"{path}.{name}" if path else str(name)


def clipped(value):
    """Text of any value, as it was given, cut in the middle where it is long."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int) and abs(value) > LARGEST:     # Python refuses to write thousands of digits
        return f"a whole number of {math.floor(value.bit_length() * math.log10(2)) + 1} digits"
    try:
        text = repr(value)
    except (RecursionError, ValueError):
        return f"a {type(value).__name__} too large to be shown"
    return text if len(text) <= SHOWN else f"{text[:SHOWN // 2]} ... {text[-SHOWN // 4:]}"


def _wrong(path, value, hint):
    return SceneError(f"{path or 'scene'} = {clipped(value)}: expected {_words(hint)}{_form(value, hint)}")


def _form(value, hint):
    """What helps to write the list that `hint` asks for instead of `value`; "" where nothing more is known."""
    items = get_args(hint)
    rows = [each for each in items if get_origin(each) is tuple and get_args(each)[0] == tuple[float, float]]
    if rows and isinstance(value, (int, float)):
        return f"; write rows, such as [[0, 0], [10, {clipped(value)}]]"
    if get_origin(hint) is not tuple:
        return ""
    if isinstance(value, (list, tuple)):
        return f", {len(value)} given"
    if items == (float, float, float):
        return ", along x, y and z"
    alone = items[0] is int and type(value) is int or isinstance(value, str) and value in get_args(items[0])
    return f"; write [{clipped(value)}]" if alone else ""


def _words(hint, plural=False):
    """The values that a type hint allows, in words."""
    kind, items = get_origin(hint) or hint, get_args(hint)
    if kind is Literal:
        return "one of " + ", ".join(map(repr, items))
    if kind in (Union, UnionType):
        return " or ".join(_words(item) for item in items if item is not NoneType)
    if kind is tuple:
        count = "" if items[-1] is Ellipsis else f"{len(items)} "
        return f"{'lists' if plural else 'a list'} of {count}{_words(items[0], plural=True)}"
    if is_dataclass(kind):
        return "tables" if plural else f"a table ({', '.join(file_name(f) for f in fields(kind))})"
    one, many = {
        bool: ("true or false",) * 2, int: ("a whole number", "whole numbers"),
        float: ("a number", "numbers"), str: ("text", "texts"), Path: ("a path", "paths"),
        dict: ("a table of named numbers", "tables"),
    }[kind]
    return many if plural else one
