"""How a table of a scene file is declared: `table` makes a frozen dataclass of a class, `key` declares one of its keys.

    @table
    class Pull:
        "An elastic line."

        stiffness: float = key("of the line", "N/m", above=0, remedy="in N/m, for example 1e6")

The declaration is the only home of a key's type, unit, default, range and meaning. From it come the reading of files
(`hybrid.scene.read`), the check of ranges (`range_faults`), the JSON schema and the page demos/scene-reference.md
(`hybrid.scene.reference`), and the list of keys in the docstring of the class. The classes check nothing but names when
they are made, so scenes are cheap to build and change in Python; `hybrid.validate` and `hybrid.build` check the whole.
"""

import textwrap
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from difflib import get_close_matches
from functools import wraps
from typing import dataclass_transform

from hybrid.runtime.errors import SceneError

NAME = 80       # characters of a name that are looked at for the nearest one
TINY = 1e-30    # smallest number that is above zero: products and ratios of such numbers stay finite


@dataclass(frozen=True)
class Range:
    """Interval of numbers; an end that is None is open. above, below: without the end; at_least, at_most: with it."""

    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None

    def __bool__(self):
        return any(end is not None for end in (self.above, self.at_least, self.below, self.at_most))

    def __contains__(self, value):
        return not (self.above is not None and not value >= self.above + TINY
                    or self.above is not None and not value > self.above
                    or self.at_least is not None and not value >= self.at_least
                    or self.below is not None and not value < self.below
                    or self.at_most is not None and not value <= self.at_most)

    def __str__(self):
        low = "" if self.above is self.at_least is None else (
            f"above {self.above:g}" if self.above is not None else f"at least {self.at_least:g}")
        high = "" if self.below is self.at_most is None else (
            f"below {self.below:g}" if self.below is not None else f"at most {self.at_most:g}")
        if low.startswith("at least") and high:
            return f"from {self.at_least:g} to " + (high if self.below is not None else f"{self.at_most:g}")
        return "positive" if low == "above 0" and not high else " and ".join(filter(None, (low, high)))


@dataclass(frozen=True)
class Key:
    """Declaration of a key.

    meaning       one sentence without the name of the key
    unit          SI unit, "-" for a ratio, "" where there is none
    range         of the value, or of each number in a list
    remedy        end of the message about a value out of range
    name          in a scene file, where it is not that of the field
    also          other words for it, in small letters: a scene file with one of them is refused with the key's name
    words         the same for values that are words: {other word: value}
    in_file       False: may be left out of a file although the class requires it
    """

    meaning: str
    unit: str = ""
    range: Range = Range()
    remedy: str = ""
    name: str | None = None
    also: tuple[str, ...] = ()
    words: dict[str, str] = field(default_factory=dict)
    in_file: bool = True


def key(meaning, unit="", *, default=MISSING, default_factory=MISSING, above=None, at_least=None, below=None,
        at_most=None, remedy="", name=None, also=(), words=None, in_file=True):
    """Dataclass field that a Key declares."""
    described = Key(meaning, unit, Range(above, at_least, below, at_most), remedy, name, also, words or {}, in_file)
    assert bool(described.range) == bool(remedy), f"{meaning}: a range needs a remedy and a remedy a range"
    return field(default=default, default_factory=default_factory, metadata={"key": described})


@dataclass_transform(frozen_default=True, field_specifiers=(key,))
def table(cls=None, *, kw_only=False):
    """Frozen dataclass of a class whose fields are made by `key`; its docstring lists them."""
    if cls is None:
        return lambda cls: table(cls, kw_only=kw_only)
    cls = dataclass(frozen=True, kw_only=kw_only)(cls)
    cls.__init__ = _refusing_unknown(cls, cls.__init__)
    if cls.__doc__:     # None under python -OO
        cls.__doc__ = cls.__doc__.rstrip() + "\n\n" + "\n".join(_line(f) for f in fields(cls))
    return cls


def _refusing_unknown(cls, init):
    """`init` of a table, with a SceneError for an argument that it does not have, such as `motion` of a Stage."""
    @wraps(init)
    def checked(self, *args, **given):
        names = {f.name: (file_name(f), *described(f).also) for f in fields(cls)}
        for name in given.keys() - names.keys():
            meant = next((own for own, others in names.items() if name.lower() in others), None)
            hint = f" (did you mean {meant!r}?)" if meant else did_you_mean(name, names)
            raise SceneError(f"{cls.__name__}({name}=...): unknown argument{hint}; valid: {', '.join(names)}")
        init(self, *args, **given)
    return checked


def did_you_mean(name, choices):
    """A hint at the nearest of some names, or nothing."""
    near = get_close_matches(str(name)[:NAME].lower(), list(choices), 1, 0.5)
    return f" (did you mean {near[0]!r}?)" if near else ""


def _line(f):
    unit = f"[{described(f).unit}] " if described(f).unit else ""
    return textwrap.fill(unit + described(f).meaning, 118, initial_indent=f"    {f.name:<23} ",
                         subsequent_indent=" " * 28)


def described(f):
    """Key of a dataclass field."""
    return f.metadata["key"]


def file_name(f):
    """Name of a dataclass field in a scene file."""
    return described(f).name or f.name


def required_in_file(f):
    return f.default is MISSING and f.default_factory is MISSING and described(f).in_file


# ------------------------------------------------------------------ ranges


def range_faults(value, path=""):
    """Texts of all numbers out of the range that their keys declare, in a table and the tables in it."""
    for f in fields(value):
        item, name = getattr(value, f.name), f"{path}.{file_name(f)}".lstrip(".")
        if is_dataclass(item):
            yield from range_faults(item, name)
        elif isinstance(item, tuple) and item and is_dataclass(item[0]):
            for i, own in enumerate(item):
                yield from range_faults(own, f"{name}.{i}")
        elif item is not None and not isinstance(item, str) and described(f).range:
            yield from range_fault(item, described(f), name)


def range_fault(value, declared, path):
    """Nothing where `value`, or each number of it, lies in the range of a Key, else the one fault."""
    numbers = value if isinstance(value, tuple) else tuple(value.values()) if isinstance(value, dict) else (value,)
    limit = str(declared.range)
    if declared.range.above == 0 and any(0 < number < TINY for number in numbers):
        limit = f"at least {TINY:g}"
    if declared.unit not in ("", "-"):
        limit += f", in {declared.unit}" if limit == "positive" else f" {declared.unit}"
    limit += " each" * isinstance(value, (tuple, dict))
    return need(all(number in declared.range for number in numbers), path, value, limit, declared.remedy)


def need(ok, path, value, limit, remedy):
    """Nothing when `ok`, else the one fault, with the key's path, its value, the limit and the remedy."""
    return [] if ok else [f"{path} = {shown(value)}: must be {limit}; {remedy}"]


def shown(value):
    """Text of a value as a scene file has it, strings without quotes."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {shown(item)}" for name, item in list(value.items())[:12]) + " }"
    if isinstance(value, (tuple, list)):
        if len(value) > 12:
            return f"[{', '.join(map(shown, value[:3]))}, ... {len(value)} values]"
        return "[" + ", ".join(map(shown, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.10g}" if isinstance(value, float) else str(value)
