"""What is modelled: the classes of a scene, scene files, checks, levels of accuracy."""

from hybrid.scene.schema import (
    Axis,
    Body,
    Condition,
    Contact,
    Faces,
    Freedom,
    Grid,
    Joint,
    Law,
    Layer,
    Load,
    Material,
    Motion,
    Output,
    Pull,
    Scene,
    Soil,
    Solver,
    Stage,
    Target,
    Time,
    Vector,
)

__all__ = ["Axis", "Body", "Condition", "Contact", "Faces", "Freedom", "Grid", "Joint", "Law", "Layer", "Load",
           "Material", "Motion", "Output", "Pull", "Scene", "Soil", "Solver", "Stage", "Target", "Time", "Vector"]
