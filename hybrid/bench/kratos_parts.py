"""Common parts of the scripts for the MPM application of Kratos Multiphysics: meshes of boxes, supports, time steps.

Run by the peer's own Python, with this folder on its path and without this package.
"""

import itertools
import json
import resource
from time import perf_counter

CORNERS = {2: ((0, 0), (1, 0), (1, 1), (0, 1))}     # of a cell, in the order that an element lists its nodes
CORNERS[3] = tuple((*corner, k) for k in (0, 1) for corner in CORNERS[2])
KINDS = {2: ("Element2D4N", "MPMUpdatedLagrangian2D4N"), 3: ("Element3D8N", "MPMUpdatedLagrangian3D8N")}


class Lattice:
    """Nodes and elements of a box of cells along two or three axes, numbered from `node` and `element` on."""

    def __init__(self, cells, size, node=1, element=1):
        self.cells, self.size, self.node, self.element = tuple(cells), size, node, element

    def number(self, index):
        found, block = self.node, 1
        for i, n in zip(index, self.cells):
            found, block = found + i * block, block * (n + 1)
        return found

    def nodes(self, axis=None, ends=()):
        """Indices of all nodes, or of those whose index along an axis is in `ends`."""
        found = itertools.product(*(range(n + 1) for n in self.cells))
        return [index for index in found if axis is None or index[axis] in ends]

    def write(self, name, kind, properties, parts):
        """Write NAME.mdpa with elements of a `kind`; parts: {sub model part: (node indices, with the elements)}.
        Returns the next numbers of a node and an element."""
        elements = []
        for at in itertools.product(*(range(n) for n in self.cells)):
            around = (self.number([a + c for a, c in zip(at, corner)]) for corner in CORNERS[len(at)])
            elements.append(f"{self.element + len(elements)} {properties} {' '.join(map(str, around))}")
        lines = ["Begin ModelPartData", "End ModelPartData"]
        for number in (0, 1):
            lines += [f"Begin Properties {number}", "End Properties"]
        places = (" ".join(f"{self.size * a:.12g}" for a in (*index, 0)[:3]) for index in self.nodes())
        lines += ["Begin Nodes", *(f"{self.number(i)} {x}" for i, x in zip(self.nodes(), places)), "End Nodes"]
        lines += [f"Begin Elements {kind}", *elements, "End Elements"]
        for part, (indices, whole) in parts.items():
            lines += [f"Begin SubModelPart {part}", "Begin SubModelPartNodes"]
            lines += [str(self.number(index)) for index in indices]
            lines += ["End SubModelPartNodes", "Begin SubModelPartElements"]
            lines += [line.split()[0] for line in elements] if whole else []
            lines += ["End SubModelPartElements", "End SubModelPart"]
        with open(f"{name}.mdpa", "w", encoding="ascii") as file:
            file.write("\n".join(lines) + "\n")
        return self.number(self.cells) + 1, self.element + len(elements)


def write_meshes(cells, size, above=0):
    """A box of soil of `cells`, two or three numbers, and its grid, which has `above` more layers of cells at the top;
    parts x, y, z of the grid are the nodes of its sides and of its bottom."""
    cells, (element, material_point) = list(cells), KINDS[len(cells)]
    grid = Lattice([*cells[:-1], cells[-1] + above], size)
    ends = [(0, n) for n in cells[:-1]] + [(0,)]
    parts = {name: (grid.nodes(axis, ends[axis]), False) for axis, name in enumerate("xyz"[:len(cells)])}
    following = grid.write("grid", element, 0, {"grid": (grid.nodes(), True), **parts})
    soil = Lattice(cells, size, *following)
    soil.write("soil", material_point, 1, {"soil": (soil.nodes(), True)})


def write_material(law, points, density, young, poisson, cohesion=1e15, friction_angle=0.0, dilation_angle=0.0):
    """material.json of a law with `points` in an element; angles in degrees. The defaults make it elastic."""
    values = {
        "DENSITY": density, "YOUNG_MODULUS": young, "POISSON_RATIO": poisson, "COHESION": cohesion,
        "INTERNAL_FRICTION_ANGLE": friction_angle, "INTERNAL_DILATANCY_ANGLE": dilation_angle,
        "MATERIAL_POINTS_PER_ELEMENT": points, "THICKNESS": 1.0}
    entry = {"model_part_name": "Initial_MPM_Material.soil", "properties_id": 1, "Material": {
        "constitutive_law": {"name": law}, "Variables": values, "Tables": {}}}
    with open("material.json", "w", encoding="ascii") as file:
        json.dump({"properties": [entry]}, file)


