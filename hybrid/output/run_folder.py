"""The folder of results: one run at a time writes to it, and it holds the results of one run.

run.json has the identity of that run: a name that no other run has, and the keys of its scene that determine the physics.
A checkpoint carries the same name. A new run writes its own run.json first, and from then on nothing in the folder can be
taken for its results, even if the run is killed before it has removed what an earlier one has left. Results stay while a
new run reads its scene and meshes its bodies, which may fail; .run.starting says that they are to be replaced, so that a
run that is killed meanwhile is not continued from them.

What a run without `resume` and `overwrite` finds, and what becomes of it:

| in the folder                                                     |          |
|-------------------------------------------------------------------|----------|
| nothing, or a run without an accepted step                        | replaced |
| the same scene, completed in less than ten minutes of computing   | replaced |
| the same scene, not completed or longer                           | refused  |
| another scene, or results of an unknown run                       | refused  |
| a run that computes now                                           | refused, with `resume` and `overwrite` too |

Files that hybrid does not write are never touched.
"""

import errno
import fcntl
import json
import os
import re
import socket
import time
import uuid
from pathlib import Path

from hybrid.output import atomic, checkpoint
from hybrid.output.history import count_steps
from hybrid.output.summary import NAME as SUMMARY
from hybrid.runtime.errors import HybridError, RunFolderError

NAME = "run.json"
LOCK = ".run.lock"
STARTING = ".run.starting"
NO_LOCKS = errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS    # of file systems without locks
ENDING = 2.0        # [s] that a run which has been killed may take to let go of its folder
CHEAP = 600.0       # [s] of computing, up to which a completed run is replaced by the same one
RESULTS = re.compile(r"run\.json|history\.csv|summary\.json|checkpoint(_\d{6,}_r\d+)?\.npz"
                     r"|(soil|body_.+)(_\d{6,}(\.vtu|_r\d+\.vtu|\.pvtu)|\.pvd)|soil_step_\d{3,}\.png|trajectory\.png"
                     r"|line_tension\.png|resistance\.png|parts\.png|line_in_soil\.png")


