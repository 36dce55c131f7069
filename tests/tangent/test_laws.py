"""Laws in principal logarithmic strain: stress from energy, return to the cone, algorithmic tangents."""

import numpy as np
import pytest

from hybrid.laws.cone import ETA, ETA_BAR, STRENGTH
from hybrid.laws.drucker_prager import DruckerPrager, cone_constants
from hybrid.laws.hencky import Hencky
from hybrid.laws.sand import sand, stiffness_from_stress

YOUNG, POISSON = 20e6, 0.28
ANGLE, DILATION, COHESION = 33.0, 8.0, 5e3
COUNT = 500
CONES = "compression", "extension", "plane strain"


def law(n=COUNT, angle=ANGLE, dilation=DILATION, cohesion=COHESION, cone="compression"):
    return DruckerPrager(np.full(n, YOUNG), POISSON, angle, dilation, cohesion, cone)


def invariants(stress):
    """Mean stress and √J2 of principal stresses (n, 3)."""
    mean = stress.mean(axis=1)
    return mean, np.sqrt(0.5 * np.sum((stress - mean[:, None]) ** 2, axis=1))


def yield_function(model, stress):
    mean, root = invariants(stress)
    eta, strength = model.parameters[:, ETA], model.parameters[:, STRENGTH]
    return root + eta * mean - strength


def trial_strains(region, model, n=COUNT, seed=6):
    """Trial strains whose return ends in the elastic region, on the cone or at the apex."""
    rng = np.random.default_rng(seed)
    K, G, eta, eta_bar, strength = model.parameters[0, :5]
    direction = rng.standard_normal((n, 3))
    direction -= direction.mean(axis=1, keepdims=True)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    apex = strength / eta
    mean = apex - np.exp(rng.uniform(np.log(1e3), np.log(3e5), n))   # compression below the apex
    limit = strength - eta * mean
    root = limit * rng.uniform(0.1, 0.95, n)
    if region == "cone":
        root = limit * rng.uniform(1.05, 3.0, n)
    if region == "apex":
        excess = np.exp(rng.uniform(np.log(1e3), np.log(1e5), n))
        mean = apex + excess
        root = rng.uniform(0.0, 0.9, n) * excess * G / (K * eta_bar)
    return mean[:, None] / (3 * K) + direction * (root / (np.sqrt(2) * G))[:, None]


def difference_tangent(model, strain, h=1e-8):
    """Central differences of the stress; exact for a law that is linear between the two."""
    columns = [(model.respond(strain + h * e).stress - model.respond(strain - h * e).stress) / (2 * h)
               for e in np.eye(3)]
    return np.stack(columns, axis=2)


def test_hencky_stress_is_the_derivative_of_the_energy():
    model = Hencky(np.full(COUNT, YOUNG), POISSON)
    strain = 0.2 * np.random.default_rng(0).standard_normal((COUNT, 3))
    response, h = model.respond(strain), 1e-5
    gradient = np.stack(
        [(model.energy(strain + h * e) - model.energy(strain - h * e)) / (2 * h) for e in np.eye(3)], axis=1)
    assert np.abs(response.stress - gradient).max() < 1e-9 * np.abs(gradient).max()
    assert np.abs(response.tangent - difference_tangent(model, strain, 1e-4)).max() < 1e-9 * YOUNG
    np.testing.assert_allclose(model.strain(response.stress), strain, atol=1e-14)


def test_hencky_constants():
    """Uniaxial stress gives Young's modulus and Poisson's ratio; a volume change gives the bulk modulus."""
    model = Hencky(YOUNG, POISSON)
    np.testing.assert_allclose(model.respond(np.array([[-POISSON, -POISSON, 1.0]]) * 0.01).stress,
                               [[0.0, 0.0, 0.01 * YOUNG]], atol=1e-8)
    np.testing.assert_allclose(model.respond(np.full((1, 3), 0.01)).stress, 0.01 * YOUNG / (1 - 2 * POISSON),
                               rtol=1e-13)


def test_elastic_region_is_hencky():
    model, elastic = law(), Hencky(np.full(COUNT, YOUNG), POISSON)
    strain = trial_strains("elastic", model)
    found, wanted = model.respond(strain), elastic.respond(strain)
    np.testing.assert_allclose(found.stress, wanted.stress, rtol=1e-11, atol=1e-6)
    np.testing.assert_allclose(found.tangent, wanted.tangent, rtol=1e-13)
    np.testing.assert_allclose(found.elastic, strain, atol=1e-16)
    np.testing.assert_allclose(model.energy(strain), elastic.energy(strain), rtol=1e-13)


