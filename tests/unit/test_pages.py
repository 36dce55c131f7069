"""Pages: links, pictures and cited equation numbers exist, README is short and shows the files it names.

Shape of README by its own rule: one minute to know what it is, five to a result, ten to one's own geometry.
"""

import re
import struct
import subprocess
import tomllib
from pathlib import Path

import pytest

from hybrid.arguments import parser
from hybrid.body.mesh import generate
from hybrid.scene.body import Body
from hybrid.scene.file import load_scene
from hybrid.scene.read import build_table

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = [README, ROOT / "hybrid/FORMULATION.md", ROOT / "hybrid/DESIGN.md", *sorted((ROOT / "demos").rglob("*.md"))]
LINES, ALL, ANIMATION = 150, 1_000_000, 1_000_000        # of README; bytes of the gallery's pictures, of its animation
FIGURE, DRAWING = 150_000, 60_000   # bytes of a picture of the gallery wide enough to be read, and of any other one


def text(path):
    return path.read_text(encoding="utf-8")


def blocks(path, kind):
    """Contents of the fenced blocks of a kind."""
    return re.findall(rf"^```{kind}\n(.*?)^```$", text(path), re.MULTILINE | re.DOTALL)


def anchors(path):
    """Names by which headings of a page can be linked to."""
    headings = re.findall(r"^#+ (.*)$", text(path), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_and_pictures_of_a_page_exist(page):
    prose = re.sub(r"```.*?```", "", text(page), flags=re.DOTALL)
    missing = []
    for link in re.findall(r"\]\(([^)\s]+)\)", prose):
        if re.match(r"[a-z]+:", link):
            continue
        name, _, anchor = link.partition("#")
        target = (page.parent / name).resolve() if name else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            missing.append(link)
    assert not missing


def git(*command):
    """Output of a git command in this folder, None where it fails or there is no git."""
    try:
        done = subprocess.run(["git", "-C", ROOT, *command], capture_output=True, text=True)
    except FileNotFoundError:
        return None
    return None if done.returncode else done.stdout.strip()


def test_commits_that_pages_name_exist():
    if git("rev-parse", "--is-shallow-repository") != "false":
        pytest.skip("without the history")
    words = {word for page in PAGES for word in re.findall(r"(?<![\w.#-])([0-9a-f]{7,8})(?![\w-])", text(page))}
    commits = [word for word in words if re.search("[a-f]", word) and re.search("[0-9]", word)]
    assert len(commits) > 10 and not [one for one in commits if git("cat-file", "-e", one + "^{commit}") is None]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_that_a_page_names_exist(page):
    """Scenes, scripts, tests and geometries by their path from the root."""
    names = set(re.findall(r"\b((?:demos|tests|geometry|hybrid)/[\w./-]+\.(?:toml|py|geo|md|json))\b", text(page)))
    assert not [name for name in names if not (ROOT / name).exists()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_that_a_page_names_exist(page):
    """`./run COMMAND` and `hybrid COMMAND`, but scenes and `./run test`, which the script `run` knows."""
    commands = next(action.choices for action in parser()._actions if action.choices)
    named = re.findall(r"(?:\./run|`hybrid|^ +hybrid) ([a-z]+)(?![\w./])", text(page), re.MULTILINE)
    assert not set(named) - set(commands) - {"test"}


def test_readme_is_short():
    assert len(text(README).splitlines()) <= LINES


def test_readme_shows_its_first_scene_as_it_is():
    assert blocks(README, "toml") == [text(ROOT / "demos/first.toml")]


def test_python_of_readme_names_what_there_is():
    import hybrid

    (program,) = blocks(README, "python")
    compile(program, "README.md", "exec")
    assert all(hasattr(hybrid, name) for name in re.findall(r"hybrid\.(\w+)", program))


def test_gallery_has_every_story():
    gallery = text(ROOT / "demos/README.md")
    stories = [path.name for kind in ("*.toml", "*.py") for path in (ROOT / "demos").glob(kind)]
    assert not [name for name in stories if f"({name})" not in gallery]


def test_pictures_of_the_gallery_are_small():
    pictures = list((ROOT / "demos/gallery").glob("*.png"))
    for path in pictures:
        wide = struct.unpack(">I", path.read_bytes()[16:20])[0] > 480
        assert path.stat().st_size <= (FIGURE if wide else DRAWING), path.name
    assert sum(path.stat().st_size for path in pictures) <= ALL
    assert all(path.stat().st_size <= ANIMATION for path in (ROOT / "demos/gallery").glob("*.gif"))


def test_script_of_the_pictures_uses_what_there_is():
    from hybrid.output import picture_worker

    script = text(ROOT / "demos/gallery/draw.py")
    assert all(hasattr(picture_worker, name) for name in re.findall(r"\bworker\.(\w+)", script))


def test_geometry_and_scene_of_the_how_to_are_right(tmp_path):
    page = ROOT / "demos/own-geometry.md"
    (geometry,), (drawing, scene) = blocks(page, "geo"), blocks(page, "toml")
    (tmp_path / "wedge.geo").write_text(geometry, encoding="utf-8")
    (tmp_path / "wedge.toml").write_text(scene, encoding="utf-8")
    (body,) = load_scene(tmp_path / "wedge.toml").bodies
    mesh = generate(body.geometry, {"width": 0.5})
    assert len(mesh.contact) and len(mesh.symmetry) and set(mesh.named_points) == {"eye"}
    (table,) = tomllib.loads(drawing)["body"]
    assert build_table(Body, table, "body", tmp_path).density == {"shank": 7850.0, "fluke": 7200.0}


def test_equations_are_numbered_in_order_and_cited_numbers_exist():
    formulation = text(ROOT / "hybrid/FORMULATION.md")
    numbers = [int(n) for n in re.findall(r"^ {4}\((\d+)\) ", formulation, re.MULTILINE)]
    assert numbers == list(range(1, len(numbers) + 1))
    wrong = []
    for path in [*(ROOT / "hybrid").rglob("*.py"), *(ROOT / "tests").rglob("*.py"), *PAGES]:
        for cited in re.findall(r"FORMULATION ((?:\(\d+\)(?:, | and | to )?)+)", text(path)):
            wrong += [f"{path.name} ({n})" for n in re.findall(r"\d+", cited) if int(n) not in numbers]
    assert not wrong
