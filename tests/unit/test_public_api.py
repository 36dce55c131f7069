"""What a user's script may rely on: public names, a run from Python, its state and its records."""

import subprocess
import sys
from dataclasses import is_dataclass
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest

import hybrid

HEAVY = "numpy numba scipy gmsh dolfinx petsc4py mpi4py matplotlib pyvista meshio".split()


def python(code):
    """Standard output of a fresh interpreter."""
    return subprocess.run([sys.executable, "-c", code], cwd=Path(__file__).parents[2], capture_output=True, text=True,
                          check=True).stdout


def scene_classes(hint=hybrid.Scene):
    """Names of all dataclasses that values of this type may hold."""
    if is_dataclass(hint):
        return {hint.__name__}.union(*map(scene_classes, get_type_hints(hint).values()))
    return set().union(*map(scene_classes, get_args(hint)))


def test_public_names():
    functions = {"load_scene", "validate", "build", "run", "check_law"}
    errors = {"HybridError", "SceneError", "GeometryError", "LawError", "StepError"}
    types = {"Condition", "Freedom", "Law", "Vector"}      # of values, for type hints in a script
    names = functions | errors | types | scene_classes() | {"Simulation", "Record", "__version__"}
    assert {"Layer", "Target", "Pull", "Stage"} <= names == set(hybrid.__all__) <= set(dir(hybrid))
    assert all(getattr(hybrid, name) is not None for name in names)
    assert all(issubclass(getattr(hybrid, name), hybrid.HybridError) for name in errors)
    with pytest.raises(AttributeError, match="no attribute 'Scen'"):
        hybrid.Scen


def test_importing_and_reading_a_scene_load_nothing_heavy():
    code = f"import sys, hybrid; hybrid.Scene, hybrid.load_scene; print([n for n in {HEAVY} if n in sys.modules])"
    assert python(code) == "[]\n"


SIDE, YOUNG = 0.4, 1e6


@pytest.fixture
def pressed(geometry):
    """Scene of a held box that goes down into a block of elastic soil at 0.1 m/s for three steps, without inertia."""
    axis = hybrid.Axis(0.0, SIDE, 0.2)
    return hybrid.Scene(
        name="pressed", grid=hybrid.Grid(axis, axis, hybrid.Axis(0.0, 0.6, 0.2), hybrid.Faces(z_min="fixed")),
        soil=hybrid.Soil(hybrid.Material(law="hencky", young=YOUNG, poisson=0.0, density=1800.0), top=SIDE),
        gravity=(0.0, 0.0, 0.0),
        bodies=(hybrid.Body(
            geometry / "box.geo", 1000.0, "box", dict.fromkeys(("length", "width", "height", "size"), 0.5),
            position=(0.2, 0.2, 0.0), rest_on=SIDE, velocity=(0.0, 0.0, -0.1), driven=("x", "y", "z", "rx", "ry", "rz"),
            friction=0.0),),
        time=hybrid.Time(0.01, inertia=False), stages=(hybrid.Stage("press", 3),))


def test_build_steps_and_state(pressed):
    simulation = hybrid.build(pressed)
    assert isinstance(simulation, hybrid.Simulation)
    body, points = simulation.state.bodies[0], simulation.state.points
    start, height = points.position.copy(), body.position[2]
    records = list(simulation.steps())
    assert [record.step for record in records] == [1, 2, 3] and all(isinstance(r, hybrid.Record) for r in records)
    assert [record.time for record in records] == pytest.approx([0.01, 0.02, 0.03])

    body, points = simulation.state.bodies[0], simulation.state.points
    assert body.position[2] - height == pytest.approx(-0.003)
    assert np.array_equal(body.rotation, np.eye(3)) and body.velocity == pytest.approx([0.0, 0.0, -0.1])
    assert body.spin.shape == (3,) and not body.spin.any()
    assert points.position.shape == start.shape and (points.position[:, 2] < start[:, 2]).all()

    force = records[-1].bodies[0].contact_force
    assert force[2] == pytest.approx(YOUNG * SIDE**2 * 0.003 / SIDE, rel=0.05)      # -3.8 %, the overlap
    assert np.abs(force[:2]).max() < 1e-6 * force[2]
    assert records[-1].bodies[0].position == pytest.approx(body.position)


def test_load_and_run(tmp_path, monkeypatch):
    """Scene file to folder of results; the Simulation comes back at its end. Overrides are those of --set."""
    monkeypatch.chdir(tmp_path)
    demo = Path(__file__).parents[2] / "demos" / "rolling_sphere.toml"
    short = ["stage.0.steps=2", "output.pictures=[]"]
    scene = hybrid.load_scene(demo, short)
    simulation = hybrid.run(scene, quiet=True)
    again = hybrid.run(str(demo), out="again", overrides=short, quiet=True)
    assert (tmp_path / "out" / scene.name / "history.csv").is_file() and (tmp_path / "again" / "history.csv").is_file()
    assert np.array_equal(simulation.state.bodies[0].position, again.state.bodies[0].position)
    assert simulation.state.step == 2
