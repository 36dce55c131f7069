"""A geometry from a stranger runs nothing, writes nothing, reads only what lies beside it, and comes to an end."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hostile import BOX, CASES, LOOPS, STATEMENTS, geometry

from hybrid import cli
from hybrid.body import geometry_text, mesh, mesh_worker
from hybrid.runtime import sandbox
from hybrid.runtime.errors import GeometryError

QUICK = [(command, texts[0]) for command, texts in STATEMENTS.items()]    # each is meshed; tests/system has them all
ROOT = Path(__file__).parents[2]
confined = pytest.mark.skipif("seccomp" not in sandbox.offered(), reason="this system cannot confine a process")


@pytest.fixture
def mark(tmp_path):
    """A file that a geometry must not make, nor one that begins with its name."""
    (tmp_path / "away").mkdir()
    yield tmp_path / "away" / "mark"
    assert not list((tmp_path / "away").iterdir())


@pytest.fixture
def unread(monkeypatch):
    """Geometries go to gmsh as they are, so that the process alone has to hold."""
    monkeypatch.setattr(geometry_text, "screened", lambda text, path: (text, []))


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(mesh, "SECONDS", 1)
    monkeypatch.setattr(mesh, "WAITING", 4)


# ---- what the text may not have ----------------------------------------------------------------------------


@pytest.mark.parametrize("command, text", CASES)
def test_a_hostile_statement_is_refused_with_its_line(tmp_path, mark, capsys, command, text):
    path = geometry(tmp_path / "body.geo", text, mark)
    assert cli.main(["mesh", str(path)]) == 2
    message = capsys.readouterr().err
    first = len(BOX.splitlines()) + 1
    assert any(f"body.geo, line {first + k}: " in message for k in range(text.count("\n") + 1)), message
    assert (command in message or "missing.geo" in message) and "; " in message


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_scene_with_a_hostile_geometry_is_refused(tmp_path, mark, capsys, monkeypatch, command):
    geometry(tmp_path / "ball.geo", 'SystemCall "touch {mark}";', mark)
    scene = (ROOT / "demos/first.toml").read_text().replace("../geometry/box.geo", "ball.geo")
    (tmp_path / "a.toml").write_text(scene.replace("parameters = {", "parameters = { size = 0.6 } # {"))
    monkeypatch.chdir(tmp_path)
    assert cli.main([command, "a.toml"]) == 2
    assert "line 8: SystemCall starts another program" in capsys.readouterr().err


def test_a_file_that_is_read_is_checked_too(tmp_path, mark):
    path = geometry(tmp_path / "body.geo", 'Include "part.geo";', mark)
    geometry(tmp_path / "part.geo", 'Merge "more.geo";', mark)
    geometry(tmp_path / "more.geo", 'Exit;', mark)
    with pytest.raises(GeometryError, match=r"more\.geo, line 8: Exit ends gmsh"):
        mesh.generate(path)
    (tmp_path / "more.geo").write_text('Include "body.geo";')
    with pytest.raises(GeometryError, match="reads itself through body.geo, part.geo, more.geo"):
        mesh.generate(path)
    (tmp_path / "more.geo").unlink()
    (tmp_path / "more.geo").symlink_to("/etc/passwd")
    with pytest.raises(GeometryError, match="line 8: reads 'more.geo', a link out of the geometry's folder"):
        mesh.generate(path)


@pytest.mark.parametrize("name, content, reason", [
    ("body.exe", b"x", "'.exe' are not read, only .geo, "), ("body.py", b"x", "not read"),
    ("body.gz", b"x", "not read"),
    ("body.Stl", b'SystemCall "x";', "not read"), ("body.msh", b'SystemCall "x";', "is no mesh of gmsh"),
    ("body.geo", b'// \0 SystemCall "x";', "NUL"), ("body.geo", b'/* SystemCall "x";', "line 1: .* no end"),
    ("body.geo", b's = "', "line 1: .* no end"),
    ("body.geo", b'x = 1;\ns = "a\n";', "line 2: a string of several lines"),
    ("body.geo", b's = "' + 2000 * b"a" + b'";', "more than 1000 characters"),
    ("body.geo", 4_100_000 * b" ", "more than 4 MB of statements, the limit; save the shape as .step"),
    ("body.geo", b"".join(b'Merge "part%d.stl";' % k for k in range(101)), "more than 100 files")])
def test_files_that_gmsh_could_take_for_something_else_are_refused(tmp_path, name, content, reason):
    for k in range(101):
        (tmp_path / f"part{k}.stl").touch()
    (tmp_path / name).write_bytes(content)
    with pytest.raises(GeometryError, match=reason):
        geometry_text.files_of(tmp_path / name)


def test_names_in_comments_and_strings_and_of_variables_are_no_statements(tmp_path, mark):
    text = """// SystemCall "touch {mark}"; and EndIf
