"""Tangent of the soil: of a point against differences of the stress, assembled against the internal force."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from tiled import tile
from yield_surface import yield_function

from hybrid.body.attitude import exp_so3
from hybrid.grid.axes import graded_nodes, make_grid
from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.laws.hencky import Hencky
from hybrid.laws.von_mises import VonMises
from hybrid.laws.willam_warnke import WillamWarnke
from hybrid.linalg.stencil_pattern import make_pattern
from hybrid.scene import Material, Solver
from hybrid.setup.build import build
from hybrid.soil.model import Soil
from hybrid.soil.points import at_rest
from hybrid.soil.principal import from_principal, principal
from hybrid.soil.stiffness import KeptStiffness, add_stiffness
from hybrid.soil.tangent import point_tangent, pulled_back
from hybrid.soil.workspace import SoilWorkspace
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import soil_scene

YOUNG = 1e6
LAWS = {
    "hencky": lambda n: Hencky(np.full(n, YOUNG), 0.3),
    "drucker-prager": lambda n: DruckerPrager(np.full(n, YOUNG), 0.3, 30.0, 5.0, 2e3),
    "von-mises": lambda n: VonMises(np.full(n, YOUNG), 0.3, 2e3, hardening=-2e3, residual_strength=5e2),
    "willam-warnke": lambda n: WillamWarnke(np.full(n, YOUNG), 0.3, 30.0, 5.0, 2e3, hardening=1e4),
}
SAND = ("drucker-prager", "willam-warnke")
FREE = dict.fromkeys(("x_min", "x_max", "y_min", "y_max", "z_min", "z_max"), "free")
ROTATION = exp_so3([0.4, -1.1, 0.7])

# principal logarithmic trial strains, apart, in pairs, all equal; compression keeps sand off the apex
STRAINS = {
    "distinct": (0.05, -0.12, -0.02),
    "pair": (0.02, 0.02, -0.12),
    "other pair": (0.08, -0.07, -0.07),
    "almost a pair": (0.02, 0.02 + 1e-8, -0.12),
    "barely apart": (0.02, 0.02 + 1e-11, -0.12),
    "nearly a pair": (0.02, 0.02 + 3e-7, -0.12),
    "close": (0.02, 0.02 + 1e-4, -0.12),
    "isotropic": (-0.04, -0.04, -0.04),
    "undeformed": (0.0, 0.0, 0.0),
}


def kirchhoff(law, b):
    """Kirchhoff stress (3, 3) of one point from its trial b (3, 3), and what led to it."""
    values, (vectors,) = principal(b[None])
    strain = 0.5 * np.log(values)
    response = law.respond(strain)
    return from_principal(response.stress, vectors[None])[0], strain[0], vectors, response


def difference(law, b, h=1e-6):
    """∂τ_ij/∂l_kl by central differences of b <- (1 + h l) b (1 + h l)^T, (9, 9)."""
    columns = []
    for kl in range(9):
        l = np.zeros(9)
        l[kl] = h
        l = l.reshape(3, 3)
        there = [kirchhoff(law, (np.eye(3) + s * l) @ b @ (np.eye(3) + s * l).T)[0] for s in (1, -1)]
        columns.append(((there[0] - there[1]) / (2 * h)).ravel())
    return np.array(columns).T


def point_tangent_of(law, b, inverse=np.eye(3)):
    """A (9, 9) of one point; pulled back where an increment's `inverse` is given."""
    _, strain, directions, response = kirchhoff(law, b)
    A, work, second = np.empty(81), np.empty((3, 81)), np.empty((3, 3))
    pulled_back(inverse, directions, second)
    point_tangent(directions, second, strain, response.stress[0], response.tangent[0], A, work)
    return A.reshape(9, 9)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", STRAINS)
def test_tangent_of_a_point(law, name):
    """A_ijkl + τ_il δ_jk is the derivative of the Kirchhoff stress, also where principal values meet."""
    law = LAWS[law](1)
    b = ROTATION @ np.diag(np.exp(2 * np.array(STRAINS[name]))) @ ROTATION.T
    stress = kirchhoff(law, b)[0]
    A = point_tangent_of(law, b)
    geometric = np.einsum("il,jk->ijkl", stress, np.eye(3)).reshape(9, 9)
    assert np.abs(A + geometric - difference(law, b)).max() < 2e-9 * YOUNG


