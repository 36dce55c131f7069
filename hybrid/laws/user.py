"""A user's law, given from Python to a scene whose `soil.material` has `law = "user"` and the density:

    def clay(points, stress):
        return MyLaw(...)          # an object with the interface of `hybrid.laws`

    hybrid.run(scene, law=clay)    # or hybrid.build(scene, law=clay)

The function is called once and returns the law of all points: `points` are PointConstants (position, half_width,
volume, mass), `stress` (n, 3) [Pa] is the initial stress along x, y and z. The shapes of the law's results are
checked at every call; a point with a result that is not a finite number counts as failed, so that the increment is
halved. Check a new law with `hybrid.check_law` first: it compares the tangent with finite differences.
demos/user_law.py is an example.

On several processes each calls the function with its own points, again when points have come or gone. So what it gives a
point must depend on this point alone, and not on the number of points or their order; at the start each process checks
this with halves of its points. Start the script by
`mpirun -n 2 python -m mpi4py SCRIPT`, which ends all processes where one fails.
"""

import numpy as np

from hybrid.laws import Response
from hybrid.runtime.errors import LawError
from hybrid.state import PointConstants

MEMBERS = ("young", "plastic", "respond", "energy", "strain")
# Values of a point, in a row of `CheckedLaw`
FIELDS = {"position": slice(0, 3), "half_width": slice(3, 6), "volume": 6, "mass": 7}
TRIED = (0.0, 0.0, 0.0), (-0.03, 0.01, 0.005)   # strains beyond that at rest, at which the law of some points is compared
SAME = 1e-9         # [-] difference that round-off explains


class CheckedLaw:
    """A user's law of `n` points whose results are checked. Its tangents are taken for unsymmetric, because a law that
    is derived from another one inherits `symmetric` from it, right or wrong; so it does `parameters` and others. rows:
    (n, 11) what the user's function `make` was given of each point: FIELDS and its initial stress."""

    symmetric = opens = hardens = undrained = False
    parameters = None

    def __init__(self, law, n, make=None, rows=None):
        self.law, self.n, self.make, self.rows = law, n, make, rows
        self.young, self.plastic = _array(law.young, (n,), "young"), bool(law.plastic)
        self.name = type(law).__name__

    def with_rows(self, rows):
        """The law that the user's function gives for other points."""
        points = PointConstants(**{name: rows[:, at].copy() for name, at in FIELDS.items()})
        return CheckedLaw(self.make(points, rows[:, 8:].copy()), len(rows), self.make, rows)

    def respond(self, strain, plastic_strain):
        return checked_response(self.law, strain, plastic_strain)

    def energy(self, elastic):
        return _array(self.law.energy(elastic), (self.n,), "energy(elastic)")

    def strain(self, stress):
        return _array(self.law.strain(stress), (self.n, 3), "strain(stress)")


def made(make, points, stress):
    """CheckedLaw that a user's function gives for `points` (PointConstants) with an initial `stress` (n, 3) [Pa]."""
    rows = np.column_stack([getattr(points, name) for name in FIELDS] + [stress])
    law = adopt(make(points, stress.copy()), len(points))
    return CheckedLaw(law.law, law.n, make, rows)


def is_of_user(law):
    """Whether a law is a user's, which is not known for points that are not those of the scene, as halves of them."""
    return isinstance(law, CheckedLaw)


def refuse_unlike(law):
    """LawError where a CheckedLaw of some points is another one for the lower or the upper half of them along an axis:
    what a process makes of its points has to be what one process makes of all."""
    rest = law.strain(law.rows[:, 8:])
    for half in _halves(law.rows[:, FIELDS["position"]]):
        part = law.with_rows(law.rows[half])
        for more in TRIED:
            whole, some = law.respond(rest + more, np.zeros(law.n)), part.respond(rest[half] + more, np.zeros(part.n))
            scale = SAME * np.abs(np.nan_to_num(whole.stress)).max(initial=0.0)
            if not np.allclose(whole.stress[half], some.stress, rtol=0.0, atol=scale, equal_nan=True):
                raise LawError(f"--ranks: {law.name} of some of the points is not that of all points there. Each process "
                               "calls its function with the points that it has: make what it gives a point depend on "
                               "this point alone, such as on its position, or run on one rank")


def _halves(position):
    """Yields (n,) bool, points in the lower and the upper half of their range along each axis, where there are some in
    both."""
    for x in position.T:
        lower = x < 0.5 * (x.min(initial=np.inf) + x.max(initial=-np.inf))
        if lower.any() and not lower.all():
            yield lower
            yield ~lower


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