class RunFolder:
    """Context in which the folder at `path` belongs to the run of a Scene.

    Raises RunFolderError on entry if another run computes there, if it cannot be written, or if it holds results that
    this run must not replace; CheckpointError if there is nothing to resume.

    run: identity of the run that the folder belongs to, from `begin` on
    """

    def __init__(self, path, scene, resume=False, overwrite=False):
        self.path, self._scene, self._resume, self._overwrite = Path(path), scene, resume, overwrite
        self.run = None
        if resume and overwrite:
            raise RunFolderError("--resume continues the results of the folder, --overwrite replaces them: give one of them")

    def __enter__(self):
        try:
            self._lock()
        except OSError as error:
            raise RunFolderError(f"{self.path}: results cannot be written there ({error.strerror}); choose another folder "
                                 "by --out") from None
        try:
            self._check_resume() if self._resume else self._check_replace()
            if not self._resume and _results(self.path):
                (self.path / STARTING).write_text(time.strftime("%Y-%m-%d %H:%M:%S"), encoding="utf-8")
        except OSError as error:
            self._unlock()
            raise RunFolderError(f"{error.filename}: cannot be written or read ({error.strerror}); choose another folder "
                                 "by --out") from None
        except BaseException:
            self._unlock()
            raise
        return self

    def __exit__(self, kind, *_):
        if kind and issubclass(kind, HybridError):
            self._started()     # a scene that is refused replaces nothing
        self._unlock()

    def begin(self):
        """Make the folder that of a new run, without any results, unless a run is resumed."""
        for path in self.path.glob(".*.partial"):
            path.unlink(missing_ok=True)
        if self._resume and (self.path / NAME).exists():
            return
        self.run = self.run or f"{time.strftime('%Y%m%dT%H%M%S')}-{uuid.uuid4().hex[:8]}"
        identity = {"run": self.run, "scene": self._scene.name, "started": time.strftime("%Y-%m-%d %H:%M:%S"),
                    "physics": checkpoint.fingerprint(self._scene)}
        if not self._resume:
            self._write({**identity, "cleared": False})
            self._started()
            for path in _results(self.path):
                if path.name != NAME:
                    path.unlink(missing_ok=True)
        self._write({**identity, "cleared": True})

    def _started(self):
        try:
            (self.path / STARTING).unlink(missing_ok=True)
        except OSError:
            pass        # the folder has vanished meanwhile

    def _write(self, identity):
        with atomic(self.path / NAME) as partial:
            partial.write_text(json.dumps(identity, indent=1) + "\n", encoding="utf-8")

    # -------------------------------------------------------------- what is in the folder

    def _check_resume(self):
        """Refuse to resume where the checkpoint is not of the run that the folder belongs to."""
        identity, path, marker = _read(self.path / NAME), self.path / checkpoint.NAME, self.path / STARTING
        if marker.exists():
            raise checkpoint.CheckpointError(
                f"{self.path}: the run of {marker.read_text(encoding='utf-8')[:20]}, which was to replace these results, "
                "was stopped before its first checkpoint: start it again without --resume; or, to continue the earlier "
                f"run, delete {marker}")
        if identity and not (identity["cleared"] and path.exists()):
            raise checkpoint.CheckpointError(
                f"{self.path}: its run was stopped before its first checkpoint, or writes none (output.checkpoint = 0): "
                "there is nothing to resume; start it again without --resume")
        self.run = checkpoint.read_run(path)
        if identity and identity["run"] != self.run:
            raise checkpoint.CheckpointError(
                f"{path} is of run {self.run}, the folder of run {identity['run']}: start the run again with --overwrite")

    def _check_replace(self):
        """Refuse to replace results that another scene would lose, or that take long to compute again."""
        identity, found = _read(self.path / NAME), [path.name for path in _results(self.path)]
        if self._overwrite or not found or identity and not identity["cleared"]:
            return
        if not identity:
            raise RunFolderError(f"{self.path} holds results of an unknown run ({', '.join(found[:3])}, ...): choose "
                                 "another folder by --out, or replace them by --overwrite")
        steps, summary = count_steps(self.path), _read(self.path / SUMMARY) or {}
        if not steps:
            return
        if other := self._other_physics(identity):
            raise RunFolderError(f"{self.path} holds {steps} steps of another scene; these keys differ:\n{other}\nChoose "
                                 "another folder by --out, or replace them by --overwrite")
        if summary.get("run") != identity["run"] or summary.get("outcome") != "completed":
            raise RunFolderError(f"{self.path} holds {steps} steps of this scene, which has not been completed: continue by "
                                 "--resume, choose another folder by --out, or start again by --overwrite")
        if (seconds := sum(summary["totals"]["seconds"].values())) > CHEAP:
            raise RunFolderError(f"{self.path} holds the results of this scene, {seconds / 60:.0f} minutes of computing: "
                                 "choose another folder by --out, continue by --resume, or replace them by --overwrite")

    def _other_physics(self, identity):
        return checkpoint.differences(identity["physics"], checkpoint.fingerprint(self._scene), "folder")

    # -------------------------------------------------------------- lock

    def _lock(self):
        """Lock the folder until this process ends. The system frees the lock of a process that is killed."""
        self._made = not self.path.exists()
        self.path.mkdir(parents=True, exist_ok=True)
        path, patience = self.path / LOCK, time.monotonic() + ENDING
        while True:
            self._file = open(path, "a+", encoding="utf-8")
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                if time.monotonic() < patience:
                    self._file.close()
                    time.sleep(0.1)
                    continue
                self._file.seek(0)
                holder = self._file.read().strip() or "unknown"
                self._file.close()
                raise RunFolderError(f"{self.path}: another run computes in this folder ({holder}); wait until it ends, or "
                                     "choose another folder by --out") from None
            except OSError as error:
                if error.errno not in NO_LOCKS:
                    raise
            if path.exists() and os.path.samestat(os.fstat(self._file.fileno()), path.stat()):
                break
            self._file.close()      # the run that held it has removed it meanwhile
        self._file.truncate(0)
        self._file.write(f"process {os.getpid()} on {socket.gethostname()} since {time.strftime('%Y-%m-%d %H:%M:%S')}\n")
        self._file.flush()

    def _unlock(self):
        """Remove the lock, and the folder if nothing has been written to it."""
        try:
            (self.path / LOCK).unlink(missing_ok=True)
            if self._made and not any(self.path.iterdir()):
                self.path.rmdir()
        except OSError:
            pass        # the folder has vanished meanwhile
        self._file.close()


def _results(folder):
    """Files of results in a folder."""
    return [path for path in sorted(folder.iterdir()) if RESULTS.fullmatch(path.name)]


def _read(path):
    """Dict in a JSON file, None if there is none that can be read."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None
