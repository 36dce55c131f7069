"""`check_law` holds for every law in every region of its return, and finds what is wrong with broken ones."""

from dataclasses import replace

import numpy as np
import pytest
from yield_surface import yield_function

from hybrid.laws import Response, plastic_increment
from hybrid.laws.check import check_law
from hybrid.laws.cone import DILATION_RATIO, ETA, ETA_BAR, RESIDUAL, SLOPE, STRENGTH, Cone, merge
from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.laws.hencky import BULK, Hencky
from hybrid.laws.user import adopt
from hybrid.laws.von_mises import VonMises
from hybrid.laws.mohr_coulomb import MohrCoulomb
from hybrid.laws.willam_warnke import WillamWarnke
from hybrid.runtime.errors import LawError

YOUNG, POISSON, N = 20e6, 0.28, 400
ANGLES, C = (33.0, 8.0), 5e3
E = np.full(N, YOUNG)
CLAY = {"hardening": -8e5, "residual_strength": 2e3}
SOFT = {"hardening": -4e5, "residual_cohesion": 2e3}
LAWS = {
    "hencky": Hencky(E, POISSON),
    "von-mises": VonMises(E, POISSON, 1e4),
    "von-mises, hardening": VonMises(E, POISSON, 1e4, hardening=5e5),
    "von-mises, softening": VonMises(E, POISSON, 1e4, **CLAY),
    "drucker-prager": DruckerPrager(E, POISSON, *ANGLES, C),
    "drucker-prager, associated": DruckerPrager(E, POISSON, 33.0, 33.0, C, "plane strain"),
    "drucker-prager, hardening": DruckerPrager(E, POISSON, *ANGLES, C, "extension", hardening=1e6),
    "drucker-prager, softening": DruckerPrager(E, POISSON, *ANGLES, C, **SOFT),
    "willam-warnke": WillamWarnke(E, POISSON, *ANGLES, C),
    "mohr-coulomb": MohrCoulomb(E, POISSON, *ANGLES, C),
    "mohr-coulomb, flat": MohrCoulomb(E, POISSON, 0.0, 0.0, C),
    "mohr-coulomb, steep": MohrCoulomb(E, POISSON, 55.0, 0.0, C),
    "mohr-coulomb, dilatant": MohrCoulomb(E, POISSON, 45.0, 45.0, C),
    "mohr-coulomb, softening": MohrCoulomb(E, POISSON, *ANGLES, C, **SOFT),
    "willam-warnke, steep": WillamWarnke(E, POISSON, 55.0, 0.0, C),
    "willam-warnke, dilatant": WillamWarnke(E, POISSON, 45.0, 45.0, C),
    "willam-warnke, flat": WillamWarnke(E, POISSON, 0.0, 0.0, C),
    "willam-warnke, hardening": WillamWarnke(E, POISSON, *ANGLES, C, hardening=1e6),
    "willam-warnke, softening": WillamWarnke(E, POISSON, *ANGLES, C, **SOFT),
}
PLASTIC = [name for name in LAWS if name != "hencky"]
SHAPES = ["apart", "compression", "extension", "near an edge", "almost equal"]


def strains(shape, seed=4):
    """Trial strains in and far beyond yield, under pressure and tension, with values apart, equal or nearly so."""
    rng = np.random.default_rng(seed)
    values = np.sort(rng.standard_normal((N, 3)), axis=1) * np.exp(rng.uniform(np.log(2e-4), np.log(5e-3), (N, 1)))
    values -= values.mean(axis=1, keepdims=True)
    if shape in ("compression", "near an edge", "almost equal"):
        values[:, 1] = values[:, 2] - {"compression": 0.0, "near an edge": 1e-5, "almost equal": 1e-13}[shape]
    if shape == "extension":
        values[:, 1] = values[:, 0]
    rows = np.arange(N)[:, None]
    return (values + rng.normal(-4e-4, 8e-4, (N, 1)))[rows, rng.permuted(np.tile(np.arange(3), (N, 1)), axis=1)]


def history(seed=5):
    return np.random.default_rng(seed).uniform(0.0, 0.012, N)


def regions(law, strain, alpha):
    """Where the return ended: (elastic, apex), each (n,) bool; the others are on the cone."""
    response = law.respond(strain, alpha)
    return np.abs(response.elastic - strain).max(axis=1) < 1e-15, np.ptp(response.stress, axis=1) == 0


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", LAWS)
def test_tangent_energy_dissipation_and_finality(name, shape):
    assert check_law(LAWS[name], strains(shape), history()) < 2e-7


