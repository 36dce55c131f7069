"""The column of 50 m as a problem of a study."""

from dataclasses import replace

import problem_checks
import pytest
from stand_in import interpreter

from hybrid.bench import kratos_parts
from hybrid.runtime.errors import HybridError
from hybrid.step import iteration
from hybrid.study.precision import report, runner
from hybrid.study.precision.problems import column
from hybrid.study.precision.settings import PUBLISHED


def test_default_converges(recorded):
    found = recorded(column, "default")
    assert (problem_checks.orders(found, "stress") > 1.5).all() and set(found[0].errors) == set(column.PROBLEM.errors)
    assert all(f.newton >= 40 and f.unknowns > 0 and f.time > 0 for f in found)


def test_standard_points_do_not(recorded):
    assert problem_checks.orders(recorded(column, "standard MPM"), "stress").max() < 0.2


def test_a_wrong_answer_is_seen(monkeypatch):
    """Against the height of a column 1 % stiffer nothing converges."""
    stiffer = column.Column(50.0, 1.01e4, 80.0, 10.0, 40).height()
    monkeypatch.setattr(column.Column, "height", lambda self: stiffer)
    found = problem_checks.solved(column, "default", last=2)
    assert problem_checks.orders(found, "height")[-1] < 0.5 and found[-1].errors["height"] > 1e-3


def test_no_iterations_fail(monkeypatch):
    monkeypatch.setattr(iteration, "MOST", 1)
    with pytest.raises(HybridError):
        column.solve(cells=8, solver={"tolerance": 1e-12})


def test_labels_and_values():
    problem_checks.check(column.PROBLEM)


def test_the_peer_agrees(recorded):
    """Two programs, one discretisation without ghost penalty: errors the same within a hundredth. Theirs ends with a
    residual of 1e-6, ours with 1e-4 by default, for seven tenths of the iterations."""
    theirs = {r.setting: r for r in column.peers() if r.curve == "AMPLE, GIMP"}
    for ours in recorded(column, PUBLISHED):
        setting = ours.setting
        assert ours.errors["stress"] == pytest.approx(theirs[setting].errors["stress"], rel=0.01)
        assert ours.newton == pytest.approx(0.7 * theirs[setting].newton, rel=0.1)
        assert theirs[setting].unknowns == 2 * ours.unknowns and theirs[setting].source


FAKE = """
import json, sys
if sys.argv[1] == "-c":
    print("10.4.4"); sys.exit()
asked = json.loads(sys.argv[2])
assert sys.argv[1].endswith("kratos_column.py") and asked["steps"] == 40 and asked["young"] == 1e4
failed = "step 3 did not converge" if asked["law"] == "Hencky" else ""
heights = [10.0, 40.0]
print("banner"); print("RESULT", json.dumps({"seconds": [2.0, 1.0], "newton": [3, 4], "failed": failed, "unknowns": 6,
    "heights": heights, "stress": [-800.0 * (50.0 - Z) + 400.0 for Z in heights]}))
"""


@pytest.fixture
def peer(tmp_path):
    return interpreter(tmp_path, FAKE)


def test_a_peer_runs_beside(peer, tmp_path, monkeypatch):
    """Stress that is 400 Pa of 40 kPa wrong everywhere is 1 % wrong; a failure is a record."""
    monkeypatch.setitem(runner.PROBLEMS, "column", replace(column.PROBLEM, curves=lambda quick: {}))
    monkeypatch.setattr(report, "draw", lambda path, out: [])
    records = runner.run(["column"], True, tmp_path / "out", log=lambda _: None, peer=peer)
    failed, done = ([r for r in records if r.curve.endswith(law)] for law in ("Hencky", "neo-Hooke"))
    assert len(failed) == len(done) == 2 and all(r.source == "Kratos MPM 10.4.4" for r in failed + done)
    assert all(r.failed and "step 3" in r.reason for r in failed)
    assert done[0].errors == pytest.approx({"stress": 0.01}) and done[0].work == 7 * 6 and done[0].seconds == (3.0,)


def test_the_peers_mesh_is_a_column(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    kratos_parts.write_meshes((1, 4), 0.5)
    grid, soil = ((tmp_path / f"{name}.mdpa").read_text() for name in ("grid", "soil"))
    assert "Elements Element2D4N\n1 0 1 2 4 3\n2 0 3 4 6 5" in grid and "5 0.0 1" not in grid
    assert "Elements MPMUpdatedLagrangian2D4N\n5 1 11 12 14 13\n" in soil and "\n20 0.5 2 0\n" in soil
    assert "SubModelPart y\nBegin SubModelPartNodes\n1\n2\nEnd" in grid