/* Exit; Printf("x") > "y"; */ For i In {1:2} /*
SystemCall "touch {mark}"; */
EndFor
Save = 1; Print = 2; exit = 3; system = 4;
Printf("Merge: %g > %g, SystemCall", (system > 1), exit);
General.Terminal = 1; Print.Background = 0; General.Color.Text = Black; Mesh.Algorithm = 6;
Geometry.OCCTargetUnit = "M";
If (system > 1) Printf("larger"); EndIf"""
    assert len(mesh.generate(geometry(tmp_path / "größe 'x'; $(1).geo", text, mark)).tets) > 50


def test_shipped_geometries_and_lines_of_messages_are_as_they_were(tmp_path):
    for path in sorted((ROOT / "geometry").glob("*.geo")):
        (content,) = geometry_text.files_of(path).values()
        assert content.count(b"\n") == path.read_bytes().count(b"\n") and b"//" not in content
    (tmp_path / "body.geo").write_text("/* one\ntwo */\n\nBox(1) = nonsense;\n")
    with pytest.raises(GeometryError, match="gmsh reports: 'body.geo', line 4: "):
        mesh.generate(tmp_path / "body.geo")


# ---- what the process prevents -----------------------------------------------------------------------------


@confined
@pytest.mark.parametrize("command, text", [case for case in QUICK if case[0] != "Sleep"])
def test_the_process_alone_holds(tmp_path, mark, unread, command, text):
    path = geometry(tmp_path / "body.geo", text, mark)
    try:
        mesh.generate(path)
    except GeometryError as error:
        assert "gmsh" in str(error)


def test_without_check_and_barrier_a_geometry_writes_where_it_wants(tmp_path, unread, monkeypatch):
    """The other tests see a barrier that is missing."""
    away = mesh.START.replace("main(", "sys.modules['hybrid.body.mesh_worker'].confine = lambda folder: None; main(")
    monkeypatch.setattr(mesh, "START", away)
    path = geometry(tmp_path / "body.geo", 'Printf("hello") > "{mark}";', tmp_path / "mark")
    assert len(mesh.generate(path).tets) and (tmp_path / "mark").read_text() == "hello\n"


@confined
@pytest.mark.parametrize("text", [
    'Include "/etc/passwd";', 'Merge "../other.geo";', 'x() = ListFromFile("/etc/passwd");'])
@pytest.mark.skipif("landlock" not in sandbox.offered(), reason="this system has no Landlock")
def test_the_process_alone_reads_nothing_else(tmp_path, mark, unread, text):
    with pytest.raises(GeometryError, match="gmsh reports: .*[Oo]pen file"):
        mesh.generate(geometry(tmp_path / "body.geo", text, mark))


@pytest.mark.parametrize("text", ["Exit;", "Sleep 1e6;", *LOOPS.values()])
def test_a_geometry_that_does_not_come_to_an_end_is_ended(tmp_path, mark, unread, short, text):
    path = geometry(tmp_path / "body.geo", text, mark)
    began = time.monotonic()
    with pytest.raises(GeometryError, match=r"ended without a mesh \(exit code 0|more than 1 s of processor time"):
        mesh.generate(path)
    assert time.monotonic() - began < 30.0


def test_limits_name_the_size_of_elements_and_how_they_are_raised(tmp_path, mark, monkeypatch):
    path = geometry(tmp_path / "body.geo", "Mesh.MeshSizeMax = 0.1; Mesh.MeshSizeMin = 0.1;", mark)
    monkeypatch.setattr(mesh, "TETRAHEDRA", 1000)
    with pytest.raises(GeometryError, match=r"\d+ tetrahedra, above the limit of 1000; .*size.*HYBRID_MESH_LIMIT=10"):
        mesh.generate(path)
    monkeypatch.setenv("HYBRID_MESH_LIMIT", "100")
    assert len(mesh.generate(path).tets) > 1000
    monkeypatch.setenv("HYBRID_MESH_LIMIT", "more")
    with pytest.raises(GeometryError, match="HYBRID_MESH_LIMIT=more: must be a number above 0"):
        mesh.generate(path, size=0.2)
    monkeypatch.delenv("HYBRID_MESH_LIMIT")
    monkeypatch.setattr(mesh, "MEMORY", 700 << 20)
    text = "x() = {};\nFor i In {1:1e6}\n y~{i}() = {1:100000};\nEndFor\n"
    with pytest.raises(GeometryError, match="more than 0.684 GiB of memory, the limit; .*size.*HYBRID_MESH_LIMIT=10"):
        mesh.generate(geometry(tmp_path / "large.geo", text, mark))


def test_a_crash_of_gmsh_is_an_error_with_a_reason(monkeypatch):
    monkeypatch.setattr(mesh, "START", "import os; os.abort()  # {path} {request}")
    with pytest.raises(GeometryError, match=r"gmsh crashed \(SIGABRT\); check the shape"):
        mesh.generate(ROOT / "geometry/box.geo", size=0.234)


def test_the_environment_of_the_caller_does_not_reach_the_process(tmp_path, monkeypatch):
    """Neither PATH nor a module in the working folder or in PYTHONPATH decides what runs."""
    (tmp_path / "gmsh.py").write_text("raise SystemExit('wrong module')")
    monkeypatch.chdir(tmp_path)
    for name, value in (("PATH", ""), ("PYTHONPATH", str(tmp_path)), ("HOME", "/nowhere"), ("PYTHONSTARTUP", "x")):
        monkeypatch.setenv(name, value)
    assert len(mesh.generate(ROOT / "geometry/box.geo", size=0.345).tets)


def test_without_a_folder_for_temporary_files_the_reason_is_given(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh.tempfile, "tempdir", str(tmp_path / "none"))
    with pytest.raises(GeometryError, match="cannot be meshed, as .*none.* gives: No such file .*TMPDIR"):
        mesh.generate(ROOT / "geometry/box.geo", size=0.123)


def working_folder(process):
    """Of a process by its folder in /proc, empty if it is not known."""
    try:
        return os.readlink(process / "cwd")
    except OSError:
        return ""


@pytest.mark.parametrize("number, code", [(signal.SIGINT, cli.INTERRUPTED), (signal.SIGKILL, -signal.SIGKILL)])
def test_a_signal_ends_the_meshing_at_once_with_its_process(tmp_path, mark, number, code):
    path = geometry(tmp_path / "body.geo", LOOPS["time"], mark)
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(filter(None, sys.path)), TMPDIR=str(tmp_path))
    program = subprocess.Popen([sys.executable, "-m", "hybrid", "mesh", str(path)], env=environment, cwd=ROOT,
                               stderr=subprocess.PIPE, text=True)
    while not list(tmp_path.glob("hybrid-mesh-*/answer.npz")):   # it reads the geometry from here on
        time.sleep(0.05)
        assert program.poll() is None
    here = str(next(tmp_path.glob("hybrid-mesh-*")))
    began = time.monotonic()
    program.send_signal(number)
    assert program.wait(20) == code
    while any(working_folder(process) == here for process in Path("/proc").glob("[0-9]*")):
        assert time.monotonic() - began < 10.0
        time.sleep(0.05)
    if number == signal.SIGINT:
        assert "interrupted" in program.stderr.read() and not list(tmp_path.glob("hybrid-mesh-*"))
    program.stderr.close()


def test_a_system_that_cannot_confine_says_so_in_the_sheet(monkeypatch):
    assert bool(sandbox.shortcoming()) == (len(sandbox.offered()) < 2)
    monkeypatch.setattr(sandbox, "offered", lambda: ["seccomp"])
    assert "may read files" in sandbox.shortcoming()
    monkeypatch.setattr(sandbox, "offered", lambda: ["landlock"])
    assert "Landlock alone" in sandbox.shortcoming()
    monkeypatch.setattr(sandbox, "offered", list)
    assert "not confined" in sandbox.shortcoming()


def test_a_run_on_a_system_that_cannot_confine_gives_a_note(monkeypatch, caplog):
    monkeypatch.setattr(mesh, "offered", list)
    monkeypatch.setattr(mesh, "shortcoming", lambda: "not confined")
    mesh.generate(ROOT / "geometry" / "box.geo", {"size": 0.37})
    assert "box.geo: gmsh is not confined" in caplog.text


def test_a_field_reads_no_file(tmp_path):
    text = 'Field[1] = Structured; Field[1].FileName = "/etc/passwd"; Background Field = 1;'
    path = geometry(tmp_path / "body.geo", text, "")
    with pytest.raises(GeometryError, match="FileName names a file or a program, which is refused"):
        mesh.generate(path)


def test_gmsh_that_finds_no_memory_itself_names_the_limit(monkeypatch):
    """It depends on which of its allocations fails: most end the process, a few become an error of gmsh."""
    def full(name):
        raise Exception("Out of memory (buy some more RAM!)")

    monkeypatch.setattr(mesh_worker.gmsh, "open", full)
    request = {"path": "body.geo", "parameters": {}, "memory": 2**30, "remedy": "take larger elements"}
    with pytest.raises(GeometryError, match="body.geo: meshing needed more than 1 GiB of memory, the limit; take larger"):
        with mesh_worker.session(Path("body.geo"), request):
            pass
