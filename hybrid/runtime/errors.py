"""Errors that a user can act on: what was found, what the limit is, and what to try."""


class HybridError(Exception):
    """Base of every error this package raises on purpose; the command line prints it without a traceback."""


class SceneError(HybridError):
    """The scene asks for something unknown, missing or impossible."""


class GeometryError(HybridError):
    """A geometry file cannot be meshed into a closed, correctly oriented solid."""


class LawError(HybridError):
    """A constitutive law contradicts itself, or answers in another shape than its contract says."""


class StepError(HybridError):
    """A time step could not be completed; the last accepted state is intact."""
