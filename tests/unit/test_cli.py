"""The command line: what it hands on, prints, and how it fails. The physics is replaced here."""

import signal
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import hybrid
from hybrid import cli
from hybrid.runtime.errors import GeometryError, SceneError, StepError
from hybrid.runtime.stop_signals import Stopped

SCENE = """
[grid.x]
start = 0
end = 1
size = 0.5
[grid.y]
start = 0
end = 1
size = 0.5
[grid.z]
start = 0
end = 1
size = 0.5
[soil.material]
relative_density = 38
[time]
step = 0.04
[[stage]]
name = "settle"
steps = 5
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def stand_in(monkeypatch):
    """Put functions in the place of a module that the commands import."""

    def put(name, **functions):
        module = ModuleType(name)
        vars(module).update(functions)
        monkeypatch.setitem(sys.modules, name, module)

    return put


@pytest.fixture
def runs(stand_in):
    """Calls of hybrid.api.run, recorded instead of run."""
    calls = []
    stand_in("hybrid.api", run=lambda scene, out, **options: calls.append((scene, out, options)))
    return calls


def test_run_hands_scene_folder_and_options_on(scene, runs, tmp_path):
    assert cli.main(["run", str(scene)]) == 0
    given, out, options = runs.pop()
    assert given.name == "small" and out.as_posix() == "out/small"
    assert options == {"resume": False, "overwrite": False}

    chosen = ["--out", str(tmp_path / "o"), "--set", "time.step=0.1", "stage.0.steps=2", "--resume", "--overwrite"]
    assert cli.main(["run", str(scene), *chosen, "--set", "gravity=[0, 0, 0]"]) == 0
    given, out, options = runs.pop()
    assert (given.time.step, given.stages[0].steps, given.gravity) == (0.1, 2, (0.0, 0.0, 0.0))
    assert out == tmp_path / "o" and options["resume"] and options["overwrite"]


@pytest.mark.parametrize("error", [SceneError, GeometryError, StepError])
def test_errors_are_one_message_without_traceback(scene, stand_in, capsys, error):
    def run(*_, **__):
        raise error("step 3: 15 iterations, the limit is 15; try time.step=0.02")

    stand_in("hybrid.api", run=run)
    assert cli.main(["run", str(scene)]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err == "hybrid: step 3: 15 iterations, the limit is 15; try time.step=0.02\n"


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_an_interrupt_exits_as_shells_report_it(scene, stand_in, capsys, number, code):
    def run(*_, **__):
        stop = Stopped(number)
        stop.kept = 7
        raise stop

    stand_in("hybrid.api", run=run)
    assert cli.main(["run", str(scene)]) == code
    assert f"interrupted by {number.name}; step 7 is kept: continue with --resume" in capsys.readouterr().err


def test_an_interrupt_before_the_first_checkpoint_promises_nothing(scene, stand_in, capsys):
    def run(*_, **__):
        raise KeyboardInterrupt

    stand_in("hybrid.api", run=run)
    assert cli.main(["run", str(scene)]) == 130
    assert capsys.readouterr().err == "\nhybrid: interrupted\n"


def test_mistakes_of_the_program_are_not_hidden(scene, stand_in):
    def run(*_, **__):
        raise ValueError("a bug")

    stand_in("hybrid.api", run=run)
    with pytest.raises(ValueError):
        cli.main(["run", str(scene)])


@pytest.mark.parametrize("arguments, words", [
    (["run", "nowhere.toml"], "nowhere.toml: no such scene file"),
    (["check", "{scene}", "--set", "time.stp=1"], "'step'"),
    (["check", "{scene}", "--set", "time.step=-1"], "time.step = -1: must be positive"),
    (["mesh", "a.geo", "--density", "0"], "--density = 0"),
    (["mesh", "a.geo", "--density", "nan"], "--density = nan"),
    (["mesh", "a.geo", "--out", "a.stl"], "a name that ends in .vtu, such as a.vtu"),
    (["mesh", "a.geo", "--set", "size=small"], "--set size=small: expected name=number"),
    (["mesh", "a.geo", "--set", "0.1"], "expected name=number"),
])
def test_wrong_input_exits_with_2(scene, runs, capsys, arguments, words):
    assert cli.main([text.format(scene=scene) for text in arguments]) == 2
    assert words in capsys.readouterr().err
    assert not runs


@pytest.mark.parametrize("arguments", [[], ["drag"], ["run"], ["run", "a.toml", "--ou", "b"], ["mesh"]])
def test_wrong_usage_exits_with_2(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        cli.main(arguments)
    assert stop.value.code == 2
    assert "usage: hybrid" in capsys.readouterr().err


def test_check_prints_the_sheet_aligned(scene, stand_in, capsys):
    sheet = {
        "unknowns": {"soil": 21648, "body (sphere)": 6, "memory [MB]": 123.456789},
        "modelled": {"contact": ["sphere: 1200 triangles", "friction 0.4"], "inertia": True},
        "not modelled": ["pore water", "damage"],
    }
    stand_in("hybrid.setup.build", build=lambda scene: SimpleNamespace(sheet=lambda: sheet))
    assert cli.main(["check", str(scene), "--no-cost"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "unknowns",
        "  soil           21 648",
        "  body (sphere)  6",
        "  memory [MB]    123.457",
        "",
        "modelled",
        "  contact        sphere: 1200 triangles",
        "                 friction 0.4",
        "  inertia        yes",
        "",
        "not modelled",
        "  pore water",
        "  damage",
    ]


def test_check_adds_the_predicted_cost(scene, stand_in, capsys):
    simulation = SimpleNamespace(sheet=lambda: {"not modelled": ["damage"]})
    stand_in("hybrid.setup.build", build=lambda scene: simulation)
    stand_in("hybrid.cost", predict=lambda given: SimpleNamespace(
        sheet=lambda: {"predicted cost": {"step [s]": 0.25 if given is simulation else None}}))
    assert cli.main(["check", str(scene)]) == 0
    assert capsys.readouterr().out.splitlines()[2:] == ["", "predicted cost", "  step [s]  0.25"]


def test_check_reports_why_no_cost_can_be_predicted(scene, stand_in, capsys):
    def predict(_):
        raise StepError("linear solver: a diagonal block is singular")

    stand_in("hybrid.setup.build", build=lambda scene: SimpleNamespace(sheet=lambda: {"not modelled": ["damage"]}))
    stand_in("hybrid.cost", predict=predict)
    assert cli.main(["check", str(scene)]) == 0
    assert "not available: linear solver: a diagonal block is singular" in capsys.readouterr().out


def test_mesh_prints_sizes_and_mass(stand_in, capsys, tmp_path):
    seen, written = [], []
    body = SimpleNamespace(
        points=np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), tets=np.array([[0, 1, 2, 3]]),
        contact=np.zeros((3, 3), int), symmetry=np.zeros((1, 3), int),
        named_points={"eye": np.array([1.0, 0.0, 0.0])}, name="tet", regions=(), parts=())
    mass = SimpleNamespace(mass=1308.33333, centre=np.full(3, 0.25), inertia=np.diag([1.0, 2.0, 3.0]) + 1e-17)
    stand_in("hybrid.body.mesh", generate=lambda *given: seen.append(given) or body)
    stand_in("hybrid.body.smooth_mass", mass_and_surface=lambda *given: seen.append(given) or (mass, None))
    stand_in("hybrid.output.vtk", write_mesh=lambda *given: written.append(given))
    target = tmp_path / "tet.vtu"
    options = ["--density", "7.85e3", "--set", "size=1", "length=2.5", "--out", str(target)]
    assert cli.main(["mesh", "tet.geo", *options]) == 0
    assert [str(given[0]) for given in seen[:1]] == ["tet.geo"] and seen[0][1] == {"size": 1.0, "length": 2.5}
    assert seen[1] == (body, 7850.0) and written == [(target, body)]
    rows = {line.strip().split("  ")[0]: line.split()[1:] for line in capsys.readouterr().out.splitlines()}
    assert rows["nodes"] == ["4"] and rows["watertight"] == ["yes"]
    assert rows["mass [kg]"][-1] == "1308.33"
    assert rows["eye"] == ["1", "0", "0"]
    assert rows["inertia about the centre [kg m²]"][-3:] == ["1", "0", "0"]  # round-off is shown as zero


def python(*arguments):
    """Standard output of a fresh interpreter."""
    folder = Path(__file__).parents[2]
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout


def test_version_and_public_names():
    assert python("-m", "hybrid", "--version") == f"hybrid {hybrid.__version__}\n"
    assert hybrid.Scene.__module__ == "hybrid.scene.schema" and callable(hybrid.load_scene)
    assert set(hybrid.__all__) <= set(dir(hybrid))
    with pytest.raises(AttributeError, match="no attribute 'Scen'"):
        hybrid.Scen


def test_import_and_help_load_nothing_heavy():
    heavy = "numpy numba gmsh dolfinx petsc4py mpi4py matplotlib pyvista meshio".split()
    code = f"""
