"""Return mapping to a cone in principal stress, including its apex; von Mises, Drucker-Prager, Mohr-Coulomb and
Willam-Warnke are special cases (FORMULATION (15) to (18)).

    f = g(θ) √J2(s) + η p - k(α)        p = tr τ / 3, tension positive
    k(α) = max(k0 + h α, k_r)           linear hardening (h > 0) or softening to a residual strength
    Δε_p = Δγ (s / 2√J2 + η̄ 1 / 3)      η̄ = η̄_c / g(θ, ē)      Δα = Δγ/√3

The section g(θ) is 1 on a circular cone. Willam and Warnke (IABSE Proc. 19, 1974) close it by a smooth, convex arc
that depends on the ratio e of the extension meridian to the compression meridian, 1/2 < e <= 1:

    g = [4 (1-e²) cos²θ + (2e-1)²] / [2 (1-e²) cosθ + (2e-1) √(4 (1-e²) cos²θ + 5e² - 4e)]      cos 3θ = 3√3/2 J3/J2^1.5

from 1/e in extension (θ = 0) to 1 in compression (θ = 60°). Mohr and Coulomb's is the straight line between these, with the
foot of its normal at θ_0, and within ω of both a parabola that ends level (corners rounded off, C1):

    g = cos(θ - θ_0)/(e sin60° / √((e - 1/2)² + 3/4))        tan θ_0 = (e - 1/2)/sin60°

Dilation has a section of its own, with a ratio ē. Flow is along the deviator, so θ is that of the trial state and the return
has a closed form for any section, without iteration (a circular cone has the potential √J2 + η̄ p):

    Δγ = f_trial / (g G + K η η̄ + h/√3)      s = (1 - GΔγ/√J2_tr) s_tr      p = p_tr - K η̄ Δγ

Where k reaches k_r within the increment, the same holds with k = k_r and h = 0. Where the deviator would change its
sign, the stress returns to the apex p = k/η. The whole trial deviator is then plastic, Δα = √(2/3 e_tr:e_tr), so the
apex has a closed form too.
The algorithmic tangent follows by differentiation (circular, without hardening, it is that of de Souza Neto, Perić and
Owen, Computational Methods for Plasticity, 2008, section 8.3). With n = e_tr/|e_tr|, m normal to it in the deviatoric
plane towards larger θ and D the denominator of Δγ,

    ∂Δγ/∂ε = [√2 G g n + ((√J2_tr - GΔγ) g' - K η η̄' Δγ) m/|e_tr| + η K 1] / D
    ∂τ/∂ε = 2G (1 - GΔγ/√J2_tr) (I - 1⊗1/3) + K 1⊗1 + 2 G²Δγ/√J2_tr n⊗n - (√2 G n + K η̄ 1) ⊗ ∂Δγ/∂ε
            - K η̄' Δγ/|e_tr| 1⊗m
    ∂τ/∂ε = √(2/3) h/η 1⊗n        at the apex

Equations: FORMULATION (15) to (18).
"""

import copy

import numpy as np

from hybrid.laws import Response
from hybrid.laws.hencky import Hencky, stored
from hybrid.runtime.errors import LawError
from hybrid.runtime.jit import njit, prange

ETA, ETA_BAR, STRENGTH, RATIO, SLOPE, RESIDUAL, DILATION_RATIO, CORNER, XI = range(2, 11)     # columns of `parameters`
UNLIMITED = 1e300  # [Pa] strength of points that never yield
ROUND_OFF = 1e-14   # length of a deviator that is round-off, over the trace
NO_HISTORY = np.zeros(0)


