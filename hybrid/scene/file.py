"""Scene files: TOML to Scene, command-line overrides, and the checks every scene passes."""

import tomllib
from pathlib import Path

from hybrid.runtime.data import shipped_hint
from hybrid.runtime.errors import SceneError
from hybrid.scene import Scene
from hybrid.scene.check import faults
from hybrid.scene.read import Faults, build_table, clipped, did_you_mean

LONGEST = 16 * 2**20    # bytes of a scene file


def load_scene(path, overrides=()):
    """Scene of the TOML file at `path`, with `overrides` such as "body.anchor.friction=0.3" applied in order.

    The scene is named after the file unless it gives a name. Raises SceneError naming the file.
    """
    path = Path(path)
    try:
        tables = _tables(path)
        for override in [overrides] if isinstance(overrides, str) else overrides:
            apply_override(tables, override)
        tables.setdefault("name", path.stem)
        return scene_from_dict(tables, path.parent)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from None


def scene_from_dict(tables, base_dir="."):
    """Checked Scene of nested dicts as a TOML reader gives them; paths are relative to `base_dir`."""
    return _checked(build_table(Scene, tables, "", Path(base_dir)))


def validate(scene):
    """The scene with every value in its declared type (arrays become tuples, paths absolute).

    Raises SceneError with *all* values out of range, each with its limit and a remedy.
    """
    if not isinstance(scene, Scene):
        raise SceneError(f"expected a Scene, got {type(scene).__name__}; read a file with load_scene(path)")
    return _checked(build_table(Scene, scene, "", Path()))


def _checked(scene):
    found = list(dict.fromkeys(faults(scene)))      # a fault of the scheme is one of each part that needs another
    if found:
        raise Faults(found)
    return scene


def _tables(path):
    """Raw tables of a TOML file."""
    try:
        if path.exists() and not path.is_file():
            raise SceneError("must be a file, but is a directory or a device")
        if path.is_file() and path.stat().st_size > LONGEST:
            raise SceneError(f"has {path.stat().st_size} bytes, limit {LONGEST}: this is no scene file")
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise SceneError("no such scene file" + (_similar_file(path) or shipped_hint(path))) from None
    except UnicodeDecodeError as error:
        raise SceneError(f"not a UTF-8 text file ({error.reason} at byte {error.start})") from None
    except (OSError, RuntimeError, ValueError) as error:
        raise SceneError(f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        # A value cut short by the end of the file is reported by tomllib without its line.
        last = f"at end of document, line {len(text.splitlines())}"
        reason = str(error).replace("at end of document", last)
        raise SceneError(f"not valid TOML: {reason}") from None
    except (RecursionError, ValueError) as error:
        raise SceneError(f"not valid TOML: {_unreadable(error)}") from None


def _unreadable(error):
    """What is wrong with text that the reader of TOML gives up on."""
    if isinstance(error, RecursionError):
        return "lists or tables lie in one another too deeply; a scene needs four levels"
    return f"a number, a date or a name cannot be read ({str(error).split(';')[0]})"


def _similar_file(path):
    """A hint at the scene file in the same folder whose name is nearest."""
    return did_you_mean(path.name, [other.name for other in path.parent.glob("*.toml") if other.name != "pyproject.toml"])


# ------------------------------------------------------------------ overrides


def apply_override(tables, override):
    """Set one value, "a.b.c=value", in nested dicts and lists; its number or its name picks an item of a list.

    The value is read as TOML and, where that fails, taken as text. Missing tables are made.
    """
    path, equals, text = override.partition("=")
    names = [name.strip() for name in path.split(".")]
    if not equals or not all(names):
        raise SceneError(f"override {clipped(override)}: expected key.path=value, for example time.step=0.02")
    place = tables
    for depth, name in enumerate(names[:-1]):
        index = _index(place, override, names, depth)
        if index is None:  # a bare [body] is item 0 of its own list
            continue
        if isinstance(place, dict):
            place.setdefault(index, {})
        place = place[index]
    place[_index(place, override, names, len(names) - 1)] = toml_value(text)


def _index(place, override, names, depth):
    """Key or index in `place` that names[depth] selects; None where it selects `place` itself."""
    name, above, below = names[depth], names[:depth], names[depth + 1:]
    path = ".".join(above)
    if isinstance(place, dict):
        single = above in (["body"], ["stage"]) and name not in place and below
        return None if single and name in ("0", _label(place, above)) else name
    if not isinstance(place, list):
        raise SceneError(f"override {clipped(override)}: {path} = {clipped(place)} is a value and has no {name!r} in "
                         "it")
    if name.isdecimal():
        if len(name) > 9 or int(name) >= len(place):
            raise SceneError(f"override {clipped(override)}: {path} has {len(place)} in it, counted from 0")
        return int(name)
    labels = [_label(item, above) for item in place]
    if name in labels:
        return labels.index(name)
    key = ".".join(below or [name])     # body.anchr.friction misspells an item, body.friction leaves it out
    choices = " or ".join(f"{path}.{label}.{key}" for label in ["0", *filter(None, labels[:1])])
    raise SceneError(f"override {clipped(override)}: {path} is a list of {len(place)} and has no item {name!r}"
                     f"{did_you_mean(name, list(filter(None, labels)))}; write {choices}")


def _label(item, above):
    """Name of an item of the list `above`, such as that of a [[body]]; None without one."""
    return item.get("name", "body" if above == ["body"] else None) if isinstance(item, dict) else None


def toml_value(text):
    """`text` as a TOML value, or itself where it is not one."""
    try:
        read = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text.strip()
    except (RecursionError, ValueError) as error:
        raise SceneError(f"value {clipped(text)}: {_unreadable(error)}") from None
    return read["value"] if len(read) == 1 else text.strip()
