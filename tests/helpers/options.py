"""Options of a scene: what it sets beside physics, cells and steps."""

from hybrid.scene import Body, Scene, Soil, Solver, Stage, Time

# The fields of a scene's tables that state physics, cells and steps. All others are options and keep their defaults.
PHYSICS = {
    Soil: {"material", "top", "lower", "upper", "held", "geostatic", "k0", "layers"},
    Body: {"geometry", "density", "name", "parameters", "position", "rotation", "rest_on", "velocity", "spin", "held",
           "driven", "friction"},
    Time: {"step", "inertia"},
    Stage: {"name", "steps", "step", "gravity", "held"},
    Solver: set(),
    Scene: {"name", "grid", "soil", "bodies", "time", "stages", "gravity", "solver"},
}


def options_set(scene):
    """Names of the options that a Scene sets: fields other than PHYSICS that differ from their defaults."""
    tables = [scene, scene.soil, scene.time, scene.solver, *scene.bodies, *scene.stages]
    return [f"{type(table).__name__}.{name}" for table in tables
            for name, field in type(table).__dataclass_fields__.items()
            if name not in PHYSICS[type(table)] and getattr(table, name) != field.default]