@pytest.mark.parametrize("kind", range(3))
def test_random_materials(kind):
    """Stiffness over four decades, any Poisson's ratio, angles up to 60 degrees, strains from 1e-4 to 3 %."""
    rng, n = np.random.default_rng(kind), 100
    for _ in range(40):
        young, size, phi = 10 ** rng.uniform(5, 9), 10 ** rng.uniform(-4, -1.5), rng.uniform(0.1, 60)
        psi, start = rng.choice([0.0, rng.uniform(0, phi), phi]), young * size * 10 ** rng.uniform(-2, 0)
        slope, floor = rng.choice([0.0, rng.uniform(-0.5, 1)]) * start / size, rng.uniform(0.01, 1) * start
        stiff = np.full(n, young), rng.uniform(0, 0.49)
        law = [lambda: VonMises(*stiff, start, "plane strain", slope, floor),
               lambda: DruckerPrager(*stiff, phi, psi, start, "compression", slope, floor),
               lambda: WillamWarnke(*stiff, phi, psi, start, slope, floor)][kind]()
        strain = size * rng.standard_normal((n, 3)) * 10 ** rng.uniform(-1, 1, (n, 1)) - size * rng.uniform(-1, 2)
        check_law(law, strain, rng.uniform(0, 2 * size, n), step=1e-7 * size, tolerance=1e-5)


def test_one_dilation_for_the_whole_section_would_gain_energy():
    """Why dilation has a section: with ψ = φ and a circular potential, stretched sand gives work back."""
    law = WillamWarnke(E, POISSON, 45.0, 45.0, C)
    law.parameters[:, DILATION_RATIO] = 1.0
    with pytest.raises(LawError, match="plastic flow gains energy"):
        check_law(law, strains("extension"))


@pytest.mark.parametrize("name", PLASTIC)
def test_strains_visit_every_region(name):
    law, strain, alpha = LAWS[name], strains("apart"), history()
    elastic, apex = regions(law, strain, alpha)
    assert 0.05 < elastic.mean() < 0.7 and np.mean(~elastic & ~apex) > 0.1
    assert apex.mean() == 0 if "von-mises" in name or "flat" in name else apex.mean() > 0.05
    if "softening" in name:
        floor = law.parameters[:, RESIDUAL] == np.maximum(law.parameters[:, STRENGTH] + law.parameters[:, SLOPE] * (
            alpha + plastic_increment(strain, law.respond(strain, alpha).elastic)), law.parameters[:, RESIDUAL])
        before = law.parameters[:, STRENGTH] + law.parameters[:, SLOPE] * alpha > law.parameters[:, RESIDUAL]
        assert np.mean(floor & before) > 0.02 and np.mean(floor & ~before) > 0.02 and np.mean(~floor & ~elastic) > 0.05


@pytest.mark.parametrize("name", PLASTIC)
def test_yield_function_is_zero_after_the_return(name):
    """With the strength that the accumulated plastic strain leaves, apex included: one definition of it."""
    law, strain, alpha = LAWS[name], strains("apart"), history()
    response = law.respond(strain, alpha)
    elastic, _ = regions(law, strain, alpha)
    found = yield_function(law, response.stress, alpha + plastic_increment(strain, response.elastic))
    assert np.abs(found[~elastic]).max() < 1e-11 * YOUNG * np.abs(strain).max() and found[elastic].max() <= 0


@pytest.mark.parametrize("name", PLASTIC)
@pytest.mark.parametrize("size", [-1e-3, 0.0, 2e-3])
def test_equal_principal_values(name, size):
    """No deviatoric direction: elastic below the apex, at the apex above; always finite and symmetric in the axes."""
    law = LAWS[name]
    response = law.respond(np.full((N, 3), size), np.zeros(N))
    assert np.isfinite(response.tangent).all() and np.ptp(response.stress, axis=1).max() < 1e-9
    limit = law.parameters[0, 4] / law.parameters[0, 2] if law.parameters[0, 2] > 0 else np.inf
    assert response.stress[0, 0] == pytest.approx(min(3 * law.parameters[0, 0] * size, limit), abs=1e-6)


