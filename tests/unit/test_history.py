"""history.csv: a row per step, complete on disk after each, also when a run is resumed."""

import csv
import re
from pathlib import Path

import numpy as np
from fake_run import FakeSimulation

from hybrid.body.symmetry import Mirror
from hybrid.output import history
from hybrid.output.record import BodyRecord, JointRecord, PairRecord, Record
from hybrid.runtime.data import GEOMETRY
from hybrid.step.energy import STORED, WORKS


def lines(folder):
    with open(Path(folder) / "history.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_row_names_every_unit_and_keeps_every_digit():
    simulation = FakeSimulation()
    simulation.state = simulation.state_at(3)
    row = simulation.record().row()
    for name in ("time_s", "dt_s", "anchor_x_m", "anchor_qw", "anchor_vx_m_per_s", "anchor_spin_y_rad_per_s",
                 "anchor_contact_fx_N", "anchor_contact_mz_Nm", "anchor_tension_N", "energy_kinetic_J",
                 "seconds_solve", "seconds_contact_search"):
        assert name in row
    assert float(str(row["energy_kinetic_J"])) == 1 / 7


def test_history_is_on_disk_after_each_step(tmp_path):
    simulation, observer = FakeSimulation(), history.History(tmp_path)
    observer.start(simulation)
    for step in (1, 2, 3):
        simulation.state = simulation.state_at(step)
        observer.accepted(simulation.record(), simulation)
        assert [row["step"] for row in lines(tmp_path)] == [str(k) for k in range(1, step + 1)]
    columns = history.read_history(tmp_path)
    assert columns["energy_kinetic_J"][0] == 1 / 7
    assert list(columns["stage"]) == ["settle", "settle", "drag"]
    assert history.body_names(columns) == ["anchor"]


def test_history_resumes_without_second_header_and_drops_later_rows(tmp_path):
    FakeSimulation().run([history.History(tmp_path)], until=5)
    with open(tmp_path / "history.csv", "a", encoding="utf-8") as file:
        file.write("6,drag,4,0.2")  # the machine went down here
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(3)
    resumed.run([history.History(tmp_path)])
    assert [int(row["step"]) for row in lines(tmp_path)] == [1, 2, 3, 4, 5, 6]
    assert (tmp_path / "history.csv").read_text().count("stage_step") == 1


def test_fresh_run_replaces_history_and_new_columns_widen_it(tmp_path):
    FakeSimulation().run([history.History(tmp_path)])
    simulation, observer = FakeSimulation(), history.History(tmp_path)
    observer.start(simulation)
    for step in (1, 2):
        simulation.state = simulation.state_at(step)
        record = simulation.record()
        if step == 2:
            record.seconds["contact"] = 0.5
        observer.accepted(record, simulation)
    columns = history.read_history(tmp_path)
    assert len(columns["step"]) == 2
    np.testing.assert_array_equal(columns["seconds_contact"], [np.nan, 0.5])
    assert columns["seconds_solve"][1] == 0.3


def full_row():
    """All columns that a row may have."""
    z, mirrors = np.ones(3), (Mirror("y", 0.0, True),)
    body = BodyRecord("foot", z, np.ones(4), z, z, z, z, reaction={"x": 1.0, "rx": 1.0, "tip x": 1.0}, load=np.ones(6),
                      work={"load": 1.0, "x": 1.0, "tip x": 1.0}, mirrors=mirrors, parts={"base": z}, line_ends=(1.0,) * 4)
    return Record(1, "go", 1, 1.0, 1.0, 1, 1, 0, 1e-5, 3, seconds={"contact search": 1.0},
                  energies=dict.fromkeys((*STORED, *WORKS, "stop", "error"), 1.0),
                  bodies=[body], joints=[JointRecord("pin", np.ones(6), 1.0)],
                  pairs=[PairRecord("one", "two", z, 1.0, 2)], copies=2,
                  time_error=1e-6).row()


def test_the_page_explains_every_column():
    """And names none that does not exist. Columns of the whole of a half model are explained below the table."""
    page = (GEOMETRY.parent / "demos" / "README.md").read_text(encoding="utf-8")
    section = page.split("## Columns of history.csv")[1]
    named = [code for line in section.splitlines() if line.startswith("| `")
             for code in re.findall(r"`([^`]+)`", line.split("|")[1])]

    def pattern(code):
        code = re.sub("BODY|PART|JOINT|POINT|SECOND|FIRST|PHASE", ".+", code)
        return re.sub(r"(?<=[_fmv])x(?=_)", "[xyz]", code).replace("qw", "q[wxyz]")

    columns = [name for name in full_row() if "_whole_" not in name]
    assert not [name for name in columns if not any(re.fullmatch(pattern(code), name) for code in named)]
    assert not [code for code in named if not any(re.fullmatch(pattern(code), name) for name in columns)]
    assert "foot_contact_fx_whole_N" in full_row()
