"""The same scene in other units of length, time and mass: every key is scaled by its unit in the schema."""

from dataclasses import fields, is_dataclass, replace

from hybrid.scene.table import described

# Powers of length, time and mass in a unit
POWERS = {"m": (1, 0, 0), "s": (0, 1, 0), "kg/m³": (-3, 0, 1), "Pa": (-1, -2, 1), "Pa/m": (-2, -2, 1), "m/s": (1, -1, 0),
          "m/s²": (1, -2, 0), "rad/s": (0, -1, 0), "N": (1, -2, 1), "N m": (2, -2, 1), "N/m": (0, -2, 1), "1/m": (-1, 0, 0)}


def factor(unit, units):
    """What a number with this unit is multiplied by; units: those of length, time and mass. 1 for what has none."""
    powers = POWERS.get(unit, (0, 0, 0))
    return units[0] ** powers[0] * units[1] ** powers[1] * units[2] ** powers[2]


def similar(table, units):
    """A scene, or a table of it, in other units. Geometries keep theirs: body.scale changes. Scenes with tables of time
    or with values by name (layers, densities) are not covered."""
    found = {}
    for field in fields(table):
        value = getattr(table, field.name)
        unit = "m" if field.name == "scale" else described(field).unit
        if is_dataclass(value):
            found[field.name] = similar(value, units)
        elif isinstance(value, tuple) and value and is_dataclass(value[0]):
            found[field.name] = tuple(similar(one, units) for one in value)
        elif unit in POWERS and value is not None and not isinstance(value, str):
            found[field.name] = _times(value, factor(unit, units))
    return replace(table, **found)


def _times(value, by):
    return tuple(_times(one, by) for one in value) if isinstance(value, tuple) else value * by
