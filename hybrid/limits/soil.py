"""Limits of the soil's points, cells and laws."""


def crossing(scene, model):
    """Standard shape functions: the force jumps where a point crosses a face of cells."""
    if scene.soil.basis == "mpm" and not model.soil.held:
        yield ('soil.basis = "mpm": stresses are wrong by their own size once points cross cells; right only for soil '
               'that moves by less than a cell. Set soil.basis = "gimp"')


LIMITS = (crossing,)
