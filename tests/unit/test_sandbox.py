"""Each barrier of the kernel refuses what it should on its own, and leaves computing and reading alone."""

import subprocess
import sys
from pathlib import Path

import pytest

from hybrid.runtime import sandbox

PROGRAM = """
import os, signal, socket, sys, threading
sys.path.insert(0, {root!r})
from hybrid.runtime import sandbox

def tried(name, action):
    try:
        print(name, "done" if not action() else "failed", flush=True)
    except OSError as error:
        print(name, "refused", flush=True)

def thread():
    one = threading.Thread(target=print, args=("thread", "done"), kwargs=dict(flush=True))
    one.start()
    one.join()

def child():
    if os.fork() == 0:
        os._exit(0)

parent, inside, outside, kept = os.getppid(), {inside!r}, {outside!r}, open({inside!r} + "/kept", "w")
sandbox.offered = lambda: {names!r}
sandbox.limit(20, 1 << 32, 1 << 20)
sandbox.confine(inside)
tried("read", lambda: open(inside + "/given").read() != "text")
tried("kept", lambda: kept.write("text") != 4)
tried("memory", lambda: len(bytes(10_000_000)) != 10_000_000)
thread()
tried("read-outside", lambda: open("/etc/passwd").close())
tried("write", lambda: open(inside + "/new", "w").close())
tried("write-outside", lambda: open(outside, "w").close())
tried("append", lambda: open(inside + "/given", "a").close())
tried("remove", lambda: os.unlink(inside + "/given"))
tried("rename", lambda: os.rename(inside + "/given", inside + "/other"))
tried("folder", lambda: os.mkdir(inside + "/folder"))
tried("system", lambda: os.system("true"))
tried("execute", lambda: os.execv("/bin/true", ["true"]))
tried("fork", child)
tried("rights", lambda: os.chmod(inside + "/given", 0o600))
tried("connect", lambda: socket.socket(socket.AF_UNIX).close())
tried("signal", lambda: os.kill(parent, 0))
"""
ALLOWED = {"read", "kept", "memory", "thread"}
NOT_OF = {"landlock": {"fork", "rights", "connect", "signal"}, "seccomp": {"read-outside"}}   # what one of them leaves


@pytest.mark.parametrize("names", [["landlock"], ["seccomp"], ["landlock", "seccomp"]], ids="+".join)
def test_a_confined_process_can_compute_and_read_what_it_was_given_only(tmp_path, names):
    if set(names) - set(sandbox.offered()):
        pytest.skip("this system does not have them")
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "given").write_text("text")
    root = str(Path(sandbox.__file__).parents[2])
    program = PROGRAM.format(root=root, inside=str(tmp_path / "in"), outside=str(tmp_path / "new"), names=names)
    done = subprocess.run([sys.executable, "-I", "-c", program], capture_output=True, text=True, timeout=60)
    found = dict(line.split() for line in done.stdout.splitlines())
    assert done.returncode == 0, done.stderr
    left = NOT_OF[names[0]] if len(names) == 1 else set()
    assert {name for name, answer in found.items() if answer == "done"} - left == ALLOWED, found
    assert len(found) == 17 and {path.name for path in (tmp_path / "in").iterdir()} == {"given", "kept"}
    assert (tmp_path / "in" / "given").read_text() == "text" and not (tmp_path / "new").exists()


def test_asking_for_the_barriers_changes_nothing(tmp_path):
    sandbox.offered()
    (tmp_path / "file").write_text("still writable")
    assert subprocess.run([sys.executable, "-c", "pass"]).returncode == 0


def test_a_barrier_that_is_offered_but_cannot_be_put_up_is_an_error(monkeypatch, tmp_path):
    monkeypatch.setattr(sandbox, "offered", lambda: ["landlock"])
    monkeypatch.setattr(sandbox, "_call", lambda *given: -1)
    monkeypatch.setattr(sandbox, "SET_NO_NEW_PRIVS", sandbox.GET_SECCOMP)   # asks only
    with pytest.raises(OSError):
        sandbox.confine(tmp_path)
