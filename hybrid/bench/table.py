"""Rows of a case as a table of text."""


def table(rows):
    """Text with a line of headings and one for each row (dicts with the same keys), columns aligned."""
    if not rows:
        return "  no rows"
    cells = [list(rows[0])] + [[_text(value) for value in row.values()] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells)]
    left = [isinstance(value, str) for value in rows[0].values()]
    return "\n".join("  " + "  ".join(
        f"{cell:<{width}}" if text else f"{cell:>{width}}" for cell, width, text in zip(line, widths, left)).rstrip()
        for line in cells)


def _text(value):
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
