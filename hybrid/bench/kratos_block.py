"""The block of `hybrid.bench.block` in the MPM application of Kratos Multiphysics, for its own Python to run.

    PYTHON kratos_block.py '{"cells": [23, 23, 11], "size": 0.0435, "steps": 5, "step": 0.01, ...}'

in an empty folder, in which it writes meshes and settings. In a separate Python environment: pip install
KratosMultiphysics KratosMPMApplication KratosLinearSolversApplication. It prints a line RESULT with JSON: seconds and
Newton iterations of each step, largest settlement, peak memory. Its yield surface is the Mohr-Coulomb pyramid, ours a
cone. One layer of empty cells lies above. Implicit Newmark, its default multigrid solver.
"""

import json
import sys

from kratos_parts import Run, settings, write_material, write_meshes


def main(cells, size, steps, step, tolerance, material):
    write_meshes(cells, size, above=1)
    material.pop("law", None)
    write_material("HenckyMCPlastic3DLaw", 8, **material)
    run = Run(settings(step, steps, 3, "xyz", tolerance, solver_type="Dynamic", time_integration_method="implicit",
                       scheme_type="newmark"))
    run.fall(0.0, 0.0, -9.81)
    if failed := run.steps():
        sys.exit(failed)
    run.report(**{"lowest [m]": min(moved[2] for moved in run.read("MP_DISPLACEMENT"))})


if __name__ == "__main__":
    main(**json.loads(sys.argv[1]))