@pytest.mark.parametrize("name", PLASTIC)
def test_equal_principal_values_but_for_round_off(name):
    """A deviator of round-off has no Lode angle, as its sum is not zero: taken for one, g came out negative, and tangents of
    1e23 Pa or none at all in soil that is pulled evenly."""
    rng = np.random.default_rng(3)
    size = rng.choice([-1.0, 1.0], N) * 10 ** rng.uniform(-8, -1, N)
    law = LAWS[name]
    for ulps in range(4):
        strain = size[:, None] * (1 + rng.integers(-ulps, ulps + 1, (N, 3)) * np.finfo(float).eps)
        response = law.respond(strain, np.zeros(N))
        assert np.abs(response.tangent).max() < 2 * np.abs(LAWS["hencky"].respond(strain).tangent).max()
        mean = law.parameters[:, BULK] * response.elastic.sum(axis=1)
        np.testing.assert_allclose(response.stress.mean(axis=1), mean, rtol=1e-6, atol=1e-6)


def test_section_is_smooth_convex_and_meets_both_meridians():
    """Around the deviatoric plane: 1/g is e in extension and 1 in compression, and the section turns one way only."""
    law = LAWS["willam-warnke, steep"]
    angle = np.linspace(0.0, 2 * np.pi, N, endpoint=False)
    plane = np.stack([np.cos(angle), np.cos(angle - 2 * np.pi / 3), np.cos(angle + 2 * np.pi / 3)], axis=1)
    unit = plane / np.sqrt(0.5 * np.sum(plane**2, axis=1, keepdims=True))
    radius = 1 / (yield_function(law, unit) + law.parameters[:, STRENGTH])
    sin = np.sin(np.radians(55.0))
    assert radius.min() == pytest.approx((3 - sin) / (3 + sin), rel=1e-4) and radius.max() == pytest.approx(1, rel=1e-4)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    dx, dy = np.roll(x, -1) - x, np.roll(y, -1) - y
    turn = dx * np.roll(dy, -1) - dy * np.roll(dx, -1)
    assert np.all(turn > 0)


def test_without_friction_the_section_is_von_mises():
    strain = strains("apart")
    flat, clay = LAWS["willam-warnke, flat"].respond(strain), VonMises(E, POISSON, C).respond(strain)
    np.testing.assert_allclose(flat.stress, clay.stress, rtol=1e-13)
    np.testing.assert_allclose(flat.tangent, clay.tangent, atol=1e-9 * YOUNG)


def test_without_friction_the_pyramid_is_trescas_prism():
    """Sheared in a plane it carries its cohesion, as with next to no friction; its flow is not along its normal."""
    law, strain = MohrCoulomb(E, POISSON, 0.0, 0.0, C), np.tile([0.01, 0.0, -0.01], (N, 1))
    stress = law.respond(strain).stress
    assert 0.5 * (stress[:, 0] - stress[:, 2]) == pytest.approx(C, rel=1e-9)
    np.testing.assert_allclose(stress, MohrCoulomb(E, POISSON, 1e-6, 0.0, C).respond(strain).stress, rtol=1e-6, atol=1e-3)
    assert not law.symmetric and VonMises(E, POISSON, C).symmetric


def test_joined_laws_answer_as_their_parts():
    strain, alpha = strains("apart"), history()
    names = ["hencky", "von-mises, softening", "willam-warnke, hardening"]
    owner = np.arange(N) % 3
    members = [np.flatnonzero(owner == i) for i in range(3)]
    parts = [Hencky(E[members[0]], POISSON),
             VonMises(E[members[1]], POISSON, 1e4, **CLAY),
             WillamWarnke(E[members[2]], POISSON, *ANGLES, C, hardening=1e6)]
    found = merge(parts, members).respond(strain, alpha)
    for name, ids in zip(names, members):
        wanted = LAWS[name].respond(strain, alpha)
        np.testing.assert_allclose(found.stress[ids], wanted.stress[ids], rtol=1e-12)
        np.testing.assert_allclose(found.tangent[ids], wanted.tangent[ids], rtol=1e-12)
    assert type(merge([Hencky(E, POISSON)], [np.arange(N)])) is Hencky


def test_too_steep_softening_is_refused():
    with pytest.raises(LawError, match="snaps back"):
        VonMises(E, POISSON, 2e4, hardening=-2 * YOUNG, residual_strength=1.0)


class Broken:
    """A law with one member or part of its response spoiled."""

    plastic = True

    def __init__(self, name, **spoil):
        self.whole, self.spoil = LAWS[name], spoil
        self.young, self.strain, self.energy = self.whole.young, self.whole.strain, self.whole.energy
        if "strain" in spoil:
            self.strain = lambda stress: spoil["strain"](self.whole.strain(stress))
        if "energy" in spoil:
            self.energy = lambda elastic: spoil["energy"](self.whole.energy(elastic))

    def respond(self, strain, plastic_strain):
        response = self.whole.respond(strain, plastic_strain)
        if "respond" in self.spoil:
            return self.spoil["respond"](response)
        return replace(response, **{name: self.spoil[name](getattr(response, name))
                                    for name in ("stress", "elastic", "tangent") if name in self.spoil})


