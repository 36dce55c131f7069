"""Writes a record of the benchmarks into the pages of a checkout: the tables of demos/speed, a paragraph of README.md.

Each page holds its part between two marks. `hybrid bench --page` writes both parts from demos/speed/bench.json.
"""

import json

from hybrid.bench.report import summary, tables
from hybrid.runtime.data import DEMOS
from hybrid.runtime.errors import SceneError

ROOT, RECORD = DEMOS.parent, "demos/speed/bench.json"
PARTS = {"demos/speed/README.md": tables, "README.md": summary}
BEGIN, END = "<!-- bench: begin -->\n", "<!-- bench: end -->\n"


def write_pages(root=ROOT):
    """Write the marked parts of the pages below `root` from its record; returns the paths of the pages.

    Raises SceneError for a missing or unreadable record or page, or a page without its marks; then no page is changed.
    """
    try:
        record = json.loads((root / RECORD).read_text(encoding="utf-8"))
        pages = {root / name: replaced((root / name).read_text(encoding="utf-8"), name, part(record))
                 for name, part in PARTS.items()}
        for path, text in pages.items():
            path.write_text(text, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise SceneError(f"--page: {error}; record and pages are those of a checkout, and "
                         f"`hybrid bench --out {RECORD}` there writes the record") from None
    return list(pages)


def marked(page):
    """Text of a page between the marks; None unless it has each mark once, in this order."""
    part = page.partition(BEGIN)[2].partition(END)[0]
    return part if page.count(BEGIN) == page.count(END) == page.count(BEGIN + part + END) == 1 else None


def replaced(page, name, part):
    """The page with `part` between its marks. Raises SceneError with its `name` if it lacks them."""
    if marked(page) is None:
        raise SceneError(f"{name}: must have the lines {BEGIN.strip()} and {END.strip()} once each, in this order")
    return page.partition(BEGIN)[0] + BEGIN + part + END + page.partition(END)[2]
