"""Points that are halved and joined keep mass, momentum, volume, stress and history."""

from dataclasses import replace

import numpy as np
import pytest
from yield_surface import yield_function

from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.soil import split_merge as pop
from hybrid.soil.principal import from_principal
from hybrid.state import PointConstants, Points, Population

COUNT = 50
LAW = DruckerPrager(np.linspace(1e6, 3e6, COUNT), 0.3, 30.0, 5.0, 1e3)
SPACE = np.zeros(3, bool)     # no axis is collapsed


@pytest.fixture
def population():
    """Points deformed, stressed and moving at random, with their rates' gradients."""
    rng = np.random.default_rng(3)
    half = rng.uniform(0.02, 0.1, (COUNT, 3))
    constants = PointConstants(rng.uniform(-1, 1, (COUNT, 3)), half, np.prod(2 * half, axis=1),
                               1800 * np.prod(2 * half, axis=1), rng.uniform(0.4, 1, (COUNT, 3)) * 18e3)
    deformation = np.eye(3) + 0.3 * rng.uniform(-1, 1, (COUNT, 3, 3))
    strain = 1e-3 * rng.uniform(-1, 1, (COUNT, 3))
    directions = np.linalg.qr(rng.normal(size=(COUNT, 3, 3)))[0]
    stress = from_principal(LAW.respond(strain).stress, np.ascontiguousarray(directions))
    elastic = from_principal(np.exp(2 * LAW.respond(strain).elastic), np.ascontiguousarray(directions))
    points = Points(
        position=constants.position + rng.uniform(-0.1, 0.1, (COUNT, 3)), velocity=rng.normal(size=(COUNT, 3)),
        acceleration=rng.normal(size=(COUNT, 3)), half_width=half.copy(), deformation=deformation, b_elastic=elastic,
        stress=stress / np.linalg.det(deformation)[:, None, None], plastic_strain=rng.uniform(0, 1, COUNT),
        affine=rng.normal(size=(COUNT, 2, 3, 3)), opened=rng.uniform(0, 0.1, COUNT))
    return Population(points, constants, LAW.rows)


def held(population):
    """What must never change: mass, momentum and its rate, centre, volumes, stress, history, per unit."""
    p, c = population.points, population.constants
    now = np.linalg.det(p.deformation) * c.volume
    return {
        "mass": c.mass.sum(), "volume": c.volume.sum(), "volume now": now.sum(), "momentum": c.mass @ p.velocity,
        "force": c.mass @ p.acceleration, "centre": c.mass @ p.position, "first centre": c.mass @ c.position,
        "stress": np.einsum("n,nij->ij", now, p.stress), "plastic": c.volume @ p.plastic_strain,
        "opened": c.volume @ p.opened,
        "modulus": c.volume @ population.rows,
    }


def assert_same(a, b, but=()):
    for name in held(a).keys() - set(but):
        one, other = held(a)[name], held(b)[name]
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12 * np.abs(other).max(), err_msg=name)


@pytest.mark.parametrize("axis", range(3))
def test_halves_conserve_the_totals_of_the_point(population, axis):
    assert_same(pop.split(population, axis, LAW), population)


@pytest.mark.parametrize("axis", range(3))
def test_two_points_keep_what_they_had_in_one(population, axis):
    first, second = pop.select(population, np.arange(25)), pop.select(population, np.arange(25, COUNT))
    second = replace(second, constants=replace(second.constants, half_width=first.constants.half_width,
                                               volume=first.constants.volume, mass=0.7 * first.constants.mass))
    assert_same(pop.merge(first, second, axis, LAW, SPACE), pop.concatenate(first, second), but=["first centre"])


@pytest.mark.parametrize("axis", range(3))
def test_merging_two_halves_gives_the_initial_point(population, axis):
    halves = pop.split(population, axis, LAW)
    first, second = (pop.select(halves, begin + np.arange(COUNT)) for begin in (0, COUNT))
    whole = pop.merge(first, second, axis, LAW, SPACE)
    for part in ("points", "constants"):
        for name, value in vars(getattr(population, part)).items():
            if value is not None:
                np.testing.assert_allclose(getattr(getattr(whole, part), name), value, rtol=1e-9,
                                           atol=1e-12 * np.abs(value).max(), err_msg=name)


def test_halves_have_the_velocity_of_the_affine_field(population):
    """The velocity of a half is that of the affine field at its place: angular momentum about any place is kept."""
    halves = pop.split(population, 1, LAW)
    step = halves.points.position[:COUNT] - population.points.position
    expected = population.points.velocity + np.einsum("nij,nj->ni", population.points.affine[:, 0], step)
    np.testing.assert_allclose(halves.points.velocity[:COUNT], expected, rtol=1e-12)