def test_tangent_of_a_point_pulled_back():
    """Â_imkn = ΔF^-1_mj A_ijkl ΔF^-1_nl."""
    law, inverse = LAWS["drucker-prager"](1), np.eye(3) + 0.2 * np.random.default_rng(1).standard_normal((3, 3))
    b = ROTATION @ np.diag(np.exp(2 * np.array(STRAINS["distinct"]))) @ ROTATION.T
    A = point_tangent_of(law, b).reshape(3, 3, 3, 3)
    expected = np.einsum("mj,ijkl,nl->imkn", inverse, A, inverse).reshape(9, 9)
    np.testing.assert_allclose(point_tangent_of(law, b, inverse), expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("law", ["drucker-prager", "von-mises", "willam-warnke"])
def test_strains_are_plastic(law):
    law = LAWS[law](1)
    for name, strain in STRAINS.items():
        response = law.respond(np.array([strain]))
        flow = np.abs(np.array([strain]) - response.elastic).max()
        assert response.tangent.any() and (flow > 1e-3) == (name not in ("isotropic", "undeformed"))


def block(law, basis="gimp", plane=False, seed=3, fbar=False):
    """A graded block of soil with displaced points and committed strains, and trial increments."""
    rng = np.random.default_rng(seed)
    fine = graded_nodes(0.0, 1.2, 0.2, (0.4, 0.8), 1.5)
    middle = np.array([0.5]) if plane else fine
    extent = np.array([(0.0, 1.2), (0.0, 1.0 if plane else 1.2), (-0.8, 0.4)])
    faces = FREE | {"z_min": "fixed", "x_min": "roller"}
    grid = make_grid((fine, middle, np.linspace(-0.8, 0.4, 7)), extent, faces)
    constants = tile(grid, extent[:, 0], np.array([*extent[:2, 1], 0.0]), (2, 2, 2), 1800.0)
    n = len(constants)
    soil = Soil(grid, constants, LAWS[law](n), basis=basis, fbar=fbar)
    strain = -0.004 + 0.001 * rng.standard_normal((n, 3))
    points = at_rest(constants, np.zeros((n, 3)), strain)
    points.plastic_strain = np.random.default_rng(seed + 1).uniform(0.0, 0.5, n)
    turns = np.array([np.eye(3) if plane else exp_so3(v) for v in rng.standard_normal((n, 3))])
    points.b_elastic = turns @ points.b_elastic @ turns.transpose(0, 2, 1)
    room = np.minimum(points.position - extent[:, 0], extent[:, 1] - points.position) - points.half_width
    shift = rng.uniform(-0.04, 0.04, (n, 3)) * ~grid.collapsed
    points.position = points.position + np.clip(shift, -np.maximum(room, 0), np.maximum(room, 0))
    displacement = 3e-3 * rng.standard_normal((grid.node_count, 3))
    displacement[grid.fixed] = 0.0
    return soil, soil.begin(points, np.zeros(3)), displacement


def stiffness(soil, step, displacement, law=None):
    """Stiffness on the free unknowns (sparse) and the pattern; `law` may give another, wrong tangent."""
    trial = soil.evaluate(step, displacement)
    if law is not None:
        wrong = law.respond(trial.strain.strain)
        trial = SimpleNamespace(strain=trial.strain, response=SimpleNamespace(
            stress=trial.response.stress, tangent=wrong.tangent))
    pattern = make_pattern(step.active, soil.grid.fixed, soil.grid.shape)
    values = np.zeros(len(pattern.indices))
    soil.add_stiffness(step, trial, pattern, values)
    return csr_matrix((values, pattern.indices, pattern.indptr)), pattern


def observed_rate(soil, step, displacement, K, free):
    """Rate at which |f(u + h d) - f(u) - h K d| falls with h."""
    d = np.zeros_like(displacement)
    d[free] = np.random.default_rng(8).standard_normal(np.count_nonzero(free))
    start = soil.evaluate(step, displacement).force[free].copy()
    sizes, left = 2e-7 / 2.0 ** np.arange(4), []   # so small that hardly a point crosses the edge of yielding
    for h in sizes:
        there = soil.evaluate(step, displacement + h * d).force[free]
        left.append(np.linalg.norm(there - start - h * (K @ d[free])))
    return np.polyfit(np.log(sizes), np.log(left), 1)[0]


CASES = [(basis, plane, fbar) for fbar in (False, True) for basis, plane in
         (("gimp", False), ("mpm", False), ("gimp", True))]
IDS = [f"{name}{fbar}" for fbar in ("", " f-bar") for name in ("gimp", "mpm", "plane strain")]


@pytest.mark.parametrize("basis, plane, fbar", CASES, ids=IDS)
@pytest.mark.parametrize("law", LAWS)
def test_stiffness_is_the_derivative_of_the_internal_force(law, basis, plane, fbar):
    soil, step, displacement = block(law, basis, plane, fbar=fbar)
    K, pattern = stiffness(soil, step, displacement)
    assert observed_rate(soil, step, displacement, K, pattern.free) == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize("law", SAND)
def test_the_block_of_sand_yields_in_part(law):
    soil, step, displacement = block(law)
    trial = soil.evaluate(step, displacement)
    flow = np.abs(trial.strain.strain - trial.response.elastic).max(axis=1) > 1e-9
    apex = np.ptp(trial.response.stress, axis=1) == 0
    assert 0.2 < flow.mean() < 0.95 and 0.02 < apex.mean() < 0.5


@pytest.mark.parametrize("law", ["von-mises", "drucker-prager", "willam-warnke"])
def test_accepted_points_lie_on_the_yield_surface_of_their_accumulated_strain(law):
    """What the soil adds up is what the law hardened by."""
    soil, step, displacement = block(law)
    trial = soil.evaluate(step, displacement)
    flow = np.abs(trial.strain.strain - trial.response.elastic).max(axis=1) > 1e-9
    zero = np.zeros_like(displacement)
    new = soil.accept(step, trial, displacement, zero, zero)
    kirchhoff = trial.response.stress[flow]
    found = yield_function(soil.law, trial.response.stress, new.plastic_strain)[flow]
    assert flow.any() and np.abs(found).max() < 1e-10 * np.abs(kirchhoff).max()
    assert np.all(new.plastic_strain[flow] > step.points.plastic_strain[flow])
    stale = yield_function(soil.law, trial.response.stress, step.points.plastic_strain)[flow]
    assert soil.law.hardens == (np.abs(stale).max() > 1e-6 * np.abs(kirchhoff).max())


@pytest.mark.parametrize("law", LAWS)
def test_slope_test_fails_without_geometric_or_plastic_terms(law):
    """The elastic tangent is wrong where the sand yields; without stress the geometric terms are missing."""
    soil, step, displacement = block(law)
    if law != "hencky":
        K, pattern = stiffness(soil, step, displacement, LAWS["hencky"](len(soil.constants)))
    else:
        trial = soil.evaluate(step, displacement)
        pattern = make_pattern(step.active, soil.grid.fixed, soil.grid.shape)
        values = np.zeros(len(pattern.indices))
        add_stiffness(step, soil.grid, trial.strain, 0 * trial.response.stress,
                      trial.response.tangent, soil.constants.volume, pattern, values)
        K = csr_matrix((values, pattern.indices, pattern.indptr))
    assert observed_rate(soil, step, displacement, K, pattern.free) < 1.2


@pytest.mark.parametrize("basis, plane, fbar", CASES, ids=IDS)
def test_stiffness_is_symmetric_for_associated_flow_only(basis, plane, fbar):
    for law, symmetric in (("hencky", True), ("von-mises", True), ("drucker-prager", False), ("willam-warnke", False)):
        K, _ = stiffness(*block(law, basis, plane, fbar=fbar))
        skewness = abs(K - K.T).max() / abs(K).max()
        assert skewness < 1e-13 if symmetric else skewness > 1e-3


@pytest.mark.parametrize("fbar", [False, True])
@pytest.mark.parametrize("law", LAWS)
def test_kept_tangent_follows_the_trial(law, fbar):
    """Brought from one trial to another it is the tangent of the second; with a tolerance, of the points that changed
    by more than that. Without bringing it up to date it is not."""
    soil, step, displacement = block(law, fbar=fbar)
    pattern = make_pattern(step.active, soil.grid.fixed, soil.grid.shape)

    def filled(tolerance, *trials):
        workspace = SoilWorkspace(soil)
        workspace.kept = KeptStiffness(tolerance, soil.law.young, fbar)
        begun = replace(step, workspace=workspace)
        values = np.empty(len(pattern.indices))
        for u in trials:
            soil.fill_stiffness(begun, soil.evaluate(begun, u), pattern, values)
        return values

    other = 1.05 * displacement
    expected = stiffness(soil, step, other)[0].data
    scale = np.abs(expected).max()
    assert np.abs(filled(0.0, displacement, other) - expected).max() < 1e-12 * scale
    assert 1e-12 * scale < np.abs(filled(1e-2, displacement, other) - expected).max() < 5e-2 * scale
    assert np.abs(filled(1e9, displacement, other) - expected).max() > 1e-3 * scale
    assert np.array_equal(filled(1e9, displacement, other), filled(1e9, displacement))


@pytest.mark.parametrize("fbar", [False, True])
def test_a_new_increment_assembles_points_that_are_where_they_were(fbar):
    soil, step, displacement = block("drucker-prager", fbar=fbar)
    pattern = make_pattern(step.active, soil.grid.fixed, soil.grid.shape)
    workspace = SoilWorkspace(soil)
    workspace.kept = KeptStiffness(0.0, soil.law.young, fbar)
    filled = []
    for _ in range(2):
        increment = replace(step, workspace=workspace)
        filled.append(np.empty(len(pattern.indices)))
        soil.fill_stiffness(increment, soil.evaluate(increment, displacement), pattern, filled[-1])
    assert np.array_equal(*filled) and np.any(filled[0])


def test_slope_test_fails_without_the_terms_of_fbar():
    soil, step, displacement = block("hencky", fbar=True)
    pattern = make_pattern(step.active, soil.grid.fixed, soil.grid.shape)
    values = np.zeros(len(pattern.indices))
    soil.add_stiffness(replace(step, mean=None), soil.evaluate(step, displacement), pattern, values)
    K = csr_matrix((values, pattern.indices, pattern.indptr))
    assert observed_rate(soil, step, displacement, K, pattern.free) < 1.2


@pytest.mark.parametrize("plane", [False, True])
@pytest.mark.parametrize("fbar", [False, True])
def test_internal_force_is_the_gradient_of_the_stored_energy(fbar, plane):
    soil, step, displacement = block("hencky", plane=plane, fbar=fbar)
    d = np.random.default_rng(8).standard_normal(displacement.shape) * ~soil.grid.fixed
    h = 2e-6

    def energy(u):
        trial = soil.evaluate(step, u)
        return np.sum(soil.law.energy(trial.strain.strain) * soil.constants.volume)

    power = np.sum(soil.evaluate(step, displacement).force * d)
    slope = (energy(displacement + h * d) - energy(displacement - h * d)) / (2 * h)
    assert slope == pytest.approx(power, rel=1e-7)


def test_translation_of_free_soil_meets_no_resistance():
    """Row sums vanish in every component, stressed or not, apart from the rows next to held nodes."""
    for law, fbar in itertools.product(LAWS, (False, True)):
        soil, step, displacement = block(law, fbar=fbar)
        K, pattern = stiffness(soil, step, displacement)
        away = np.zeros(soil.grid.shape, bool)
        away[3:, :, 3:] = True                          # two nodes away from the held faces x_min, z_min
        for k in range(3):
            shift, force = np.zeros_like(displacement), np.zeros_like(displacement)
            shift[:, k] = 1.0
            force[pattern.free] = K @ shift[pattern.free]
            assert np.abs(force[away.ravel()]).max() < 1e-12 * abs(K).max() < np.abs(force).max()


def test_a_share_of_the_elastic_stiffness_is_mixed_in():
    """K(s) = (1 - s) K + s K_elastic, where points flow."""
    def stiffness(share, **law):
        material = Material(young=YOUNG, poisson=0.3, density=1800.0, **law)
        described = soil_scene(gravity=(0.0, 0.0, -9.81), solver=Solver(tangent_tolerance=0.0))
        simulation = build(replace(described, soil=replace(described.soil, material=material)))
        step = begin(simulation.model, simulation.state, 0.01, False, Workspace(simulation.model))
        shaken = 0.004 * np.random.default_rng(0).normal(size=step.predictor().displacement.shape)
        evaluation = step.evaluate(replace(step.predictor(), displacement=shaken))
        step.assemble(evaluation, elastic=share)
        return step.system.values.copy()

    sand = {"law": "drucker-prager", "friction_angle": 30.0, "dilation_angle": 5.0, "cohesion": 1e3}
    none, some, more = (stiffness(share, **sand) for share in (0.0, 0.3, 0.9))
    np.testing.assert_allclose(some - none, (more - none) / 3, atol=1e-9 * np.abs(none).max())
    assert np.abs(more - none).max() > 0.01 * np.abs(none).max()
