"""Check of a law: tangent against central differences, stress against energy, sign of plastic work, consistency.

    ∂τ_i/∂ε_j ≈ [τ_i(ε + h e_j) - τ_i(ε - h e_j)] / 2h        τ = ∂ψ/∂ε_e        τ · Δε_p >= 0

Where the one-sided differences differ by more than KINK times the stiffness, the stress has a kink (onset of yielding,
apex); the tangent is not unique there and is not compared.
"""

import numpy as np

from hybrid.laws import plastic_increment
from hybrid.laws.user import checked_response
from hybrid.runtime.errors import LawError

KINK = 1e-2  # of the stiffness: difference of the one-sided differences


def check_law(law, strain, plastic_strain=None, step=1e-8, tolerance=1e-6):
    """Check a law of n points at trial principal strains (n, 3) and accumulated plastic strains (n,), zero if left out.

    step: h; tolerance: of the tangent, relative to the largest stiffness. Returns the largest relative error of the
    tangent. Raises LawError with the worst point if

    - the tangent is not the derivative of the stress,
    - the stress is not the derivative of the energy at the elastic strain, or `strain` is not the inverse of that,
    - plastic work is negative,
    - the response is not final: evaluated at the elastic strain and plastic strain that it returned, the law must
      return the same stress.
    """
    strain = np.array(strain, float)
    n = len(strain)
    if strain.shape != (n, 3) or np.shape(law.young) != (n,):
        raise LawError(f"strain has shape {strain.shape} and law.young {np.shape(law.young)}: must be (n, 3) and (n,)")
    history = np.zeros(n) if plastic_strain is None else np.array(plastic_strain, float)
    response = checked_response(law, strain, history)
    if response.failed.any():
        raise LawError(f"no stress at point {_point_text(np.argmax(response.failed), strain, history)}")
    scale = max(np.abs(response.tangent).max(), np.abs(checked_response(law, 0 * strain, history).tangent).max())
    _energy(law, response, strain, history, scale)
    _flow(law, response, strain, history, scale)
    return _tangent(law, response, strain, history, step, tolerance, scale)


def _tangent(law, response, strain, history, step, tolerance, scale):
    columns, smooth = [], np.ones(len(strain), bool)
    for e in np.eye(3):
        up, down = (checked_response(law, strain + s * step * e, history).stress for s in (1, -1))
        columns.append((up - down) / (2 * step))
        smooth &= np.abs(up - 2 * response.stress + down).max(axis=1) < KINK * scale * step
    if smooth.sum() < 0.5 * len(strain):
        raise LawError(f"{(~smooth).sum()} of {len(strain)} strains are at kinks of the law, or the stress jumps; "
                       "choose other strains or a smaller step")
    difference = np.stack(columns, axis=2)
    error = np.where(smooth, np.abs(difference - response.tangent).max(axis=(1, 2)), 0.0) / scale
    p = int(np.argmax(error))
    if error[p] > tolerance:
        raise LawError(f"the tangent is off by {error[p]:.2g} of the stiffness (limit {tolerance:g}) at point "
                       f"{_point_text(p, strain, history)}: it is {_rows(response.tangent[p])}, differences give "
                       f"{_rows(difference[p])} Pa")
    return float(error[p])


def _energy(law, response, strain, history, scale):
    """The stress is the gradient of the energy at the elastic strain, and `strain` is the inverse of that."""
    elastic, h = response.elastic, 1e-6
    columns = [(law.energy(elastic + h * e) - law.energy(elastic - h * e)) / (2 * h) for e in np.eye(3)]
    gradient = np.stack(columns, axis=1)
    limit = 1e-6 * scale * h + 1e-6 * np.abs(response.stress).max()
    _require_small(np.abs(gradient - response.stress), limit, strain, history,
                   "the stress is not the derivative of the energy at the elastic strain", "Pa")
    _require_small(np.abs(law.strain(response.stress) - elastic), 1e-9, strain, history,
                   "strain(stress) is not the elastic strain that carries the stress", "")


def _flow(law, response, strain, history, scale):
    """Plastic work is not negative, and the returned state is admissible."""
    work = np.sum(response.stress * (strain - response.elastic), axis=1)
    _require_small(-work[:, None], 1e-14 * scale * np.abs(strain).max(), strain, history,
                   "plastic flow gains energy", "J/m³")
    again = checked_response(law, response.elastic, history + plastic_increment(strain, response.elastic))
    limit = 1e-9 * np.abs(response.stress).max() + 1e-14 * scale
    _require_small(np.abs(again.stress - response.stress), limit, strain, history,
                   "the response is not final: the law returns another stress at the elastic and plastic strain that "
                   "it returned", "Pa")


def _require_small(error, limit, strain, history, words, unit):
    p = int(np.argmax(error.max(axis=1)))
    if error[p].max() > limit:
        raise LawError(f"{words}: off by {error[p].max():.3g} {unit} (limit {limit:.2g}) at point "
                       f"{_point_text(p, strain, history)}")


def _point_text(p, strain, history):
    return f"{p}, trial strain ({', '.join(f'{e:.6g}' for e in strain[p])}) after plastic strain {history[p]:.4g}"


def _rows(matrix):
    return "[" + "; ".join(" ".join(f"{value:.5g}" for value in row) for row in matrix) + "]"