@pytest.mark.parametrize("cone", CONES)
def test_return_lands_on_the_cone_and_follows_the_potential(cone):
    model = law(cone=cone)
    strain = trial_strains("cone", model)
    trial = Hencky(np.full(COUNT, YOUNG), POISSON).respond(strain).stress
    response = model.respond(strain)
    size = np.abs(trial).max(axis=1)
    assert np.all(yield_function(model, trial) > 0)
    assert np.all(np.abs(yield_function(model, response.stress)) < 1e-12 * size)
    # plastic strain is Δγ (s / 2√J2 + η̄ 1 / 3), with Δγ > 0
    mean, root = invariants(response.stress)
    flow = strain - response.elastic
    gradient = (response.stress - mean[:, None]) / (2 * root[:, None]) + model.parameters[:, [ETA_BAR]] / 3
    multiplier = np.sum(flow * gradient, axis=1) / np.sum(gradient**2, axis=1)
    assert np.all(multiplier > 0)
    assert np.abs(flow - multiplier[:, None] * gradient).max() < 1e-12 * np.abs(flow).max()
    # the elastic strain carries the stress
    elastic = Hencky(np.full(COUNT, YOUNG), POISSON).strain(response.stress)
    np.testing.assert_allclose(elastic, response.elastic, atol=1e-16)


def test_flow_is_not_associated_unless_asked_for():
    """Dilation: volume grows by η̄ Δγ, nothing with no dilation angle."""
    for dilation in (0.0, DILATION, ANGLE):
        model = law(dilation=dilation)
        strain = trial_strains("cone", law())
        flow = strain - model.respond(strain).elastic
        multiplier = np.sqrt(2 * np.sum((flow - flow.mean(axis=1, keepdims=True)) ** 2, axis=1))
        np.testing.assert_allclose(flow.sum(axis=1), model.parameters[:, ETA_BAR] * multiplier, atol=1e-15)
        assert np.all((model.parameters[:, ETA_BAR] == model.parameters[:, ETA]) == (dilation == ANGLE))


@pytest.mark.parametrize("cone", ["compression", "extension"])
def test_apex_is_at_c_cot_phi(cone):
    model = law(cone=cone)
    response = model.respond(trial_strains("apex", model))
    np.testing.assert_allclose(response.stress, COHESION / np.tan(np.radians(ANGLE)), rtol=1e-13)
    assert not response.tangent.any()
    assert np.abs(yield_function(model, response.stress)).max() < 1e-10


def test_no_cohesion_has_its_apex_at_zero_stress():
    model = law(cohesion=0.0)
    response = model.respond(trial_strains("apex", model))
    assert not response.stress.any() and not response.elastic.any()


@pytest.mark.parametrize("cone", CONES)
@pytest.mark.parametrize("region", ["elastic", "cone", "apex"])
def test_tangent_equals_central_differences(region, cone):
    model = law(cone=cone)
    strain = trial_strains(region, model)
    difference = np.abs(model.respond(strain).tangent - difference_tangent(model, strain))
    assert difference.max() < 2e-8 * YOUNG


@pytest.mark.parametrize("pair", [(0, 1), (1, 2), (0, 2)])
def test_tangent_where_two_principal_values_are_equal(pair):
    model = law()
    for region in ("elastic", "cone"):
        strain = trial_strains(region, model)
        strain[:, pair[1]] = strain[:, pair[0]]
        difference = np.abs(model.respond(strain).tangent - difference_tangent(model, strain))
        trial = Hencky(np.full(COUNT, YOUNG), POISSON).respond(strain).stress
        smooth = np.abs(yield_function(model, trial)) > 1e2
        assert smooth.sum() > COUNT / 2 and difference[smooth].max() < 2e-7 * YOUNG


def test_tangent_at_equal_principal_values():
    """Isotropic trial states have no deviatoric direction: elastic below the apex, nothing above."""
    model = law(2)
    strain = np.array([[-1e-3] * 3, [1e-2] * 3])
    response = model.respond(strain)
    assert np.isfinite(response.tangent).all()
    elastic = Hencky(YOUNG, POISSON).respond(strain[:1]).tangent[0]
    np.testing.assert_allclose(response.tangent[0], elastic, rtol=1e-13)
    assert not response.tangent[1].any()


def slope(model, tangent, strain, sizes=1e-6 / 2.0 ** np.arange(5)):
    """Observed rate of the Taylor remainder of the stress, all points together."""
    start = model.respond(strain).stress
    direction = np.random.default_rng(2).standard_normal(strain.shape)
    left = [np.linalg.norm(model.respond(strain + h * direction).stress - start
                           - h * np.einsum("pij,pj->pi", tangent, direction)) for h in sizes]
    return np.polyfit(np.log(sizes), np.log(left), 1)[0]