class Cone(Hencky):
    """Elastic constants, cohesion c, its hardening and its floor per point, scalars or (n,) arrays; `young` fixes n.

    parameters: (n, 11) columns K, G, η, η̄_c, k0, e, h, k_r, ē, ω (0: the arc of Willam and Warnke), ξ, with k = ξ c of a
    cohesion c. Raises LawError where softening is steeper than the elastic unloading, so that a point has no unique
    response.
    """

    plastic = True

    def __init__(self, young, poisson, eta, eta_bar, cohesion, ratio=1.0, hardening=0.0, residual=0.0,
                 dilation_ratio=1.0, corner=0.0, xi=1.0):
        super().__init__(young, poisson)
        n = len(self.parameters)
        strength, hardening, residual = (xi * np.asarray(a, float) for a in (cohesion, hardening, residual))
        residual = np.minimum(residual, strength)
        columns = [np.broadcast_to(a, n) for a in (
            eta, eta_bar, strength, ratio, hardening, residual, dilation_ratio, corner, xi)]
        self._set(np.column_stack([self.parameters, *columns]))

    def _set(self, parameters):
        self.parameters = parameters
        K, G, eta, eta_bar, _, _, slope, _, dilation_ratio, *_ = parameters.T
        self.hardens = bool(np.any(slope != 0.0))
        steepest = slope / np.sqrt(3) + G + K * eta * eta_bar * dilation_ratio
        if np.any(steepest <= 0.0):
            p = int(np.argmin(steepest))
            raise LawError(f"soil.material.hardening: softening of k by {-slope[p]:.3g} Pa per plastic strain is more "
                             f"than √3 (G + K η η̄) = {-slope[p] + np.sqrt(3) * steepest[p]:.3g} Pa, beyond which a "
                             f"point snaps back; use a hardening nearer to 0")

    @property
    def symmetric(self):
        """Whether all tangents are symmetric: associated flow on a circular cone, without hardening of an apex."""
        _, _, eta, eta_bar, _, ratio, slope, _, dilation_ratio, corner, _ = self.parameters.T
        circular = (ratio == 1.0) & (dilation_ratio == 1.0) & (corner == 0.0)
        apex = eta * slope != 0.0
        return bool(np.all((eta == eta_bar) & circular & ~apex))

    def respond(self, strain, plastic_strain=None):
        """Response to trial principal strains (n, 3) after accumulated plastic strain (n,), zero if left out."""
        history = NO_HISTORY
        if self.hardens:
            history = np.zeros(len(strain)) if plastic_strain is None else plastic_strain
        stress, elastic, tangent = np.empty_like(strain), np.empty_like(strain), np.empty((len(strain), 3, 3))
        opened = np.zeros(len(strain))
        _return_map(strain, history, self.parameters, stress, elastic, tangent, opened)
        return Response(stress, elastic, tangent, opened=opened)

    def energy(self, elastic):
        return stored(elastic, self.parameters)

    def cohesion(self, plastic_strain):
        """k(α) (n,) [Pa] after accumulated plastic strain, (n,) or a number."""
        strength, slope, residual = self.parameters.T[[STRENGTH, SLOPE, RESIDUAL]]
        return np.maximum(strength + slope * plastic_strain, residual)

    @property
    def opens(self):
        """(n,) bool, points whose cone has an apex."""
        return self.parameters[:, ETA] > 0.0

    def without_dilation(self, ids):
        """The law of some of the points, whose flow keeps the volume."""
        other = copy.copy(self)
        other.young, other.parameters = self.young[ids], self.parameters[ids]
        other.parameters[:, ETA_BAR] = 0.0
        return other

    @property
    def undrained(self):
        """(n,) bool, points of clay, whose strength no pressure changes: von Mises' cone, or Tresca's prism."""
        return (self.parameters[:, ETA] == 0.0) & (self.parameters[:, STRENGTH] < UNLIMITED)

    def shear_strength(self, plastic_strain):
        """c(α), of clay s_u(α), (n,) [Pa] after accumulated plastic strain, (n,) or a number: k/ξ."""
        return self.cohesion(plastic_strain) / self.parameters[:, XI]


def merge(laws, members):
    """One law from laws of parts of the points; members: their point ids. A Cone if any of them is plastic."""
    n = sum(len(ids) for ids in members)
    whole = Cone.__new__(Cone) if any(law.plastic for law in laws) else Hencky.__new__(Hencky)
    rows = [_rows(law, whole.plastic) for law in laws]
    whole.young, parameters = np.empty(n), np.empty((n, rows[0].shape[1]))
    for law, ids, own in zip(laws, members, rows):
        whole.young[ids], parameters[ids] = law.young, own
    if whole.plastic:
        whole._set(parameters)
    else:
        whole.parameters = parameters
    return whole


def _rows(law, plastic):
    """Parameters of a law; an elastic law gets an unlimited strength where other points are `plastic`."""
    if law.plastic or not plastic:
        return law.parameters
    unlimited = np.tile([0.0, 0.0, UNLIMITED, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0], (len(law.parameters), 1))
    return np.column_stack([law.parameters, unlimited])


