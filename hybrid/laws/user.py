"""A user's law, given from Python to a scene whose `soil.material` has `law = "user"` and the density:

    def clay(points, stress):
        return MyLaw(...)          # an object with the interface of `hybrid.laws`

    hybrid.run(scene, law=clay)    # or hybrid.build(scene, law=clay)

The function is called once and returns the law of all points: `points` are PointConstants (position, half_width,
volume, mass), `stress` (n, 3) [Pa] is the initial stress along x, y and z. The shapes of the law's results are
checked at every call; a point with a result that is not a finite number counts as failed, so that the increment is
halved. Check a new law with `hybrid.check_law` first: it compares the tangent with finite differences.
demos/user_law.py is an example.
"""

import numpy as np

from hybrid.laws import Response
from hybrid.runtime.errors import LawError

MEMBERS = ("young", "plastic", "respond", "energy", "strain")


class CheckedLaw:
    """A user's law of `n` points whose results are checked. Its tangents are taken for unsymmetric, because a law that
    is derived from another one inherits `symmetric` from it, right or wrong."""

    symmetric = False

    def __init__(self, law, n):
        self.law, self.n = law, n
        self.young, self.plastic = _array(law.young, (n,), "young"), bool(law.plastic)
        self.name = type(law).__name__

    def respond(self, strain, plastic_strain):
        return checked_response(self.law, strain, plastic_strain)

    def energy(self, elastic):
        return _array(self.law.energy(elastic), (self.n,), "energy(elastic)")

    def strain(self, stress):
        return _array(self.law.strain(stress), (self.n, 3), "strain(stress)")


def adopt(law, n):
    """CheckedLaw of a user's law for `n` points. Raises LawError if it has not the interface of `hybrid.laws`."""
    missing = [name for name in MEMBERS if not hasattr(law, name)]
    if missing:
        raise LawError(f"a law needs {', '.join(MEMBERS)} (see hybrid.laws); {type(law).__name__} has no "
                       f"{', '.join(missing)}. A class derived from hybrid.laws.hencky.Hencky has all of them")
    checked = CheckedLaw(law, n)
    if not np.all(checked.young > 0):
        raise LawError(f"{checked.name}.young goes down to {checked.young.min():g} Pa: must be positive, because "
                       "contact takes its stiffness from it; give Young's modulus of each point")
    at_rest = checked.respond(checked.strain(np.zeros((n, 3))), np.zeros(n))
    if at_rest.failed.any():
        raise LawError(f"{checked.name} has no finite stress for {np.count_nonzero(at_rest.failed)} points without "
                       "stress and plastic strain; return a finite one there")
    return checked


def checked_response(law, strain, plastic_strain):
    """Response of a law, checked for its shapes; points where it is not finite have failed. Raises LawError."""
    response = law.respond(strain.copy(), plastic_strain.copy())
    if not hasattr(response, "stress"):
        raise LawError(f"{type(law).__name__}.respond must return a hybrid.laws.Response, not a "
                       f"{type(response).__name__}; write return Response(stress, elastic, tangent)")
    n = len(strain)
    shapes = {"stress": (n, 3), "elastic": (n, 3), "tangent": (n, 3, 3)}
    parts = {name: _array(getattr(response, name), shape, f"respond(...).{name}") for name, shape in shapes.items()}
    failed = ~np.all([np.isfinite(part.reshape(n, -1)).all(axis=1) for part in parts.values()], axis=0)
    if getattr(response, "failed", None) is not None:
        failed |= _array(response.failed, (n,), "respond(...).failed").astype(bool)
    return Response(**parts, failed=failed)


def _array(value, shape, name):
    """`value` as a new contiguous array of floats; LawError for another shape."""
    try:
        value = np.array(value, float, order="C")
    except (TypeError, ValueError) as error:
        raise LawError(f"{name} of a law must be an array of numbers of shape {shape}: {error}") from None
    if value.shape != shape:
        raise LawError(f"{name} of a law has shape {value.shape}, must be {shape}: one row per point")
    return value