def test_taylor_rate_on_the_cone_and_of_a_wrong_tangent():
    """The tangent of the continuum differs from the algorithmic one by the shrinking of the deviator."""
    model = law()
    strain = trial_strains("cone", model)
    strain = strain[np.ptp(strain, axis=1) > 2e-4]      # well away from the apex, where the tangent is smooth
    model = law(len(strain))
    response = model.respond(strain)
    continuum = model.respond(response.elastic + 1e-9 * (strain - response.elastic)).tangent
    assert slope(model, response.tangent, strain) == pytest.approx(2.0, abs=0.01)
    assert slope(model, continuum, strain) == pytest.approx(1.0, abs=0.01)


def test_tangent_is_symmetric_only_for_associated_flow():
    for dilation, symmetric in ((ANGLE, True), (DILATION, False)):
        model = law(dilation=dilation)
        tangent = model.respond(trial_strains("cone", law())).tangent
        assert (np.abs(tangent - tangent.transpose(0, 2, 1)).max() < 1e-12 * YOUNG) == symmetric
    assert DruckerPrager.plastic and not Hencky.plastic


@pytest.mark.parametrize("angle", [10.0, 32.75, 45.0])
@pytest.mark.parametrize("meridian", ["compression", "extension"])
def test_cone_passes_through_the_edge_of_mohr_coulomb(angle, meridian):
    """Triaxial states on (σ1 - σ3) + (σ1 + σ3) sin φ = 2 c cos φ, tension positive, lie on the cone."""
    eta, xi, _ = cone_constants(angle, 0.0, meridian)
    sin, cos = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    low = -np.linspace(1e3, 1e6, 20)                                    # most compressive stress
    high = (2 * COHESION * cos + low * (1 - sin)) / (1 + sin)
    middle = high if meridian == "compression" else low
    mean, root = invariants(np.stack([high, middle, low], axis=1))
    assert np.abs(root + eta * mean - xi * COHESION).max() < 1e-12 * 1e6


@pytest.mark.parametrize("angle, dilation", [(10.0, 10.0), (32.75, 32.75), (32.75, 2.75), (45.0, 0.0)])
def test_cone_of_plane_strain_has_mohr_coulomb_strength_there(angle, dilation):
    """Flow without strain along y sets σ_y; the stresses in the plane then obey Mohr-Coulomb, and dilate with ψ."""
    eta, xi, flow = cone_constants(angle, dilation, "plane strain")
    mean = -np.linspace(1e3, 1e6, 20)
    root = xi * COHESION - eta * mean
    across = -2 * flow * root / 3                                       # deviator along y: no flow there
    radius = np.sqrt(root**2 - 0.75 * across**2)
    high, low = mean - across / 2 + radius, mean - across / 2 - radius
    sin, cos = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    assert np.abs((high - low) + (high + low) * sin - 2 * COHESION * cos).max() < 1e-12 * 1e6
    strain = np.stack([high - mean, across, low - mean], axis=1) / (2 * root[:, None]) + flow / 3   # s/2√J2 + η̄/3
    np.testing.assert_allclose(strain.sum(axis=1) / (strain[:, 0] - strain[:, 2]), np.sin(np.radians(dilation)), atol=1e-12)


def test_cones_are_nested_and_agree_without_friction():
    compression, plane, extension = (cone_constants(30.0, 30.0, cone)[0]
                                     for cone in ("compression", "plane strain", "extension"))
    assert compression > extension > 0 and compression > plane > 0
    for cone in ("compression", "extension"):
        assert cone_constants(0.0, 0.0, cone) == pytest.approx((0.0, 2 / np.sqrt(3), 0.0))
    assert cone_constants(0.0, 0.0, "plane strain") == pytest.approx((0.0, 1.0, 0.0))   # Tresca in plane strain


def test_sand_of_38_percent():
    """Published correlations for loose sand, and the stiffness at 100 kPa."""
    values = sand(38.0)
    expected = {"reference_young": 22.8e6, "friction_angle": 32.75, "dilation_angle": 2.75,
                "stiffness_exponent": 0.58125, "poisson": 0.25, "cohesion": 300.0}
    assert {name: values[name] for name in expected} == pytest.approx(expected)
    assert values["density"] * 9.81 == pytest.approx(16.52e3)
    assert sand(38.0, buoyant=True)["density"] * 9.81 == pytest.approx(9.798e3)
    assert sand(10.0)["dilation_angle"] == 0.0
    assert stiffness_from_stress(22.8e6, 0.58125, 100e3) == pytest.approx(22.8e6)
