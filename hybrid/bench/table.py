"""Rows of a case as a table of text; numbers, tables and paragraphs of a page in Markdown."""

from textwrap import fill

SPACE = "\u00a0"     # between groups of digits, so that no line is broken there


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


def markdown(head, rows):
    """Table of a page: a line of headings, and one for each row, a list of values."""
    lines = [map(number, head), ["---"] * len(head), *(map(number, row) for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines).replace("| --- ", "|---").replace(SPACE, " ")


def number(value):
    """Text of a value on a page: counts in groups of three digits, other numbers with two significant digits."""
    if value is None or isinstance(value, str):
        return "–" if value is None else value
    rounded = value if isinstance(value, int) else float(f"{value:.2g}")
    return f"{rounded:,.0f}".replace(",", SPACE) if abs(rounded) >= 10 else f"{rounded:g}"


def paragraph(text):
    """Text in lines of at most 120 characters."""
    return fill(text, 120, break_on_hyphens=False, break_long_words=False).replace(SPACE, " ") + "\n"