def unsaid_history(response):
    return replace(response, elastic=response.elastic + 1e-6)


@pytest.mark.parametrize("spoil, words", [
    ({"tangent": lambda D: 1.001 * D}, "tangent is off by 0.00"),
    ({"tangent": lambda D: D.transpose(0, 2, 1)}, "differences give"),
    ({"tangent": lambda D: D * [1.0, 1.0, 0.99]}, "tangent is off"),
    ({"energy": lambda psi: 1.01 * psi}, "derivative of the energy"),
    ({"strain": lambda strain: 1.01 * strain}, "not the elastic strain"),
    ({"respond": unsaid_history}, "derivative of the energy"),
])
@pytest.mark.parametrize("name", ["drucker-prager, softening", "willam-warnke, hardening"])
def test_broken_laws_are_found(name, spoil, words):
    with pytest.raises(LawError, match=words) as error:
        check_law(Broken(name, **spoil), strains("apart"), history())
    assert "at point" in str(error.value) and "trial strain (" in str(error.value)


def test_the_section_without_its_turn_is_a_wrong_tangent():
    """The tangent of a circular cone of the same strength and dilation at each point misses g' and η̄'."""
    law, strain, alpha = LAWS["willam-warnke"], strains("apart"), np.zeros(N)
    unit = strain - strain.mean(axis=1, keepdims=True)
    unit /= np.sqrt(0.5 * np.sum(unit**2, axis=1, keepdims=True))
    g, g_bar = (yield_function(Cone(E, POISSON, 0.0, 0.0, C, ratio), unit) + C for ratio in law.parameters[0, [5, 8]])
    circular = DruckerPrager(E, POISSON, *ANGLES, C)
    circular.parameters[:, ETA] /= g
    circular.parameters[:, ETA_BAR] /= g_bar
    circular.parameters[:, STRENGTH] /= g
    np.testing.assert_allclose(circular.respond(strain).stress, law.respond(strain).stress, atol=1e-6)
    with pytest.raises(LawError, match="tangent is off"):
        check_law(Broken("willam-warnke", tangent=lambda D: circular.respond(strain).tangent), strain, alpha)


def test_a_law_that_counts_plastic_strain_otherwise_is_found():
    """Softening by twice what is accumulated: the state it leaves is outside its own yield surface."""
    class Other(Broken):
        def respond(self, strain, plastic_strain):
            return self.whole.respond(strain, 2 * plastic_strain)

    with pytest.raises(LawError, match="not final"):
        check_law(Other("von-mises, softening"), strains("apart"), history())


@pytest.mark.parametrize("respond, words", [
    (lambda r: (r.stress, r.elastic, r.tangent), "must return a hybrid.laws.Response, not a tuple"),
    (lambda r: replace(r, stress=r.stress[:, 0]), r"stress of a law has shape \(400,\), must be \(400, 3\)"),
    (lambda r: replace(r, tangent=np.eye(3)), r"tangent of a law has shape \(3, 3\), must be \(400, 3, 3\)"),
    (lambda r: replace(r, elastic="none"), "elastic of a law must be an array of numbers"),
    (lambda r: replace(r, stress=r.stress * np.nan), "no finite stress for 400 points"),
])
def test_answers_in_the_wrong_shape_are_refused(respond, words):
    with pytest.raises(LawError, match=words):
        adopt(Broken("hencky", respond=respond), N)


def test_a_law_without_its_members_is_refused():
    with pytest.raises(LawError, match="has no young, plastic, energy, strain. A class derived from"):
        adopt(type("Bare", (), {"respond": None})(), N)
    with pytest.raises(LawError, match=r"young of a law has shape \(1,\), must be \(400,\)"):
        adopt(Hencky(YOUNG, POISSON), N)


def test_points_without_a_number_have_failed():
    def half(response):
        response.stress[1::2] = np.inf
        return Response(response.stress, response.elastic, response.tangent)

    law = adopt(LAWS["hencky"], N)
    law.law = Broken("hencky", respond=half)
    assert (law.respond(strains("apart"), np.zeros(N)).failed == (np.arange(N) % 2 == 1)).all()