def settings(step, steps, dimensions, rollers, tolerance, **solver):
    """Parameters of Kratos for grid.mdpa and soil.mdpa; rollers: axes whose displacement is fixed on the parts of that
    name."""
    def roller(axis):
        return {
            "python_module": "assign_vector_variable_process", "kratos_module": "KratosMultiphysics",
            "Parameters": {
                "model_part_name": f"Background_Grid.{axis}", "variable_name": "DISPLACEMENT",
                "constrained": [axis == name for name in "xyz"], "value": [0.0, 0.0, 0.0], "interval": [0.0, "End"]}}

    return {
        "problem_data": {
            "problem_name": "soil", "parallel_type": "OpenMP", "echo_level": 0, "start_time": 0.0,
            "end_time": (steps - 0.5) * step},
        "solver_settings": {
            "analysis_type": "non_linear", "model_part_name": "MPM_Material", "domain_size": dimensions,
            "echo_level": 0, "time_stepping": {"time_step": step}, "max_iteration": 20, "pressure_dofs": False,
            "model_import_settings": {"input_type": "mdpa", "input_filename": "soil"},
            "grid_model_import_settings": {"input_type": "mdpa", "input_filename": "grid"},
            "material_import_settings": {"materials_filename": "material.json"},
            "convergence_criterion": "residual_criterion", "residual_relative_tolerance": tolerance,
            "residual_absolute_tolerance": 1e-9, **solver},
        "output_processes": {},
        "processes": {"constraints_process_list": [roller(axis) for axis in rollers]}}


class Run:
    """A run of `settings` whose steps are timed one by one."""

    def __init__(self, described):
        import KratosMultiphysics as kratos
        from KratosMultiphysics import LinearSolversApplication, MPMApplication  # noqa: F401  they register themselves
        from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis

        kratos.Logger.GetDefaultOutput().SetSeverity(kratos.Logger.Severity.WARNING)
        self.kratos, self.variables, self.model = kratos, MPMApplication, kratos.Model()
        self.analysis = MpmAnalysis(self.model, kratos.Parameters(json.dumps(described)))
        self.analysis.Initialize()
        self.points, self.seconds, self.newton = self.model["MPM_Material"], [], []

    def read(self, variable):
        """Values of a variable of MPMApplication, one for each point."""
        variable, info = getattr(self.variables, variable), self.points.ProcessInfo
        return [point.CalculateOnIntegrationPoints(variable, info)[0] for point in self.points.Elements]

    def fall(self, *acceleration):
        """Set the gravity [m/s²] that acts on the points."""
        acceleration = self.kratos.Vector(list(acceleration))
        for point in self.points.Elements:
            for variable in (self.variables.MP_VOLUME_ACCELERATION, self.variables.MP_ACCELERATION):
                point.SetValuesOnIntegrationPoints(variable, [acceleration], self.points.ProcessInfo)

    def steps(self, before=lambda number: None):
        """Take all steps and call `before` with the number of each; returns the reason of a failure, else an empty
        text."""
        analysis, solver = self.analysis, self.analysis._GetSolver()
        while analysis.KeepAdvancingSolutionLoop():
            before(len(self.seconds) + 1)
            analysis.time = solver.AdvanceInTime(analysis.time)
            begin = perf_counter()
            analysis.InitializeSolutionStep()
            solver.Predict()
            converged = solver.SolveSolutionStep()
            analysis.FinalizeSolutionStep()
            self.seconds.append(perf_counter() - begin)
            self.newton.append(int(self.points.ProcessInfo[self.kratos.NL_ITERATION_NUMBER]))
            if not converged:
                return f"step {len(self.seconds)} did not converge in {self.newton[-1]} iterations"
        return ""

    def report(self, **more):
        """Print the line RESULT with times, iterations and `more` as JSON."""
        print("\nRESULT", json.dumps({
            "seconds": self.seconds, "newton": self.newton, "points": self.points.NumberOfElements(), **more,
            "threads": self.kratos.ParallelUtilities.GetNumThreads(),
            "version": self.kratos.Kernel.Version().replace('"', ""),
            "peak_MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))
