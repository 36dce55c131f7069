"""Memory that the steps of one model use in turn, so that a step allocates as little as possible."""

from hybrid.linalg.system_cache import Systems
from hybrid.soil.workspace import SoilWorkspace


class Workspace:
    """The linear system of the last set of active nodes (`systems`) and the buffers of the soil (`soil`)."""

    def __init__(self, model):
        self._model, self.systems, self.soil = model, Systems(model), SoilWorkspace(model.soil, model.solver)

    def renew(self, model):
        """Go on with another model. The soil's buffers stay where it is the same soil."""
        if model.soil is not self._model.soil or model.solver != self._model.solver:
            self.soil = None    # frees the old buffers before the new ones are allocated
            self.soil = SoilWorkspace(model.soil, model.solver)
        self._model = model
        self.systems.renew(model)

    def follow_points(self, model):
        """Go on with a model whose points have moved from process to process, or whose nodes have moved."""
        self.soil.follow_points(model.soil)
        self._model = model
        self.systems.follow_points(model)

    def destroy(self):
        """Release the matrices."""
        self.systems.destroy()
