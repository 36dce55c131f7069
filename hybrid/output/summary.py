"""summary.json: outcome, sizes, cost, versions and machine of a run."""

import json
import os
import platform
import sys
import time
from importlib import metadata
from pathlib import Path

import numpy as np

from hybrid.body.symmetry import copies
from hybrid.output import atomic
from hybrid.output.history import NAME as HISTORY
from hybrid.output.history import read_history
from hybrid.output.record import column

NAME = "summary.json"

# Module -> possible names of its package, most common first.
PACKAGES = {
    "hybrid": ("hybrid",),
    "numpy": ("numpy",),
    "numba": ("numba",),
    "scipy": ("scipy",),
    "dolfinx": ("fenics-dolfinx", "dolfinx"),
    "petsc4py": ("petsc4py",),
    "gmsh": ("gmsh",),
    "meshio": ("meshio",),
    "matplotlib": ("matplotlib",),
    "pyvista": ("pyvista",),
}


class Summary:
    """Observer that sums the cost of the steps and writes summary.json in `folder` when the run ends.

    Totals of a resumed run include the earlier sessions, as far as history.csv has them; so do its notes.
    """

    def __init__(self, folder, run=""):
        self.folder, self.run = Path(folder), run

    def start(self, simulation):
        self.began = time.perf_counter()
        self.resumed_from = simulation.state.step
        self.counts = {"steps": 0, "increments": 0, "iterations": 0, "rejections": 0, "judged": 0}
        self.seconds, self.notes = {}, list(simulation.notes)
        if self.resumed_from and (self.folder / HISTORY).exists():
            self._add_history(read_history(self.folder))

    def _add_history(self, history):
        self.counts["steps"] = len(history.get("step", ()))
        for name in ("increments", "iterations", "rejections", "judged"):
            self.counts[name] = int(np.nansum(history.get(name, 0)))
        for name, values in history.items():
            if name.startswith("seconds_"):
                self.seconds[name[len("seconds_"):]] = float(np.nansum(values))

    def accepted(self, record, simulation):
        self.counts["steps"] += 1
        self.notes += record.notes
        for name in ("increments", "iterations", "rejections", "judged"):
            self.counts[name] += getattr(record, name)
        for phase, value in record.seconds.items():
            phase = column(phase)
            self.seconds[phase] = self.seconds.get(phase, 0.0) + value

    def finish(self, summary, simulation):
        later = simulation.later_notes
        content = {
            "scene": simulation.scene.name,
            "run": self.run,
            **summary,
            "notes": [later.get(note, note) for note in self.notes],
            "time_s": simulation.state.time,
            "step": simulation.state.step,
            "resumed_from_step": self.resumed_from,
            "sizes": simulation.sheet(),
            "totals": {**self.counts, "seconds": self.seconds},
            "wall_seconds_of_this_session": time.perf_counter() - self.began,
            "work_J": simulation.state.work,
            **_whole(simulation),
            "versions": versions(),
            "machine": machine(),
        }
        with atomic(self.folder / NAME) as partial:
            partial.write_text(json.dumps(content, indent=2, default=_plain) + "\n", encoding="utf-8")


def _whole(simulation):
    """Planes of symmetry, and masses and works of the whole beside those of what is modelled; nothing without one."""
    mirrors = simulation.mirrors
    if not mirrors:
        return {}
    bodies = {body.name: {"mass_kg": body.mass.mass, "mass_whole_kg": copies(body.mirrors) * body.mass.mass}
              for body in simulation.model.bodies}
    return {"symmetry": {"planes": list(map(str, mirrors)), "whole_over_modelled": copies(mirrors), "bodies": bodies,
                         "work_whole_J": {k: copies(mirrors) * work for k, work in simulation.state.work.items()}}}


def versions():
    """Versions of python and of the packages that a run uses, without importing any.

    They are read from the package metadata, else from a loaded module. gmsh, of which Debian has no metadata, is not
    loaded here: the process that meshed has reported its version.
    """
    found = {"python": platform.python_version()}
    for module, names in PACKAGES.items():
        found[module] = _version(module, names)
    found["gmsh"] = getattr(sys.modules.get("hybrid.body.mesh"), "versions", {}).get("gmsh", found["gmsh"])
    return found


def _version(module, names):
    for name in names:
        try:
            return metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return getattr(sys.modules.get(module), "__version__", None)


def machine():
    """Platform, number of processors that this process may use, and the limits of threads that are set."""
    limits = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS")
    threads = {name: os.environ[name] for name in limits if name in os.environ}
    cpus = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "platform": platform.platform(),
        "processor": platform.machine(),
        "cpus": cpus,
        "threads": threads,
    }


def _plain(value):
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    return str(value)
