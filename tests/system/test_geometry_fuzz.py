"""Shipped geometries with hostile statements and damage at random places: a mesh or a reason, and nothing else happens.

Once as they are checked and meshed, once meshed without the check, so that the confined process alone has to hold.
"""

import random
import re
import time
from pathlib import Path

import pytest
from hostile import CASES, LOOPS, geometry

from hybrid.body import geometry_text, mesh
from hybrid.runtime import sandbox
from hybrid.runtime.errors import GeometryError

GEOMETRY = Path(__file__).parents[2] / "geometry"
SHAPES = ["box", "sphere", "cylinder", "cone", "notched_block"]
QUICK, SLOW = range(1000, 1004), range(300)    # seeds
STATEMENTS = [text for command, text in CASES if command != "Sleep"] + [LOOPS["recursion"]]
FRAMES = ["{}", "If (0)\n{}\nEndIf", "If (1) {} EndIf", "For i In {{1:2}} /*\n{} */\nEndFor", "// {}", "/* {} */",
          "Macro act\n{}\nReturn\nCall act;", "s = '{}';", 'If (0)\n E" EndIf {} "; EndIf\n', "// \r{}", "x=1;{}"]
JUNK = ['"', "'", "/*", "*/", "//", "\0", "\xff", "\r", "EndIf", "EndFor", "Return\n", "Else", "{", ";", "If (0)\n", "~{1}"]
NUMBERS = ["0", "-1", "1e-9", "1e300", "1e15", "5e-3", "nan"]
ATTEMPTED = r"/bin/sh|[Uu]nable to open|[Cc]ould not open|Unknown file type|socket"


def mutated(text, rng):
    """The text with one hostile statement in some frame, and up to three other changes."""
    framed = rng.choice(FRAMES).replace("{}", rng.choice(STATEMENTS)).replace("{{", "{").replace("}}", "}")
    lines = text.splitlines(keepends=True)
    lines.insert(rng.randrange(len(lines) + 1), framed + rng.choice(["\n", "", "\r", " "]))
    text = "".join(lines)
    for _ in range(rng.randrange(4)):
        start = rng.randrange(len(text))
        match rng.randrange(4):
            case 0:
                text = text[:start] + rng.choice(JUNK) + text[start:]
            case 1:
                text = text[:start] + text[start + rng.randrange(1, 20) :]
            case 2:
                text = text[:start] + rng.choice(STATEMENTS) + text[start:]
            case 3:
                number = rng.choice(list(re.finditer(r"[0-9.]+", text)))
                text = text[: number.start()] + rng.choice(NUMBERS) + text[number.end() :]
    return text


def seeds(quick, slow):
    return [*quick, *(pytest.param(seed, marks=pytest.mark.slow) for seed in slow)]


@pytest.mark.parametrize("checked", [True, False], ids=["checked", "unchecked"])
@pytest.mark.parametrize("seed", seeds(QUICK, SLOW))
def test_a_mutated_geometry_gives_a_mesh_or_a_reason_and_does_nothing_else(tmp_path, monkeypatch, seed, checked):
    if not checked and "seccomp" not in sandbox.offered():
        pytest.skip("this system cannot confine a process")
    rng = random.Random(seed)
    (tmp_path / "away").mkdir()
    path = tmp_path / "body.geo"
    text = mutated((GEOMETRY / f"{rng.choice(SHAPES)}.geo").read_text(), rng)
    path.write_text(text.replace("{mark}", str(tmp_path / "away" / "mark")), encoding="latin-1", newline="")
    monkeypatch.setattr(mesh, "SECONDS", 2)
    if not checked:
        monkeypatch.setattr(geometry_text, "screened", lambda text, path: (text, []))
    began = time.monotonic()
    try:
        assert len(mesh.generate(path).tets)
    except GeometryError as error:
        assert str(error).startswith("geometry ") and len(str(error)) < 2000
        assert not (checked and re.search(ATTEMPTED, str(error))), f"the check has let pass what it should not: {error}"
    assert time.monotonic() - began < 60.0
    assert not list((tmp_path / "away").iterdir()) and [p.name for p in tmp_path.iterdir() if p.is_file()] == ["body.geo"]


@pytest.mark.slow
@pytest.mark.skipif("seccomp" not in sandbox.offered(), reason="this system cannot confine a process")
@pytest.mark.parametrize("command, text", CASES)
def test_the_process_alone_holds_against_every_hostile_statement(tmp_path, monkeypatch, command, text):
    monkeypatch.setattr(geometry_text, "screened", lambda text, path: (text, []))
    monkeypatch.setattr(mesh, "SECONDS", 2)
    (tmp_path / "away").mkdir()
    path = geometry(tmp_path / "body.geo", text, tmp_path / "away" / "mark")
    try:
        mesh.generate(path)
    except GeometryError as error:
        assert "gmsh" in str(error) or command == "Sleep"
    assert not list((tmp_path / "away").iterdir())
