"""Errors that a user can correct; their messages have the value found, the limit and the remedy."""


class HybridError(Exception):
    """Base of all errors of this package; the command line prints their message without a traceback."""


class SceneError(HybridError):
    """The scene, or an argument of the command line, has an unknown, missing or impossible value."""


class GeometryError(HybridError):
    """A geometry file cannot be meshed into a closed, correctly oriented solid."""


class LawError(HybridError):
    """A constitutive law is inconsistent, or returns arrays of another shape than its interface requires."""


class StepError(HybridError):
    """A time step could not be completed, or it is useless to go on; the last accepted state is kept."""


class OutputError(HybridError):
    """Results could not be written. kept: number of the step of the checkpoint on disk, None if there is none."""

    kept = None

    def __str__(self):
        kept = f"; the checkpoint has the state after step {self.kept}" if self.kept is not None else ""
        return super().__str__() + kept


class RunFolderError(HybridError):
    """The folder of results is in use, or holds results that a run must not replace."""
