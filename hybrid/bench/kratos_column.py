"""The self-weight column of `hybrid.study.precision.problems.column` in the MPM application of Kratos Multiphysics.

    PYTHON kratos_column.py '{"cells": 16, "length": 50.0, "steps": 40, "young": 1e4, "law": "Hencky", ...}'

in an empty folder, in which it writes meshes and settings; PYTHON as for kratos_block.py. Plane strain, a cell wide, 2
x 2 points a cell at Gauss's positions, static. It prints a line RESULT with JSON: seconds and Newton iterations of each
step, the reason of a failure or "", initial heights [m] and vertical stress [Pa] of the points, and its unknowns at the
end, the vertical displacements of the two columns of nodes of cells with points in them.
"""

import json
import math
import sys

from kratos_parts import Run, settings, write_material, write_meshes

LAWS = {    # Mohr-Coulomb's is Hencky's as long as the cohesion, a hundred times the stress, is not reached
    "Hencky": "HenckyMCPlasticPlaneStrain2DLaw", "neo-Hooke": "HyperElasticNeoHookeanPlaneStrain2DLaw"}


def main(cells, length, steps, young, density, gravity, law, tolerance):
    size = length / cells
    write_meshes((1, cells), size)
    write_material(LAWS[law], 4, density, young, 0.0, cohesion=100 * density * gravity * length)
    run = Run(settings(1.0, steps, 2, "xy", tolerance, solver_type="Static"))
    heights = [place[1] for place in run.read("MP_COORD")]
    failed = run.steps(lambda number: run.fall(0.0, -gravity * number / steps, 0.0))
    top = max(place[1] for place in run.read("MP_COORD"))
    run.report(failed=failed, heights=heights, stress=[stress[1] for stress in run.read("MP_CAUCHY_STRESS_VECTOR")],
             unknowns=2 * math.ceil(top / size))


if __name__ == "__main__":
    main(**json.loads(sys.argv[1]))