def plane_strain_strength(parameters):
    """(friction angle [degrees], cohesion over that given, dilation angle [degrees]) in plane strain, where plastic flow
    leaves the thickness alone, of one row of `parameters`.

    The middle deviator is then s_2 = -2/3 η̄ √J2. With r = √(1 - η̄²/3) / (g - η η̄/3), and g and η̄ of its Lode angle,
    sin φ = η r, c cos φ = ξ r times the cohesion given, and sin ψ = η̄ / √(1 - η̄²/3).
    """
    _, _, eta, compressed, _, ratio, _, _, dilation_ratio, corner, xi = np.asarray(parameters, float)
    g, eta_bar = 1.0, compressed
    for _ in range(60 if ratio < 1.0 or dilation_ratio < 1.0 else 0):
        middle = -2 / 3 * eta_bar
        radius = np.sqrt(1 - eta_bar**2 / 3)
        deviator = np.array([radius - middle / 2, middle, -radius - middle / 2])     # of √J2 = 1
        g = _section(deviator, np.sqrt(2.0), ratio, corner)[0]
        eta_bar = compressed / _section(deviator, np.sqrt(2.0), dilation_ratio, corner)[0]
    root = np.sqrt(1 - eta_bar**2 / 3) / (g - eta * eta_bar / 3)
    angle = np.arcsin(min(eta * root, 1.0))
    dilation = np.arcsin(min(eta_bar / np.sqrt(1 - eta_bar**2 / 3), 1.0))
    return float(np.degrees(angle)), float(xi * root / np.cos(angle)), float(np.degrees(dilation))


@njit(cache=True)
def _section(e, norm, ratio, corner):
    """g and dg/dθ of a deviator `e` (3,) of length `norm`; corner: ω [rad], 0: the arc of Willam and Warnke."""
    if norm == 0.0:
        return 1.0, 0.0
    high, low = max(e[0], e[1], e[2]), min(e[0], e[1], e[2])
    cos = min(np.sqrt(1.5) * high / norm, 1.0)
    sin = max(-high - 2 * low, 0.0) / (np.sqrt(2.0) * norm)     # from the middle value less the lowest
    if corner > 0.0:
        return _line(np.arctan2(sin, cos), ratio, corner)
    a, b = 1 - ratio * ratio, 2 * ratio - 1
    root = np.sqrt(4 * a * cos * cos + 5 * ratio * ratio - 4 * ratio)
    above, below = 4 * a * cos * cos + b * b, 2 * a * cos + b * root
    d_above, d_below = -8 * a * cos * sin, -2 * a * sin - 4 * a * b * cos * sin / root
    return above / below, (d_above - above / below * d_below) / below


@njit(cache=True)
def _line(theta, ratio, corner):
    """g and dg/dθ of Mohr and Coulomb's section at θ [rad], rounded off within `corner` [rad] of its ends."""
    foot = np.arctan2(ratio - 0.5, np.sqrt(0.75))
    height = ratio * np.sqrt(0.75) / np.hypot(ratio - 0.5, np.sqrt(0.75))
    end = 0.0 if theta < np.pi / 6 else np.pi / 3
    inner = end + corner if end == 0.0 else end - corner
    if abs(theta - end) >= corner:
        return np.cos(theta - foot) / height, -np.sin(theta - foot) / height
    bend = -np.sin(inner - foot) / height / (2 * (inner - end))
    return np.cos(inner - foot) / height + bend * ((theta - end)**2 - corner**2), 2 * bend * (theta - end)


