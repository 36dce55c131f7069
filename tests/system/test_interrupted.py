"""Runs that are killed, stopped, or run out of disk: they go on to the end of a run in one go, bit for bit."""

import ctypes
import errno
import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest
from interrupted_runs import STEPS, different, start, wait_for_step, write_scene

import hybrid
from hybrid.output import checkpoint, checkpoint_file, history, run_folder
from hybrid.output.first import StopAfterStep
from hybrid.runtime.errors import OutputError
from hybrid.runtime.stop_signals import Stopped, stop_signals

SEED, KILLS = 21, 40     # of the moments at which runs are killed


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return write_scene(tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="module")
def whole(scene, tmp_path_factory):
    """Folder of a run in one go."""
    folder = tmp_path_factory.mktemp("whole") / "out"
    hybrid.run(scene, folder, quiet=True)
    return folder


# ------------------------------------------------------------------ kills


def test_a_killed_run_goes_on_to_the_last_bit(scene, whole, tmp_path):
    process = start(scene, tmp_path)
    wait_for_step(process, tmp_path, 7)
    process.kill()
    process.wait()
    with open(tmp_path / history.NAME, "a", encoding="utf-8") as file:
        file.write("99,slide,99,0.9")      # a line that was cut
    with pytest.raises(hybrid.HybridError, match="has not been completed: continue by --resume"):
        hybrid.run(scene, tmp_path, quiet=True)
    hybrid.run(scene, tmp_path, resume=True, quiet=True)
    assert different(whole, tmp_path) == []


def locked_by(process, folder):
    try:
        return f"process {process.pid} " in (folder / run_folder.LOCK).read_text()
    except FileNotFoundError:
        return False


def steps_lost(folder):
    """Steps that a killed run has computed and that its checkpoint, if it has one yet, does not have."""
    path, name = folder / checkpoint.NAME, folder / run_folder.NAME
    run = json.loads(name.read_text()) if name.exists() else {"cleared": False}
    if not run["cleared"] or not path.exists():
        return 0
    assert checkpoint.read_run(path) == run["run"]
    return history.count_steps(folder) - checkpoint.load(path).step


@pytest.mark.slow
def test_forty_kills(scene, whole, tmp_path):
    """At random moments from the lock of the folder to the end of the process. Each new run starts in the results of the
    last one. None goes on from a checkpoint that is not its own, loses more than a checkpoint's steps, or ends otherwise."""
    chance, kills, runs, lost, life, options = random.Random(SEED), 0, 0, [], None, ["--overwrite"]
    while kills < KILLS or options != ["--overwrite"]:
        began, process = None, start(scene, tmp_path, *options)
        while process.poll() is None and began is None:
            began = time.monotonic() if locked_by(process, tmp_path) else None
            time.sleep(0.005)
        try:
            process.wait(chance.uniform(0, life) if life and kills < KILLS else None)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            kills, options = kills + 1, ["--resume"]
            lost.append(steps_lost(tmp_path))
            continue
        message = process.communicate()[1]
        if process.returncode == 2 and ("before its first checkpoint" in message or "no run to resume" in message):
            options = []
            continue
        assert process.returncode == 0, message
        life, runs, options = life or time.monotonic() - began, runs + 1, ["--overwrite"]
        assert different(whole, tmp_path) == []
    print(f"{kills} kills in {runs} runs, which all ended as the run in one go; steps lost: {sorted(lost)}")
    assert runs > 3 and max(lost) <= 4


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_signals_end_a_run_with_a_checkpoint(scene, whole, tmp_path, number):
    process = start(scene, tmp_path)
    wait_for_step(process, tmp_path, 6)
    process.send_signal(number)
    sent = time.monotonic()
    message = process.communicate()[1]
    assert time.monotonic() - sent < 10 and process.returncode == 128 + number, message
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["outcome"], summary["reason"]) == ("interrupted", number.name)
    kept = summary["checkpoint_step"]
    assert kept >= history.count_steps(tmp_path) - 1 >= 5
    assert f"interrupted by {number.name}; step {kept} is kept: continue with --resume" in message
    if number == signal.SIGTERM:
        hybrid.run(scene, tmp_path, resume=True, quiet=True)
        assert different(whole, tmp_path) == []


def test_a_second_signal_ends_the_process_at_once():
    code = ("import os, signal, time\nfrom hybrid.runtime.stop_signals import stop_signals\nwith stop_signals():\n"
            "    try:\n        os.kill(os.getpid(), signal.SIGTERM)\n        time.sleep(9)\n"
            "    finally:\n        os.kill(os.getpid(), signal.SIGINT)\n        time.sleep(9)")
    assert subprocess.run([sys.executable, "-c", code]).returncode == -signal.SIGINT


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_signal_lost_in_a_callback_stops_the_run_after_its_step():
    """ctypes prints what is raised in a callback, such as that of a kernel's compiler, and goes on."""
    with stop_signals() as signals:
        after = StopAfterStep(signals)
        after.accepted(None, None)
        ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGTERM))()
        with pytest.raises(Stopped) as stop:
            after.accepted(None, None)
        assert stop.value.exit_code == 143