import sys, hybrid, hybrid.cli, hybrid.arguments
hybrid.Scene, hybrid.load_scene
hybrid.arguments.parser().format_help()
print([name for name in {heavy} if name in sys.modules])
"""
    assert python("-c", code) == "[]\n"


def test_study_runs_a_problem_draws_it_again_and_names_what_there_is(tmp_path, capsys):
    assert cli.main(["study", "precision", "platen", "--quick", "--out", str(tmp_path)]) == 0
    output = capsys.readouterr().out
    assert "platen, published method" in output and "times the front" in output
    assert {"records.json", "time.png", "work.png", "more.png"} <= {path.name for path in tmp_path.iterdir()}
    (tmp_path / "time.png").unlink()
    assert cli.main(["study", "precision", "--draw", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "time.png").exists()
    assert cli.main(["study", "precision", "platform"]) == 2
    assert "no such problem; there are column" in capsys.readouterr().err
    assert cli.main(["study", "precision", "--draw", "--out", str(tmp_path / "none")]) == 2


@pytest.mark.parametrize("names", [[], ["cylinder", "collapse"]])
def test_families_of_random_scenes_are_listed(names, capsys):
    """Names may follow options."""
    assert cli.main(["study", "random", "--list", *names]) == 0
    output = capsys.readouterr().out
    assert "cylinder on a slope that is held" in output and "collapse" in output
