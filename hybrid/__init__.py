"""Rigid bodies and highly deformable soil: the implicit generalised interpolation material point method.

    import hybrid
    hybrid.run("demos/anchor.toml", out="out/anchor")        # a scene file, or a hybrid.Scene(...)

    simulation = hybrid.build(hybrid.load_scene("demos/anchor.toml"))
    for record in simulation.steps():                        # one accepted step: forces, energies, iterations
        print(record.time, record.bodies[0].contact_force)
    simulation.state.bodies[0].position                      # committed state: bodies and points

Names are imported when first used, so that `import hybrid` costs nothing. These names, and those of the fields that
tests/unit/test_public_api.py reads, stay as they are.
"""

import os
from importlib import import_module

from hybrid.runtime.environment import prepare
from hybrid.runtime.kernel_cache import choose_folder

# Threads of OpenMP wait some microseconds for the next parallel loop, and a step has many short ones: the anchor takes
# 0.87 of the time that it takes with numba's own work queue, whose threads sleep in between. Longer waiting gains no
# more, and takes time from others on a busy machine. Numba reads this when it is imported.
os.environ.setdefault("NUMBA_THREADING_LAYER_PRIORITY", "omp workqueue tbb")
os.environ.setdefault("GOMP_SPINCOUNT", "1000")
# Threads of BLAS wait for each other at each of thousands of short sums: the anchor takes 1.2 times the processor's time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")      # without effect where numpy has been imported before
prepare()
choose_folder()     # of compiled kernels, likewise

_SCENE = ("Axis Body Condition Contact Faces Freedom Grid Joint Law Layer Load Material Motion Output Pull Scene Soil "
          "Solver Stage Target Time Vector").split()
_HOMES = {
    **dict.fromkeys(_SCENE, "hybrid.scene"),
    **dict.fromkeys(("load_scene", "validate"), "hybrid.scene.file"),
    **dict.fromkeys(("HybridError", "SceneError", "GeometryError", "LawError", "StepError"), "hybrid.runtime.errors"),
    "check_law": "hybrid.laws.check",
    "run": "hybrid.api",
    "build": "hybrid.setup.build",
    "Simulation": "hybrid.simulation",
    "Record": "hybrid.output.record",
}
__all__ = [*_HOMES, "__version__"]


def __getattr__(name):
    if name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
    elif name == "__version__":
        value = _version()
    else:
        raise AttributeError(f"module 'hybrid' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *__all__})


def _version():
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("hybrid")
    except PackageNotFoundError:  # used from a folder without installation
        return "0+unknown"
