"""The block of `hybrid.bench.block` in the MPM application of Kratos Multiphysics, for its own Python to run.

    PYTHON kratos_block.py '{"cells": [23, 23, 11], "size": 0.0435, "steps": 5, "step": 0.01, ...}'

in an empty folder, which meshes and settings are written to. In a Python apart from ours:
pip install KratosMultiphysics KratosMPMApplication KratosLinearSolversApplication. A line RESULT ends in JSON: seconds
and Newton iterations of each step, how far the soil has sunk, the peak of memory. Its Mohr-Coulomb law has corners
where ours has a cone. One layer of empty cells lies above.
"""

import itertools
import json
import resource
import sys
from time import perf_counter


class Lattice:
    """Nodes and hexahedra of a box of cells, numbered from `node` and `element` on."""

    def __init__(self, cells, size, node, element):
        self.cells, self.size, self.node, self.element = cells, size, node, element

    def number(self, i, j, k):
        return self.node + i + (self.cells[0] + 1) * (j + (self.cells[1] + 1) * k)

    def nodes(self, where=lambda i, j, k: True):
        """Indices (i, j, k) of the nodes `where` something holds."""
        ranges = [range(n + 1) for n in self.cells]
        return [index for index in itertools.product(*ranges) if where(*index)]

    def write(self, name, kind, properties, parts):
        """Write NAME.mdpa with elements of a `kind`; parts: {sub model part: (node indices, with the elements)}."""
        corners = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
        elements = []
        for at in itertools.product(*(range(n) for n in self.cells)):
            around = (self.number(*(a + c for a, c in zip(at, corner))) for corner in corners)
            elements.append(f"{self.element + len(elements)} {properties} {' '.join(map(str, around))}")
        lines = ["Begin ModelPartData", "End ModelPartData"]
        for number in (0, 1):
            lines += [f"Begin Properties {number}", "End Properties"]
        places = (" ".join(f"{self.size * a:.12g}" for a in index) for index in self.nodes())
        lines += ["Begin Nodes", *(f"{self.number(*i)} {x}" for i, x in zip(self.nodes(), places)), "End Nodes"]
        lines += [f"Begin Elements {kind}", *elements, "End Elements"]
        for part, (indices, whole) in parts.items():
            lines += [f"Begin SubModelPart {part}", "Begin SubModelPartNodes"]
            lines += [str(self.number(*index)) for index in indices]
            lines += ["End SubModelPartNodes", "Begin SubModelPartElements"]
            lines += [line.split()[0] for line in elements] if whole else []
            lines += ["End SubModelPartElements", "End SubModelPart"]
        with open(f"{name}.mdpa", "w", encoding="ascii") as file:
            file.write("\n".join(lines) + "\n")
        return self.number(*self.cells) + 1, self.element + len(elements)


def write_meshes(cells, size):
    """The grid with its rollers, and the soil in it."""
    nx, ny, nz = cells[0], cells[1], cells[2] + 1
    grid = Lattice((nx, ny, nz), size, 1, 1)
    following = grid.write("grid", "Element3D8N", 0, {
        "grid": (grid.nodes(), True), "x": (grid.nodes(lambda i, j, k: i in (0, nx)), False),
        "y": (grid.nodes(lambda i, j, k: j in (0, ny)), False), "z": (grid.nodes(lambda i, j, k: k == 0), False)})
    soil = Lattice(tuple(cells), size, *following)
    soil.write("soil", "MPMUpdatedLagrangian3D8N", 1, {"block": (soil.nodes(), True)})


def write_material(material):
    """material.json of a Mohr-Coulomb soil; angles in degrees."""
    values = {
        "DENSITY": material["density"], "YOUNG_MODULUS": material["young"], "POISSON_RATIO": material["poisson"],
        "COHESION": material["cohesion"], "INTERNAL_FRICTION_ANGLE": material["friction_angle"],
        "INTERNAL_DILATANCY_ANGLE": material["dilation_angle"], "MATERIAL_POINTS_PER_ELEMENT": 8}
    entry = {"model_part_name": "Initial_MPM_Material.block", "properties_id": 1, "Material": {
        "constitutive_law": {"name": "HenckyMCPlastic3DLaw"}, "Variables": values, "Tables": {}}}
    with open("material.json", "w", encoding="ascii") as file:
        json.dump({"properties": [entry]}, file)


def settings(described):
    """What Kratos is asked to do: implicit Newmark, its default multigrid solver."""
    solver = {
        "solver_type": "Dynamic", "time_integration_method": "implicit", "scheme_type": "newmark",
        "analysis_type": "non_linear", "model_part_name": "MPM_Material", "domain_size": 3, "echo_level": 0,
        "time_stepping": {"time_step": described["step"]}, "max_iteration": 20, "pressure_dofs": False,
        "model_import_settings": {"input_type": "mdpa", "input_filename": "soil"},
        "grid_model_import_settings": {"input_type": "mdpa", "input_filename": "grid"},
        "material_import_settings": {"materials_filename": "material.json"},
        "convergence_criterion": "residual_criterion", "residual_relative_tolerance": described["tolerance"],
        "residual_absolute_tolerance": 1e-9}

    def roller(axis):
        return {
            "python_module": "assign_vector_variable_process", "kratos_module": "KratosMultiphysics",
            "Parameters": {
                "model_part_name": f"Background_Grid.{axis}", "variable_name": "DISPLACEMENT",
                "constrained": [axis == name for name in "xyz"], "value": [0.0, 0.0, 0.0], "interval": [0.0, "End"]}}

    gravity = {
        "python_module": "assign_gravity_to_material_point_process",
        "kratos_module": "KratosMultiphysics.MPMApplication",
        "Parameters": {"model_part_name": "MPM_Material", "modulus": 9.81, "direction": [0.0, 0.0, -1.0]}}
    return {
        "problem_data": {
            "problem_name": "block", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0,
            "end_time": (described["steps"] - 0.5) * described["step"]},
        "solver_settings": solver, "output_processes": {},
        "processes": {"constraints_process_list": [roller(axis) for axis in "xyz"], "gravity": [gravity]}}


def main(described):
    write_meshes(described["cells"], described["size"])
    write_material(described["material"])

    import KratosMultiphysics as kratos
    from KratosMultiphysics import LinearSolversApplication, MPMApplication  # noqa: F401  they register themselves
    from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis

    kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
    model = kratos.Model()
    run = MpmAnalysis(model, kratos.Parameters(json.dumps(settings(described))))
    run.Initialize()
    solver, points, seconds, newton = run._GetSolver(), model["MPM_Material"], [], []
    while run.KeepAdvancingSolutionLoop():
        run.time = solver.AdvanceInTime(run.time)
        begin = perf_counter()
        run.InitializeSolutionStep()
        solver.Predict()
        converged = solver.SolveSolutionStep()
        run.FinalizeSolutionStep()
        seconds.append(perf_counter() - begin)
        newton.append(int(points.ProcessInfo[kratos.NL_ITERATION_NUMBER]))
        if not converged:
            raise SystemExit(f"step {len(seconds)} did not converge")
    sunk = [p.CalculateOnIntegrationPoints(MPMApplication.MP_DISPLACEMENT, points.ProcessInfo)[0][2]
            for p in points.Elements]
    print("\nRESULT", json.dumps({
        "seconds": seconds, "newton": newton, "points": points.NumberOfElements(), "lowest [m]": min(sunk),
        "threads": kratos.ParallelUtilities.GetNumThreads(), "version": kratos.Kernel.Version().replace('"', ""),
        "peak_MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