def test_the_stress_of_halves_carries_their_weight(population):
    """Undeformed and at rest, the upper half has less weight above it by half of the whole's."""
    rest = replace(population, points=replace(population.points, deformation=np.tile(np.eye(3), (COUNT, 1, 1))))
    halves = pop.split(rest, 2, LAW)
    change = halves.points.stress[COUNT:] - halves.points.stress[:COUNT]
    expected = (rest.constants.geostatic_gradient * rest.constants.half_width[:, 2, None])[:, :, None] * np.eye(3)
    np.testing.assert_allclose(change, expected, atol=1e-9 * 1e6)


def test_a_whole_of_admissible_halves_is_admissible(population):
    """Convexity of the cone, points of one law."""
    rows = np.tile(LAW.rows[:1], (COUNT, 1))
    law = LAW.with_rows(rows)
    rng = np.random.default_rng(5)
    response = law.respond(5e-3 * rng.uniform(-1, 0.5, (COUNT, 3)))
    flowing = replace(population, rows=rows, points=replace(
        population.points, stress=from_principal(response.stress, np.tile(np.eye(3), (COUNT, 1, 1)))
        / np.linalg.det(population.points.deformation)[:, None, None]))
    whole = pop.merge(pop.select(flowing, np.arange(25)), pop.select(flowing, np.arange(25, COUNT)), 0, LAW, SPACE)
    kirchhoff = whole.points.stress * np.linalg.det(whole.points.deformation)[:, None, None]
    assert yield_function(law.with_rows(whole.rows), np.linalg.eigvalsh(kirchhoff)).max() < 1e-6


def test_momentum_is_lost_where_the_mean_forgets_the_masses(population):
    """The conservation test fails on a mean by number."""
    first, second = pop.select(population, np.arange(25)), pop.select(population, np.arange(25, COUNT))
    whole = pop.merge(first, second, 0, LAW, SPACE)
    mean = 0.5 * (first.points.velocity + second.points.velocity)
    broken = replace(whole, points=replace(whole.points, velocity=mean))
    with pytest.raises(AssertionError, match="momentum"):
        assert_same(broken, pop.concatenate(first, second), but=["first centre"])


def test_halves_with_opposite_rotations_merge_to_a_point_with_their_volume(population):
    """A quarter turn one way and the other: the mean of their F is flat, and no power of it is a volume."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    parts = pop.split(population, 0, LAW)
    first, second = (pop.select(parts, ids) for ids in (slice(None, COUNT), slice(COUNT, None)))
    first = replace(first, points=replace(first.points, deformation=np.tile(1.1 * turn, (COUNT, 1, 1))))
    second = replace(second, points=replace(second.points, deformation=np.tile(1.1 * turn.T, (COUNT, 1, 1))))
    whole = pop.merge(first, second, 0, LAW, SPACE)
    np.testing.assert_allclose(np.linalg.det(whole.points.deformation), 1.1**3)
    assert np.isfinite(whole.points.stress).all()
    assert_same(whole, pop.concatenate(first, second))


def test_what_comes_of_two_points_does_not_depend_on_others(population):
    """Compressed along x alone, beside points that are not: F of the merged one is the same without them."""
    halves = pop.split(population, 0, LAW)
    squeezed = halves.points.deformation.copy()
    squeezed[[0, COUNT]] = np.diag([0.7, 1.0, 1.0]), np.diag([0.9, 1.0, 1.0])
    halves = replace(halves, points=replace(halves.points, deformation=squeezed))
    many, one = (pop.merge(*(pop.select(halves, first + np.arange(number)) for first in (0, COUNT)), 0, LAW, SPACE)
                 for number in (COUNT, 1))
    np.testing.assert_allclose(one.points.deformation[0], many.points.deformation[0], rtol=1e-14)


@pytest.mark.parametrize("axis", range(3))
def test_no_axis_is_stretched_along_which_nothing_deforms(axis):
    flat = np.arange(3) == axis
    rotated = np.eye(3)[None] * 0.9
    rotated[0, axis] = np.eye(3)[axis]
    found = pop._with_volume(rotated, np.array([0.5]), flat)
    assert np.linalg.det(found) == pytest.approx(0.5) and found[0, axis, axis] == 1.0


def test_points_of_stages_with_different_schemes_come_together(population):
    """Generalised alpha carries a third gradient, that of its acceleration; points without have none of it."""
    points = population.points
    third = replace(population, points=replace(points, algorithmic=points.acceleration,
                                               affine=np.concatenate([points.affine, points.affine[:, 1:]], axis=1)))
    for first, second in ((population, third), (third, population)):
        both = pop.concatenate(first, second)
        assert both.points.affine.shape == (2 * COUNT, 3, 3, 3)
        np.testing.assert_array_equal(both.points.affine[:, :2], np.concatenate([points.affine, points.affine]))
        plain = slice(0, COUNT) if first is population else slice(COUNT, None)
        assert not both.points.affine[plain, 2].any() and not both.points.algorithmic[plain].any()