def test_signals_are_given_back_and_those_ignored_stay_so():
    before, interrupt = signal.signal(signal.SIGHUP, signal.SIG_IGN), signal.getsignal(signal.SIGINT)
    try:
        with stop_signals():
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN and signal.getsignal(signal.SIGINT) != interrupt
            with pytest.raises(Stopped) as stop:
                signal.raise_signal(signal.SIGTERM)
            assert stop.value.exit_code == 143
        assert signal.getsignal(signal.SIGINT) is interrupt
    finally:
        signal.signal(signal.SIGHUP, before)


# ------------------------------------------------------------------ disk


class Faults:
    """Lets the opening for writing, or the moving into place, of files below a folder fail: the write `number`, from 0,
    and `times` after it. An audit hook cannot be removed, so there is one for all tests."""

    folder, number, times, count = None, 0, 1, 0

    def hook(self, event, arguments):
        if self.folder is None or event not in ("open", "os.rename", "os.mkdir"):
            return
        path = os.fspath(arguments[0]) if isinstance(arguments[0], (str, os.PathLike)) else ""
        writes = event != "open" or arguments[2] & (os.O_WRONLY | os.O_RDWR)
        if writes and path.startswith(self.folder) and not path.endswith(run_folder.LOCK):
            self.count += 1
            if 0 <= self.count - 1 - self.number < self.times:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), path)


@pytest.fixture(scope="module")
def audited():
    faults = Faults()
    sys.addaudithook(faults.hook)
    return faults


@pytest.fixture
def faults(audited, tmp_path):
    audited.folder, audited.count = str(tmp_path), 0
    yield audited
    audited.folder = None


def run_with_fault(scene, folder, faults, number, times):
    """Run with a fault, and go on as a user would. Returns whether the run noticed; it must then have said what to do."""
    faults.number, faults.times, faults.count = number, times, 0
    noticed = False
    try:
        hybrid.run(scene, folder, quiet=True)
    except hybrid.HybridError as error:
        assert "No space left on device" in str(error)
        noticed = True
    written, faults.number = faults.count, 10**9
    if noticed:
        kept = (folder / checkpoint.NAME).exists()
        hybrid.run(scene, folder, resume=kept, quiet=True)
        assert json.loads((folder / "summary.json").read_text())["outcome"] == "completed"
    return noticed, written


@pytest.mark.parametrize("number, times", [(0, 1), (31, 4), (60, 10**6)])
def test_a_full_disk_costs_no_state(scene, whole, tmp_path, faults, number, times):
    noticed, _ = run_with_fault(scene, tmp_path / "out", faults, number, times)
    assert noticed and different(whole, tmp_path / "out") == []


@pytest.mark.slow
def test_a_fault_at_every_write(scene, whole, tmp_path, faults):
    number, found = 0, []
    while True:
        folder = tmp_path / str(number)
        noticed, written = run_with_fault(scene, folder, faults, number, 1)
        assert different(whole, folder) == [], number
        if number >= written:
            break
        found.append(noticed)
        number += 1
    print(f"{len(found)} faults, {sum(found)} of them stopped the run; all ended as the run in one go")
    assert len(found) > 40


def test_a_folder_that_vanishes_stops_the_run_with_its_state(scene, whole, tmp_path):
    folder = tmp_path / "out"

    def vanish(*_):
        if history.count_steps(folder) == 9:
            folder.rename(tmp_path / "elsewhere")

    with pytest.MonkeyPatch.context() as patch:
        save = checkpoint.Checkpoints.accepted
        patch.setattr(checkpoint.Checkpoints, "accepted", lambda *given: (save(*given), vanish()))
        with pytest.raises(OutputError, match="history.csv: cannot be written .*; the checkpoint has the state after "
                                              "step 9"):
            hybrid.run(scene, folder, quiet=True)
    assert hybrid.run(scene, folder, resume=True, quiet=True).state.step == STEPS


@pytest.mark.slow
@pytest.mark.skipif(os.geteuid() != 0, reason="only root may mount a small file system")
@pytest.mark.parametrize("share", [0.1, 0.3, 0.45, 0.6, 0.7, 0.8])
def test_a_small_disk(scene, whole, tmp_path, share):
    """`share`: room, of what the whole run needs. A run that starts keeps the last step whose results are on disk."""
    reserved = checkpoint.GROWTH * (whole / checkpoint.NAME).stat().st_size + checkpoint_file.MORE
    size = share * (sum(path.stat().st_size for path in whole.iterdir()) + reserved)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size:.0f}", "none", tmp_path], check=True)
    try:
        process = start(scene, tmp_path / "o")
        message = process.communicate()[1]
        assert process.returncode == 2 and "Traceback" not in message
        assert "No space left on device" in message
        if steps := history.count_steps(tmp_path / "o"):
            assert int(message.rsplit("after step ", 1)[1]) >= steps - 1
        subprocess.run(["mount", "-o", "remount,size=20m", tmp_path], check=True)
        kept = (tmp_path / "o" / checkpoint.NAME).exists()
        hybrid.run(scene, tmp_path / "o", resume=kept, quiet=True)
        assert different(whole, tmp_path / "o") == []
    finally:
        subprocess.run(["umount", tmp_path], check=True)
