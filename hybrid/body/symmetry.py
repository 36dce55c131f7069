"""Planes of symmetry: the halves of a body that they cut, and what the whole has of what is modelled.

A body in n planes of symmetry (n = 1: half a model, 2: a quarter) is one of 2^n mirror images. The whole has 2^n times the
mass, energy and work. Of forces the components along the normals cancel, of moments all but that about the normal, and
both with two planes; the others are 2^n times those of the part.
"""

import re
from dataclasses import dataclass

import numpy as np

from hybrid.runtime.errors import GeometryError

AXES = {"x": 0, "y": 1}     # of the normals of planes of symmetry
VECTOR = re.compile(r"(?:.*_)?([fm])([xyz])_Nm?")
# Of the volume, and of its moments beside those of its own size: halves that differ by more are no mirror images. Coarse
# meshes of round bodies differ by up to 0.4 and 4 % (a ball of 16 edges around); a bar turned by 5° by 39 % in a moment
UNEQUAL, UNLIKE = 0.01, 0.08


def check_halves(whole, kept, axis, what):
    """GeometryError unless the part of a body that lies at `axis` > 0 is the mirror image of the other part, or all of it.

    whole, kept: (4, 4) moments ∫ X Xᵀ dV of the body and of that part, with X = (1, x, y, z) [m].
    """
    volume, part, side = whole[0, 0], kept[0, 0], 1 + AXES[axis]
    if part <= 0.0:
        raise GeometryError(f"{what}: nothing of it lies at {axis} > 0, which symmetry = '{axis}' keeps; mirror the "
                            f"drawing, or move its plane of symmetry to {axis} = 0")
    if part >= (1.0 - 1e-9) * volume:
        return
    where = f"{what} is not symmetric about {axis} = 0"
    remedy = f"move the plane of symmetry of the drawing to {axis} = 0, or leave symmetry = '{axis}' out"
    if abs(2.0 * part - volume) > UNEQUAL * volume:
        raise GeometryError(f"{where}: {part:.4g} m³ lie at {axis} > 0 and {volume - part:.4g} m³ at {axis} < 0; {remedy}")
    mirror = np.where(np.arange(4) == side, -1.0, 1.0)
    other = mirror[:, None] * (whole - kept) * mirror
    size = np.sqrt(np.diag(kept))
    unlike = np.abs(kept - other) / np.outer(size, size)
    if unlike.max() > UNLIKE:
        i, j = np.unravel_index(unlike.argmax(), unlike.shape)
        moment = "∫ " + " ".join(("", "x", "y", "z")[n] for n in (i, j) if n) + " dV"
        raise GeometryError(f"{where}: both halves have the same volume, but {moment} is {kept[i, j]:.4g} of the one at "
                            f"{axis} > 0, and {other[i, j]:.4g} of the mirror image of the other one; {remedy}")


@dataclass(frozen=True)
class Mirror:
    """A plane of symmetry of the model: axis "x" or "y", its coordinate `at` [m], and whether the body ends there (cut), or
    lies across it as a whole."""

    axis: str
    at: float
    cut: bool

    def __str__(self):
        return f"{self.axis} = {self.at:g} m"


def copies(mirrors):
    """How many times what is modelled the whole is."""
    return 2 ** len(mirrors)


def part_of_whole(mirrors):
    """Text such as "x = 0 m: half of the whole is modelled"; "" without planes of symmetry."""
    part = {1: "half", 2: "a quarter"}.get(len(mirrors), "a part")
    return f"{' and '.join(map(str, mirrors))}: {part} of the whole is modelled" if mirrors else ""


def whole_columns(columns, mirrors):
    """Columns {name: value} of a body, each of force, moment, energy or work with that of the whole after it."""
    out = {}
    for name, value in columns.items():
        out[name] = value
        quantity, _, unit = name.rpartition("_")
        if mirrors and unit in ("N", "Nm", "J"):
            times = _share(name, [mirror.axis for mirror in mirrors])
            out[f"{quantity}_whole_{unit}"] = times * value if times else 0.0
    return out


def _share(name, axes):
    """Whole over modelled of a column, for planes normal to `axes`."""
    found = VECTOR.fullmatch(name)
    if found:
        kind, along = found.groups()
        if kind == "f" and along in axes or kind == "m" and any(axis != along for axis in axes):
            return 0
    return copies(axes)
