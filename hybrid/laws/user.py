"""A law of one's own, given from Python to a scene whose `soil.material` has `law = "user"` and the density:

    def clay(points, stress):
        return MyLaw(...)          # an object that keeps the contract of `hybrid.laws`

    hybrid.run(scene, law=clay)    # or hybrid.setup.build.build(scene, law=clay)

It is asked once for a law of all points: `points` are PointConstants (position, half, volume, mass), `stress` (n, 3)
[Pa] is the initial stress along x, y and z. The law's answers are checked for shape at every call; a point with an
answer that is no finite number counts as failed, so that the increment is halved. Try a new law with
`hybrid.check_law` first: it compares the tangent with finite differences. demos/user_law.py is an example."""

import numpy as np

from hybrid.laws import Response
from hybrid.runtime.errors import LawError

MEMBERS = ("young", "plastic", "respond", "energy", "strain")


class Guarded:
    """A user's law, each of whose answers is checked: `n` points. Its tangents are taken for unsymmetric, as a law
    derived from another inherits what that says of its own."""

    symmetric = False

    def __init__(self, law, n):
        self.law, self.n = law, n
        self.young, self.plastic = _array(law.young, (n,), "young"), bool(law.plastic)
        self.name = type(law).__name__

    def respond(self, strain, plastic_strain):
        return answer(self.law, strain, plastic_strain)

    def energy(self, elastic):
        return _array(self.law.energy(elastic), (self.n,), "energy(elastic)")

    def strain(self, stress):
        return _array(self.law.strain(stress), (self.n, 3), "strain(stress)")


def adopt(law, n):
    """The law made by a user for `n` points, guarded. Raises LawError when it does not keep the contract."""
    missing = [name for name in MEMBERS if not hasattr(law, name)]
    if missing:
        raise LawError(f"a law needs {', '.join(MEMBERS)} (hybrid.laws tells what they are); {type(law).__name__} has "
                       f"no {', '.join(missing)}. A class derived from hybrid.laws.hencky.Hencky has all of them")
    guarded = Guarded(law, n)
    if not np.all(guarded.young > 0):
        raise LawError(f"{guarded.name}.young goes down to {guarded.young.min():g} Pa: must be positive, contact takes "
                       "its stiffness from it")
    at_rest = guarded.respond(guarded.strain(np.zeros((n, 3))), np.zeros(n))
    if at_rest.failed.any():
        raise LawError(f"{guarded.name} has no finite stress for {np.count_nonzero(at_rest.failed)} points without "
                       "stress or history; it must have one there")
    return guarded


def answer(law, strain, plastic_strain):
    """Response of a law with shapes as in its contract; points where it is not finite have failed. Raises LawError."""
    response = law.respond(strain.copy(), plastic_strain.copy())
    if not hasattr(response, "stress"):
        raise LawError(f"{type(law).__name__}.respond must give a hybrid.laws.Response, not a "
                       f"{type(response).__name__}; write return Response(stress, elastic, tangent)")
    n = len(strain)
    shapes = {"stress": (n, 3), "elastic": (n, 3), "tangent": (n, 3, 3)}
    parts = {name: _array(getattr(response, name), shape, f"respond(...).{name}") for name, shape in shapes.items()}
    failed = ~np.all([np.isfinite(part.reshape(n, -1)).all(axis=1) for part in parts.values()], axis=0)
    if getattr(response, "failed", None) is not None:
        failed |= _array(response.failed, (n,), "respond(...).failed").astype(bool)
    return Response(**parts, failed=failed)


def _array(value, shape, name):
    """`value` as a contiguous array of its own of floats, of the shape that the contract asks for."""
    try:
        value = np.array(value, float, order="C")
    except (TypeError, ValueError) as error:
        raise LawError(f"{name} of a law must be an array of numbers of shape {shape}: {error}") from None
    if value.shape != shape:
        raise LawError(f"{name} of a law has shape {value.shape}, must be {shape}: one row per point")
    return value
