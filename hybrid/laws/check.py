"""Is a law right? Its tangent against central differences, its stress against the energy, its flow against dissipation.

    ∂τ_i/∂ε_j ≈ [τ_i(ε + h e_j) - τ_i(ε - h e_j)] / 2h        τ = ∂ψ/∂ε_e        τ · Δε_p >= 0

Where the one-sided differences differ by a hundredth of the stiffness, the strain sits on a kink of the law (the edge
of yielding, an apex); the tangent is not unique there and is not compared.
"""

import numpy as np

from hybrid.laws import plastic_increment
from hybrid.laws.user import answer
from hybrid.runtime.errors import LawError

KINK = 1e-2  # of the stiffness, jump of a one-sided difference


def check_law(law, strain, plastic_strain=None, step=1e-8, tolerance=1e-6):
    """Check a law at trial principal strains (n, 3) after accumulated plastic strains (n,), none when left out.

    The law must be one of n points, as `young` (n,) says. step: h; tolerance: of the tangent, relative to the largest
    stiffness. Returns the largest relative error of the tangent. Raises LawError with the worst point when the tangent
    is not the derivative of the stress, the stress not that of the energy at the elastic strain, `strain` not the
    inverse of that, plastic flow gains energy, or the response is not final: asked again from what it made, the
    elastic strain and the grown plastic strain, it must give the same stress.
    """
    strain = np.array(strain, float)
    n = len(strain)
    if strain.shape != (n, 3) or np.shape(law.young) != (n,):
        raise LawError(f"strain has shape {strain.shape} and law.young {np.shape(law.young)}: must be (n, 3) and (n,)")
    history = np.zeros(n) if plastic_strain is None else np.array(plastic_strain, float)
    response = answer(law, strain, history)
    if response.failed.any():
        raise LawError(f"no stress at point {_text(np.argmax(response.failed), strain, history)}")
    scale = max(np.abs(response.tangent).max(), np.abs(answer(law, 0 * strain, history).tangent).max())
    _energy(law, response, strain, history, scale)
    _flow(law, response, strain, history, scale)
    return _tangent(law, response, strain, history, step, tolerance, scale)


def _tangent(law, response, strain, history, step, tolerance, scale):
    columns, smooth = [], np.ones(len(strain), bool)
    for e in np.eye(3):
        up, down = (answer(law, strain + s * step * e, history).stress for s in (1, -1))
        columns.append((up - down) / (2 * step))
        smooth &= np.abs(up - 2 * response.stress + down).max(axis=1) < KINK * scale * step
    if smooth.sum() < 0.5 * len(strain):
        raise LawError(f"{(~smooth).sum()} of {len(strain)} strains sit on kinks of the law, or the stress jumps; "
                       "choose other strains or a smaller step")
    difference = np.stack(columns, axis=2)
    error = np.where(smooth, np.abs(difference - response.tangent).max(axis=(1, 2)), 0.0) / scale
    p = int(np.argmax(error))
    if error[p] > tolerance:
        raise LawError(f"the tangent is off by {error[p]:.2g} of the stiffness (limit {tolerance:g}) at point "
                       f"{_text(p, strain, history)}: it is {_rows(response.tangent[p])}, differences give "
                       f"{_rows(difference[p])} Pa")
    return float(error[p])


def _energy(law, response, strain, history, scale):
    """The stress is the gradient of the energy at the elastic strain, which `strain` finds from the stress."""
    elastic, h = response.elastic, 1e-6
    columns = [(law.energy(elastic + h * e) - law.energy(elastic - h * e)) / (2 * h) for e in np.eye(3)]
    gradient = np.stack(columns, axis=1)
    _small(np.abs(gradient - response.stress), 1e-6 * scale * h + 1e-6 * np.abs(response.stress).max(), strain, history,
           "the stress is not the derivative of the energy at the elastic strain", "Pa")
    _small(np.abs(law.strain(response.stress) - elastic), 1e-9, strain, history,
           "strain(stress) is not the elastic strain that carries the stress", "")


def _flow(law, response, strain, history, scale):
    """Plastic work is not negative, and the state that a response leaves is one that the law accepts."""
    work = np.sum(response.stress * (strain - response.elastic), axis=1)
    _small(-work[:, None], 1e-14 * scale * np.abs(strain).max(), strain, history, "plastic flow gains energy", "J/m³")
    again = answer(law, response.elastic, history + plastic_increment(strain, response.elastic))
    _small(np.abs(again.stress - response.stress), 1e-9 * np.abs(response.stress).max() + 1e-14 * scale, strain,
           history, "the response is not final: the law gives another stress at its own elastic and plastic strain",
            "Pa")


def _small(error, limit, strain, history, words, unit):
    p = int(np.argmax(error.max(axis=1)))
    if error[p].max() > limit:
        raise LawError(f"{words}: off by {error[p].max():.3g} {unit} (limit {limit:.2g}) at point "
                       f"{_text(p, strain, history)}")


def _text(p, strain, history):
    return f"{p}, trial strain ({', '.join(f'{e:.6g}' for e in strain[p])}) after plastic strain {history[p]:.4g}"


def _rows(matrix):
    return "[" + "; ".join(" ".join(f"{value:.5g}" for value in row) for row in matrix) + "]"