@njit(cache=True, parallel=True)
def _return_map(strain, history, parameters, stress, elastic, tangent, opened):
    hardens = len(history) > 0
    for p in prange(len(strain)):
        K, G, eta, eta_bar, k, ratio, h, residual, dilation_ratio, corner, _ = parameters[p]
        trace, e, norm = _split(strain[p])
        root = np.sqrt(2.0) * G * norm  # √J2 of the trial stress
        pressure = K * trace
        g, slope = _section(e, norm, ratio, corner) if ratio != 1.0 or corner > 0.0 else (1.0, 0.0)
        if hardens:
            k += h * history[p]
            if h < 0.0 and k <= residual:
                k, h = residual, 0.0
        excess = g * root + eta * pressure - k
        if excess <= 0.0:
            _set_elastic(stress[p], elastic[p], tangent[p], K, G, e, 1.0, pressure)
            continue
        dilation_slope = 0.0  # η̄'
        if dilation_ratio != 1.0:
            g_bar, dilation_slope = _section(e, norm, dilation_ratio, corner)
            eta_bar /= g_bar
            dilation_slope *= -eta_bar / g_bar
        elastic_part = g * G + K * eta * eta_bar
        denominator = elastic_part + h / np.sqrt(3.0) if hardens else elastic_part
        multiplier = excess / denominator
        to_residual = hardens and k + h * multiplier / np.sqrt(3.0) < residual
        if to_residual:
            denominator, multiplier = elastic_part, (excess + k - residual) / elastic_part
        if eta > 0.0 and root < G * multiplier:
            if hardens:
                k += h * np.sqrt(2.0 / 3.0) * norm
                if k < residual:
                    k, h = residual, 0.0
            _set_elastic(stress[p], elastic[p], tangent[p], K, G, e, 0.0, k / eta)
            opened[p] = trace - k / (eta * K)
            _apex_tangent(tangent[p], e, norm, np.sqrt(2.0 / 3.0) * h / eta if hardens else 0.0)
        else:
            scale = max(1.0 - G * multiplier / root, 0.0)
            _set_elastic(stress[p], elastic[p], tangent[p], K, G, e, scale, pressure - K * eta_bar * multiplier)
            mean_m = dilation_slope * (K * multiplier / norm)
            flow_m = slope * (root - G * multiplier) / norm - eta * mean_m
            _flow_tangent(tangent[p], K, G, eta, eta_bar, g, flow_m, mean_m, scale, e, norm, denominator)


@njit(cache=True)
def _split(strain):
    """Trace, deviator and its length of principal strains (3,). A deviator of round-off is none: its sum is not zero, so
    that it has no Lode angle."""
    trace = strain[0] + strain[1] + strain[2]
    e = (strain[0] - trace / 3, strain[1] - trace / 3, strain[2] - trace / 3)
    norm = np.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
    if norm <= ROUND_OFF * abs(trace):
        return trace, (0.0, 0.0, 0.0), 0.0
    return trace, e, norm


@njit(cache=True)
def _set_elastic(stress, elastic, tangent, K, G, e, scale, mean):
    """Stress, elastic strain and tangent of a deviator scaled by `scale` and a mean stress, without plastic terms."""
    for i in range(3):
        stress[i] = 2 * G * scale * e[i] + mean
        elastic[i] = scale * e[i] + mean / (3 * K)
        for j in range(3):
            tangent[i, j] = 2 * G * scale * ((1.0 if i == j else 0.0) - 1 / 3) + K


@njit(cache=True)
def _apex_tangent(matrix, e, norm, slope):
    for j in range(3):
        along = slope * e[j] / norm if norm > 0.0 else 0.0
        for i in range(3):
            matrix[i, j] = along


@njit(cache=True)
def _flow_tangent(matrix, K, G, eta, eta_bar, g, flow_m, mean_m, scale, e, norm, denominator):
    """Add the terms of plastic flow; flow_m, mean_m: factors of m in D ∂Δγ/∂ε and in -∂p/∂ε."""
    inverse, share = 1.0 / norm, 1.0 / denominator
    m = (0.0, 0.0, 0.0)
    if flow_m != 0.0 or mean_m != 0.0:  # m = (1 × n)/|1|, towards larger θ for e0 > e1 > e2; at equal values g' is zero
        order = (e[0] - e[1]) * (e[1] - e[2]) * (e[0] - e[2])
        unit = (inverse if order > 0.0 else -inverse) / np.sqrt(3.0)
        m = (unit * (e[2] - e[1]), unit * (e[0] - e[2]), unit * (e[1] - e[0]))
    for j in range(3):
        n = e[j] * inverse
        d_multiplier = (np.sqrt(2.0) * G * g * n + flow_m * m[j] + eta * K) * share
        along_n = 2 * G * (1.0 - scale) * n - np.sqrt(2.0) * G * d_multiplier
        mean = K * eta_bar * d_multiplier + mean_m * m[j]
        for i in range(3):
            matrix[i, j] += along_n * e[i] * inverse - mean
