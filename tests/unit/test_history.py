"""history.csv: a row per step, complete on disk after each, also when a run is resumed."""

import csv
from pathlib import Path

import numpy as np
from fake_run import FakeSimulation

from hybrid.output import history


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
