"""Pages made from the record of the benchmarks: current, whole, and the same numbers in README as in the tables."""

import copy
import json
import re
import shutil
from datetime import datetime

import pytest

from hybrid import bench, cli
from hybrid.bench import pages, report
from hybrid.bench.table import SPACE, markdown, number, paragraph
from hybrid.runtime.errors import SceneError

RECORD = json.loads((pages.ROOT / pages.RECORD).read_text(encoding="utf-8"))
SPEED, README = pages.PARTS


def text(name, root=pages.ROOT):
    return (root / name).read_text(encoding="utf-8")


def section(heading):
    """Lines of a section of the page of speed."""
    return text(SPEED).partition(f"## {heading}\n")[2].partition("\n## ")[0].splitlines()


def cells(heading):
    """{first cell: other cells} of the table in a section of the page of speed."""
    rows = [line.strip("| ").split(" | ") for line in section(heading) if line.startswith("| ")]
    return {row[0]: row[1:] for row in rows}


def is_current(name, record, root=pages.ROOT):
    return pages.marked(text(name, root)) == pages.PARTS[name](record)


@pytest.fixture
def checkout(tmp_path):
    """Copy of the record and of the pages."""
    for name in (pages.RECORD, *pages.PARTS):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(pages.ROOT / name, tmp_path / name)
    return tmp_path


# ------------------------------------------------------------------ the pages as they are


@pytest.mark.parametrize("name", pages.PARTS)
def test_page_is_made_from_the_record(name):
    assert is_current(name, RECORD), "run `hybrid bench --page`"


def test_the_record_is_whole_and_stamped():
    assert list(RECORD["cases"]) == list(bench.CASES)
    assert set(report.SECTIONS) == set(bench.CASES)
    assert datetime.fromisoformat(RECORD["stamp"]["date"]).year >= 2026
    page = text(SPEED)
    assert f"Measured on {RECORD['stamp']['date'][:10]} at commit {RECORD['stamp']['commit'][:7]}" in page
    assert f"numpy {RECORD['stamp']['versions']['numpy']}" in page.replace("\n", " ")
    assert all(title in page for title, _ in report.SECTIONS.values())


def test_times_of_readme_stand_in_the_tables():
    words = " ".join(pages.marked(text(README)).split())
    scaling, anchor = cells("Scaling"), cells("Drag anchor, by phase")
    found = re.search(r"step takes (\S+) s with ([\d ]+) and (\S+) s with ([\d ]+) unknowns\.", words).groups()
    sizes = [number(row["unknowns"]).replace(SPACE, " ") for row in RECORD["cases"]["scaling"]["rows"]]
    assert scaling["unknowns"] == sizes
    assert found == (scaling["s a step"][0], sizes[0], scaling["s a step"][-1], sizes[-1])
    steps, total = re.search(r"(\d+) steps of the drag anchor take (\S+) s\.", words).groups()
    assert (steps, total) == (anchor["steps"][-1], anchor["time [s]"][-1])


def test_times_of_the_peer_in_readme_stand_on_the_page():
    table = text(README).partition("## Speed")[2].partition(pages.BEGIN)[0]
    times = re.findall(r"\d\.\d+(?: s)?", table.replace("10.4", ""))
    assert len(times) == 6
    page = " ".join(section("Beside Kratos MPM"))
    assert not [time for time in times if time not in page]


# ------------------------------------------------------------------ a changed record


@pytest.mark.parametrize("case, key", [("scaling", "s a step"), ("anchor", "s")])
def test_a_changed_record_makes_both_pages_outdated_until_they_are_written(checkout, case, key):
    changed = copy.deepcopy(RECORD)
    changed["cases"][case]["rows"][-1][key] *= 1.5
    (checkout / pages.RECORD).write_text(json.dumps(changed))
    before = {name: text(name, checkout) for name in pages.PARTS}
    assert all(is_current(name, RECORD, checkout) and not is_current(name, changed, checkout) for name in pages.PARTS)
    assert pages.write_pages(checkout) == [checkout / name for name in pages.PARTS]
    for name, old in before.items():
        new = text(name, checkout)
        assert is_current(name, changed, checkout) and new != old
        outside = [(page.partition(pages.BEGIN)[0], page.partition(pages.END)[2]) for page in (old, new)]
        assert outside[0] == outside[1]


