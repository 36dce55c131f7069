"""All keys of a scene file as a JSON Schema for editors and as a page in Markdown, from the keys' declarations."""

import inspect
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import NoneType
from typing import Literal, get_args, get_origin, get_type_hints

from hybrid.scene import Layer, Material, Scene
from hybrid.scene.defaults import RULES
from hybrid.scene.soil import KEYS, NEEDS, OF_LAYERS, USES
from hybrid.scene.table import Range, described, file_name, required_in_file, shown

DRAFT = "https://json-schema.org/draft/2020-12/schema"
KEYWORDS = {"above": "exclusiveMinimum", "at_least": "minimum", "below": "exclusiveMaximum", "at_most": "maximum"}
NAMES = {float: "number", int: "integer", bool: "boolean", str: "string", Path: "string"}     # of JSON

# ------------------------------------------------------------------ JSON Schema


def json_schema():
    """JSON Schema (draft 2020-12) of scene files as a dict; keys that are not declared are refused."""
    classes = list(dict.fromkeys(cls for _, cls in tables()))
    return {"$schema": DRAFT, "title": "Scene of hybrid", **_object(Scene),
            "$defs": {cls.__name__: _object(cls) for cls in classes if cls is not Scene}}


def _object(cls):
    hints, properties = get_type_hints(cls), {}
    for f in fields(cls):
        key, unit = described(f), described(f).unit
        own = _type(hints[f.name], key.range) if (cls, f.name) != (Layer, "material") else _values_of_material()
        own["description"] = f"[{unit}] {key.meaning}" if unit else key.meaning
        if f.default not in (MISSING, None) and not is_dataclass(f.default):
            own["default"] = list(f.default) if isinstance(f.default, tuple) else f.default
        properties[file_name(f)] = own
    return {"description": about(cls), "type": "object", "properties": properties, "additionalProperties": False,
            "required": [file_name(f) for f in fields(cls) if required_in_file(f)]}


def _type(hint, limits=Range()):
    """Schema of the values that a type hint allows; limits: of numbers."""
    kind, items = get_origin(hint) or hint, [item for item in get_args(hint) if item is not NoneType]
    if kind is Literal:
        return {"enum": items}
    if kind is tuple:
        some = {"type": "array", "items": _type(items[0], limits)}
        if items[-1] is not Ellipsis:
            return {**some, "minItems": len(items), "maxItems": len(items)}
        return {"anyOf": [some, some["items"]]} if is_dataclass(items[0]) else some   # [body] is one of [[body]]
    if kind is dict:
        return {"type": "object", "additionalProperties": _type(items[1])}
    if is_dataclass(kind):
        return {"$ref": f"#/$defs/{kind.__name__}"}
    if items:
        options = [_type(item, limits) for item in items]
        return options[0] if len(options) == 1 else {"anyOf": options}
    ends = {word: getattr(limits, end) for end, word in KEYWORDS.items() if getattr(limits, end) is not None}
    return {"type": NAMES[kind], **(ends if kind in (float, int) else {})}


def _values_of_material():
    """Schema of [soil.layer.material]: what a layer may have of [soil.material]."""
    hints = get_type_hints(Material)
    values = {name: _type(hints[name], described(KEYS[name]).range) for name in OF_LAYERS}
    return {"type": "object", "properties": values, "additionalProperties": False}


# ------------------------------------------------------------------ page

HEAD = """# Keys of a scene file

Every table and key, made by `hybrid schema --page`. Units are SI, angles are in degrees, z points upwards.
A key without a default (–) may be left out, but for the values of soil.material that its law needs; *required* keys may
not. A default that is *decided* follows from the other keys: `hybrid check` shows the value and the reason
(`hybrid.scene.defaults`). The range of a list is that of each number in it.
Keys that are unknown, of another type, out of range or in contradiction are refused with value, limit and remedy.

For completion and checks in an editor, write the JSON Schema beside the scene, `hybrid schema --out scene.schema.json`,
and begin the scene with `#:schema ./scene.schema.json` (Taplo, Even Better TOML).
"""


def page():
    """Markdown text of all tables and keys."""
    headings = {}
    for heading, cls in tables():
        headings.setdefault(cls, []).append(heading)
    return "\n".join([HEAD, *(_section(cls, paths) for cls, paths in headings.items())])


def tables(cls=Scene, path=""):
    """Yields (heading, class) of the tables of a scene file, outer ones first, such as ("[[body]]", Body)."""
    yield path or "top level", cls
    hints = get_type_hints(cls)
    for f in fields(cls):
        several = get_origin(hints[f.name]) is tuple
        inner = f"{path.strip('[]')}.{file_name(f)}".lstrip(".")
        for kind in (hints[f.name], *get_args(hints[f.name])):
            if is_dataclass(kind):
                yield from tables(kind, f"[[{inner}]]" if several else f"[{inner}]")


def about(cls):
    """The docstring of a table without its list of keys."""
    return " ".join(inspect.cleandoc(cls.__doc__).rsplit("\n\n", 1)[0].split())


def _section(cls, paths):
    hints = get_type_hints(cls)
    head = ", ".join(path if path == "top level" else f"`{path}`" for path in paths)
    lines = [f"## {head}", "", f"{about(cls)} In Python: `hybrid.{cls.__name__}`.", "",
             "| key | type | unit | default | range | meaning |", "|---|---|---|---|---|---|"]
    for f in fields(cls):
        key = described(f)
        row = (f"`{file_name(f)}`", _words(hints[f.name]), key.unit, _default(cls, f), str(key.range), key.meaning)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |")
    if cls is Material:
        lines += ["", "Values that each law needs where `relative_density` does not give them, and all that it uses, "
                      "apart from `density`:", "",
                  "| law | needs | uses |", "|---|---|---|"]
        lines += [f"| `{law}` | {_needs(law)} | {', '.join(f'`{name}`' for name in names) or '–'} |"
                  for law, names in USES.items()]
    return "\n".join([*lines, ""])


def _needs(law):
    elastic = [] if law == "user" else ["`young`, or `reference_young` and `stiffness_exponent`"]
    return "; ".join([", ".join(f"`{name}`" for name in NEEDS[law]), *elastic])


def _default(cls, f):
    if required_in_file(f):
        return "*required*"
    if (cls, f.name) in RULES:
        return "*decided*"
    if f.default in (MISSING, None, ()):
        return "–"
    if is_dataclass(f.default):
        return "its defaults"
    return f'`"{f.default}"`' if isinstance(f.default, str) else f"`{shown(f.default)}`"


def _words(hint, plural=False):
    """Type of a key's values for the page."""
    kind, items = get_origin(hint) or hint, [item for item in get_args(hint) if item is not NoneType]
    if kind is Literal:
        return ("any of " if plural else "") + ", ".join(f"`{item}`" for item in items)
    if kind is tuple:
        lists = "lists of " if plural else ""
        return f"{lists}{'' if items[-1] is Ellipsis else f'{len(items)} '}{_words(items[0], plural=True)}"
    if is_dataclass(kind):
        return "tables" if plural else "table"
    if kind is dict:
        return "table of numbers"
    if items:
        return " or ".join(_words(item) for item in items)
    one = {float: "number", int: "whole number", bool: "true or false", str: "text", Path: "path"}[kind]
    return one + "s" * plural
