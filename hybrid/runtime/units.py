"""Forces as texts, with a suitable unit."""

UNITS = ((1e6, "M"), (1e3, "k"), (1.0, ""))     # prefixes


def prefix(largest):
    """(units in a unit with a prefix, the prefix) for values up to `largest`."""
    return next((pair for pair in UNITS if abs(largest) >= pair[0]), UNITS[-1])


def force_unit(largest):
    """(newtons in a unit, its name) for forces up to `largest` [N]."""
    scale, letter = prefix(largest)
    return scale, f"{letter}N"


def force(newtons, unit="N"):
    """A force, or a value in another unit such as "N m", with a prefix, such as "12.3 kN"."""
    scale, letter = prefix(newtons)
    return f"{newtons / scale:.3g} {letter}{unit}"
