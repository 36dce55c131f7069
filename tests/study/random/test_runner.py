"""The runner and the report of the study of random scenes, by a family whose errors are known."""

import pytest

from hybrid.bench.stamp import stamp
from hybrid.runtime.errors import SceneError, StepError
from hybrid.study.random import record, report, runner
from hybrid.study.random.family import Family, uniform
from hybrid.study.random.registry import FAMILIES

ERRORS = {0: 0.001, 1: -0.02, 2: 0.03}      # by seed; the third seed stops


def draw(generator):
    return {"slope": uniform(generator, 10.0, 70.0), "mu": uniform(generator, 0.0, 1.0)}


@pytest.fixture
def toy(monkeypatch):
    """A family in place of the spheres: seeds 0 and 1 are right and silent, 2 says why it missed, 3 stops."""
    def scenes(**values):
        return [values]

    def simulate(values):
        if family.number == 3:
            raise StepError("step 3 failed: lower the load")
        return None, [], ("too far",) * (family.number == 2)

    def measure(run, **values):
        return {"distance": ERRORS[family.number], "spin": 0.0, "airborne": 0.0}

    class Numbered(Family):
        number = 0

        def values(self, name, seed):
            Numbered.number = seed
            return super().values(name, seed)

    family = Numbered("toy", FAMILIES["sphere"].aims, draw, scenes, measure, seeds=4, quick=2)
    monkeypatch.setitem(runner.FAMILIES, "sphere", family)
    monkeypatch.setattr(runner, "simulate", simulate)
    return family


def test_runs_are_judged_kept_and_drawn(toy, tmp_path):
    lines = []
    found = runner.run(["sphere"], out=tmp_path, log=lines.append)
    assert [r.kind for r in found] == ["right", "silent", "missed", "failed"]
    assert found[1].missed == ("distance",) and found[2].messages == ("too far",)
    assert found[3].reason.startswith("step 3 failed") and found[3].errors == {}
    marks, read = record.load(tmp_path / "records.json")
    assert read == found and {"commit", "machine"} <= set(marks)
    assert (tmp_path / "rides.png").stat().st_size > 5_000
    assert lines[1].startswith("sphere, seed 1: silent, distance -2.00%") and len(lines) == 5
    assert report.table(found)[0] == {
        "family": "sphere", "error of": "distance", "aim": 0.005, "scenes": 4, "lowest": -0.02, "highest": 0.03,
        "rms": pytest.approx(0.0208, abs=1e-4), "above the aim": 2, "failed": 1, "silent": 1}


def test_a_resumed_study_runs_only_missing_seeds(toy, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "draw", lambda path, out: [])
    assert len(runner.run(["sphere"], quick=True, out=tmp_path, log=lambda _: None)) == 2
    lines = []
    assert len(runner.run(["sphere"], out=tmp_path, resume=True, log=lines.append)) == 4
    assert len(lines) == 2


def test_unknown_family():
    with pytest.raises(SceneError, match="study random spheer: no such family; there are sphere"):
        runner.run(["spheer"])


def test_the_listing_has_every_name():
    assert [row["name"] for row in report.listing()] == list(FAMILIES)


def test_nothing_is_drawn_without_rides(tmp_path):
    path = tmp_path / "records.json"
    record.save(path, stamp(), [record.Record("platen", 0, {}, "right", {"force": 0.001})])
    assert report.draw(path, tmp_path) == []


def test_values_that_are_no_errors_are_not_in_percent():
    found = record.Record("cone", 0, {}, "right", {"jitter": 0.025, "q/s_u": 9.4181}, newton=7)
    assert report.line(found) == "cone, seed 0: right, jitter +2.50%, q/s_u 9.42; 7 iterations"


def test_the_shipped_records_are_those_of_the_seeds():
    _, records = record.load(report.RECORDED)
    assert {r.family for r in records} <= set(FAMILIES) and len({r.key for r in records}) == len(records)
    for r in records:
        assert r.values == FAMILIES[r.family].values(r.family, r.seed)
        assert r.kind == "failed" or list(r.missed) == FAMILIES[r.family].missed(r.errors)