@pytest.mark.parametrize("case", ["block", "kernels", "sphere", "solvers"])
def test_every_case_is_on_the_page_of_speed(case):
    changed = copy.deepcopy(RECORD)
    row = changed["cases"][case]["rows"][0]
    timed = next(key for key in ("s a step", "ms", "ms a step", "solve [s]") if key in row)
    for row in changed["cases"][case]["rows"]:
        row[timed] *= 1.5
    assert not is_current(SPEED, changed)


def test_runs_of_a_peer_and_failures_are_shown():
    changed = copy.deepcopy(RECORD)
    own = [row for row in changed["cases"]["block"]["rows"] if row["program"] == "hybrid"]
    changed["cases"]["block"]["rows"] = [*own, {**own[0], "program": "kratos 10.4.4", "Krylov": None, "s a step": 1.25}]
    changed["cases"]["solvers"]["rows"][0]["failed"] = "no convergence"
    made = report.tables(changed)
    assert "\n| kratos 10.4.4 | 1.2 |" in made and " | failed |\n" in made and " | no convergence |\n" in made
    assert " | failed |\n" not in report.tables(RECORD) or any(r["failed"] for r in RECORD["cases"]["solvers"]["rows"])


def test_a_record_of_one_case_has_one_section():
    alone = {"stamp": {**RECORD["stamp"], "commit": "0123456789+", "quick": True},
             "cases": {"sphere": RECORD["cases"]["sphere"]}}
    made = report.tables(alone)
    assert re.findall("^## .*$", made, re.MULTILINE) == ["## Rolling sphere"]
    for words in (made, report.summary(alone)):
        assert "at commit 0123456 with changes, the smallest size of each case (`--quick`)" in " ".join(words.split())


# ------------------------------------------------------------------ command and text


def test_the_command_writes_the_pages_and_measures_nothing(monkeypatch, checkout, capsys):
    write = pages.write_pages
    monkeypatch.setattr(pages, "write_pages", lambda: write(checkout))
    monkeypatch.setattr(bench, "run", None)
    assert cli.main(["bench", "--page"]) == 0
    assert f"written to {checkout / SPEED}" in capsys.readouterr().out


@pytest.mark.parametrize("more", [["sphere"], ["--quick"], ["--out", "record.json"], ["--peer", "python"]])
def test_page_is_given_alone(more, capsys):
    assert cli.main(["bench", "--page", *more]) == 2
    assert "--page: measures nothing; give it alone" in capsys.readouterr().err


def test_without_a_record_the_command_to_measure_is_named(tmp_path):
    with pytest.raises(SceneError, match=r"bench\.json.*`hybrid bench --out demos/speed/bench\.json`"):
        pages.write_pages(tmp_path)


@pytest.mark.parametrize("change", [lambda page: page.replace(pages.END, ""), lambda page: page + pages.BEGIN,
                                    lambda page: pages.END + page.replace(pages.END, "")])
def test_a_page_without_its_marks_is_an_error_and_stays_as_it_is(checkout, change):
    spoilt = change(text(README, checkout))
    (checkout / README).write_text(spoilt, encoding="utf-8")
    with pytest.raises(SceneError, match="README.md: must have the lines <!-- bench: begin --> and"):
        pages.write_pages(checkout)
    assert text(README, checkout) == spoilt and text(SPEED, checkout) == text(SPEED)


@pytest.mark.parametrize("value, words", [
    (None, "–"), ("a text", "a text"), (0, "0"), (1_234_567, "1\u00a0234\u00a0567"), (0.3349, "0.33"), (8.26, "8.3"),
    (99.7, "100"), (53.4, "53"), (1234.0, "1\u00a0200"), (1e-6, "1e-06"), (-0.325, "-0.33"), (0.0, "0")])
def test_numbers_of_a_page(value, words):
    assert number(value) == words


def test_table_and_paragraph_of_a_page():
    assert markdown(["n", 1000], [["a", 0.25]]) == "| n | 1 000 |\n|---|---|\n| a | 0.25 |\n"
    lines = paragraph(f"{'word ' * 23}{number(123_456)} s").splitlines()     # the number is not split
    assert len(lines) == 2 and lines[1] == "123 456 s"
