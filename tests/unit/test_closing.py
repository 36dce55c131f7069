"""Soil that has opened closes without pressure, at the volume at which it opened; its tangent is that of its response."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.grid.axes import FACES, make_grid
from hybrid.laws.cone import ETA, ETA_BAR, STRENGTH
from hybrid.laws.hencky import BULK, Hencky
from hybrid.laws.mohr_coulomb import MohrCoulomb
from hybrid.laws.von_mises import VonMises
from hybrid.soil import closing
from hybrid.soil.lost_points import deactivate
from hybrid.state import Points

N = 400
YOUNG = np.full(N, 1e7)

LAWS = {"sand": MohrCoulomb(YOUNG, 0.3, 33.0, 0.0, 0.0), "dilating": MohrCoulomb(YOUNG, 0.3, 33.0, 8.0, 0.0),
        "cohesive": MohrCoulomb(YOUNG, 0.3, 25.0, 0.0, 5e3), "softening": MohrCoulomb(
            YOUNG, 0.3, 25.0, 4.0, 5e3, hardening=-1e5, residual_cohesion=1e3)}


def respond(law, strain, plastic_strain, opened):
    return closing.respond(law, strain, SimpleNamespace(plastic_strain=plastic_strain, opened=opened))[:2]


def walk(law, volumes, shear=0.0):
    """Mean stresses [Pa] and openings along a path of volume strains, each a row of the points, and the work [J/m³]."""
    elastic, alpha, opened, before, means, openings, work = np.zeros((N, 3)), np.zeros(N), None, 0.0, [], [], 0.0
    for volume in volumes:
        step = (volume - before) / 3 + shear * np.array([1.0, 0.0, -1.0])
        response, opened = respond(law, elastic + step, alpha, opened)
        work += float(response.stress[0] @ (step * np.ones(3)))
        elastic, before = response.elastic, volume
        means.append(response.stress[0].mean())
        openings.append(0.0 if opened is None else opened[0])
    return np.array(means), np.array(openings), work


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("shear", [0.0, 1e-4])
def test_it_closes_where_it_opened(name, shear):
    """Pulled apart by 5 %, pressed together to 1 % beyond: no pressure until it has closed."""
    law = LAWS[name]
    there, back = np.linspace(0.0, 0.05, 51)[1:], np.linspace(0.05, -0.01, 61)[1:]
    means, opened, _ = walk(law, [*there, *back], shear)
    open_again = back > 1.1e-3 + 100 * shear * law.parameters[0, ETA_BAR]    # sheared, it dilates
    assert opened[49] == pytest.approx(0.05, rel=0.05) and (np.abs(means[50:][open_again][5:]) < 1e-6).all()
    assert means[-1] < -0.5 * 0.01 * law.parameters[0, BULK] and opened[-1] == 0.0


def test_without_a_memory_it_resists_at_once(monkeypatch):
    law = LAWS["sand"]
    monkeypatch.setattr("hybrid.soil.closing._any", lambda opened: None)
    means, *_ = walk(law, [0.05, 0.049])
    assert means[-1] == pytest.approx(-1e-3 * law.parameters[0, BULK], rel=1e-3)


def test_a_crack_of_cohesive_soil_gains_no_energy():
    """It unloads from its tensile strength before it closes: the work of two cycles is that of opening twice."""
    law = LAWS["cohesive"]
    K, strength = law.parameters[0, BULK], law.parameters[0, STRENGTH] / law.parameters[0, ETA]
    cycle = [*np.linspace(0.0, 0.02, 401)[1:], *np.linspace(0.02, 0.0, 401)[1:]]
    means, _, work = walk(law, cycle + cycle)
    assert means.max() == pytest.approx(strength) and means.min() >= -1e-6
    assert work == pytest.approx(2 * strength * (0.02 - strength / K), rel=0.02)


@pytest.mark.parametrize("name", LAWS)
def test_tangent_equals_central_differences(name):
    rng = np.random.default_rng(7)
    law, opened = LAWS[name], rng.choice([0.0, 4e-3], N)
    strain = 1e-3 * rng.standard_normal((N, 3)) - rng.choice([3e-3, 1e-3, 0.0, -1e-3], (N, 1))
    alpha, h = rng.uniform(0.0, 0.01, N), 1e-9

    def stress(change):
        return respond(law, strain + change, alpha, opened)[0].stress

    tangent = respond(law, strain.copy(), alpha, opened)[0].tangent
    closes = (strain.sum(axis=1) < 0.0) & (-strain.sum(axis=1) < opened)
    numeric = np.stack([(stress(h * e) - stress(-h * e)) / (2 * h) for e in np.eye(3)], axis=2)
    error = np.abs(tangent - numeric).max(axis=(1, 2)) / law.parameters[:, BULK]
    assert np.sort(error)[-8:].max() < 1e-5 or np.mean(error > 1e-5) < 0.01      # a point may cross an edge of yielding
    assert 0.15 < closes.mean() < 0.5
    kept = law.respond(strain + np.clip(-strain.sum(axis=1), 0.0, opened)[:, None] / 3, alpha).tangent
    assert np.mean(np.abs(kept - numeric).max(axis=(1, 2))[closes] > 1e-3 * law.parameters[0, BULK]) > 0.5


@pytest.mark.parametrize("law", [VonMises(YOUNG, 0.3, 1e4), Hencky(YOUNG, 0.3)])
def test_soil_without_an_apex_does_not_open(law):
    strain = np.full((N, 3), 0.05)
    assert respond(law, strain, np.zeros(N), None)[1] is None


def test_opening_and_closing_keep_the_volume():
    """Of what has opened, c is taken up; what is returned to the apex is added."""
    law = LAWS["sand"]
    opened = np.linspace(0.0, 0.02, N)
    for volume in (0.01, -0.01):
        response, after = respond(law, np.full((N, 3), volume / 3), np.zeros(N), opened)
        np.testing.assert_allclose(after + response.elastic.sum(axis=1), opened + volume, atol=1e-15)


def test_work_of_closing_is_that_of_the_pressure_behind_it():
    """`Soil.plastic_work` takes τ · (ε - ε_e - c/3 1): the strain that the law has seen is larger by c/3."""
    law, given = LAWS["sand"], np.full((N, 3), -0.01)
    strain = given.copy()
    points = SimpleNamespace(plastic_strain=np.zeros(N), opened=np.full(N, 0.02))
    response, opened, closed = closing.respond(law, strain, points)
    assert opened is None and (closed == 0.02).all()
    np.testing.assert_allclose(strain - closed[:, None] / 3, given)
    np.testing.assert_allclose(response.elastic, strain)


def test_each_point_has_its_own_plastic_strain():
    """Softening by the strain of that point, also of the few that stay open."""
    law, opened = LAWS["softening"], np.where(np.arange(N) % 3 == 2, 0.02, 0.0)
    alpha = np.linspace(0.0, 0.03, N)
    strain = np.tile([0.004, -0.001, -0.004], (N, 1))
    response, _ = respond(law, strain, alpha, opened)
    still = law.without_dilation(np.arange(N)).respond(np.tile([0.004, -0.001, -0.004], (N, 1)) + 1e-3 / 3, alpha)
    np.testing.assert_allclose(response.stress[opened > 0], still.stress[opened > 0])


def test_without_inertia_nothing_is_remembered():
    points = SimpleNamespace(plastic_strain=np.zeros(N), opened=None)
    assert closing.respond(LAWS["sand"], np.full((N, 3), 0.01), points, opens=False)[1:] == (None, None)
    points.opened = np.full(N, 0.05)
    response, opened, closed = closing.respond(LAWS["sand"], np.full((N, 3), -0.001), points, opens=False)
    assert (response.stress < 0.0).all() and opened is points.opened and closed is None


def test_points_that_leave_keep_what_they_had():
    old, new, leaving = cells(), cells(), np.arange(8) == 2
    new.opened = np.full(8, 0.03)
    assert list(deactivate(old, new, leaving).opened) == [0.03, 0.03, 0.02, *[0.03] * 5]
    old.opened = None
    assert list(deactivate(old, new, leaving).opened) == [0.03, 0.03, 0.0, *[0.03] * 5]


# ------------------------------------------------------------------ shared in cells

GRID = make_grid((np.linspace(0.0, 1.0, 3), np.array([0.0, 1.0]), np.linspace(0.0, 1.0, 3)), np.array([[0.0, 1.0]] * 3),
                 dict.fromkeys(FACES, "free"))
G = 9.81
FALL = np.sqrt(2 * 0.5 / G) * (1.0 - 1e-12)     # [s]


def shared(points, time=FALL, touching=(), opens=True):
    soil = SimpleNamespace(grid=GRID, constants=SimpleNamespace(volume=np.full(8, 0.1)), law=SimpleNamespace(opens=opens))
    return closing.shared(points, soil, G, time, list(touching))


def cells(inactive=None):
    """Points of one volume: two in each of the four cells, the first one open by 0.02, the second one pressed by 0.01."""
    position = np.repeat([[0.2, 0.5, 0.2], [0.7, 0.5, 0.2], [0.2, 0.5, 0.7], [0.7, 0.5, 0.7]], 2, axis=0)
    volume = np.tile([0.0, -0.01], 4)
    zero = np.zeros((8, 3))
    return Points(position, zero, zero, zero, np.tile(np.eye(3), (8, 1, 1)),
                  np.exp(2 / 3 * volume)[:, None, None] * np.eye(3), np.zeros((8, 3, 3)), np.zeros(8), inactive=inactive,
                  opened=np.tile([0.02, 0.0], 4))


def volumes(points):
    """Volume strain (n,) of points, open or elastic."""
    return points.opened + 0.5 * np.log(np.linalg.det(points.b_elastic))


@pytest.mark.parametrize("time, left", [(FALL, 0.0), (0.25 * FALL, 0.75), (0.0, 1.0), (1.01 * FALL, 1.0)])
def test_points_share_what_is_open_in_their_cell(time, left):
    """Volume is kept; after the time of a fall by a cell all have its mean, before that some of the difference is left.
    Longer steps resolve no fall, and share nothing."""
    before = cells()
    after = shared(before, time)
    assert volumes(after).sum() == pytest.approx(volumes(before).sum())
    np.testing.assert_allclose(volumes(after) - 0.005, left * (volumes(before) - 0.005), atol=1e-12)
    assert ((after.opened == 0.0) | np.isclose(np.linalg.det(after.b_elastic), 1.0)).all()


def test_cells_with_points_of_one_kind_or_clay_or_at_a_body_share_nothing():
    def changed(points, touching=(), opens=True):
        after = shared(points, touching=touching, opens=opens)
        return np.flatnonzero(volumes(after) != volumes(points))

    assert list(changed(cells(), [3, 4])) == [0, 1, 6, 7]
    clay = np.arange(8) != 7
    assert list(changed(cells(), opens=clay)) == [0, 1, 2, 3, 4, 5] and LAWS["sand"].opens.all()
    assert not VonMises(YOUNG, 0.3, 1e4).opens.any()
    assert list(changed(cells(np.arange(8) == 1))) == [2, 3, 4, 5, 6, 7]
    one = cells()
    one.opened[:2] = 0.02, 0.01
    one.b_elastic[1] = np.eye(3)
    assert list(changed(one)) == [2, 3, 4, 5, 6, 7]
    one.opened = None
    assert shared(one) is one
