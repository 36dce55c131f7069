"""Which scheme a body has: that for flight once nothing has been near it for a while, alone or with all it is joined to."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.scheme import Scheme
from hybrid.state import BodyState, State
from hybrid.step import flight
from hybrid.step.body_terms import BodyStep

SCHEME = Scheme.default()
ZERO = np.zeros(3)


def steps(near, apart=(flight.AFTER,) * 3, joints=(), pairs=(), scheme=SCHEME, target=None, begin=1.0):
    """BodySteps of three bodies, of which those numbered `near` have contact points within reach."""
    model = SimpleNamespace(scheme=scheme, joints=[SimpleNamespace(bodies=pair) for pair in joints])
    bodies = []
    for number, before in enumerate(apart):
        state = BodyState(ZERO, np.eye(3), ZERO, np.ones(3), ZERO, np.ones(3), algorithmic=np.full(6, 0.9), apart=before)
        pair = SimpleNamespace(points=np.zeros(int(number in near)))
        bodies.append(BodyStep(number, None, state, target, pair, None, None, None, ZERO, scheme, 0.1, begin))
    around = SimpleNamespace(near=[SimpleNamespace(
        sides=[SimpleNamespace(closes=closes, touching=np.array([touching]), start=np.zeros((1, 3)))],
        pair=SimpleNamespace(numbers=numbers))
        for numbers, closes, touching in pairs])
    return flight.with_schemes(model, bodies, around if pairs else None)


def flying(found):
    """Numbers of the BodySteps with the scheme for flight; the others have that of the model."""
    assert all(body.scheme in (SCHEME, SCHEME.in_flight) for body in found)
    return [body.number for body in found if body.scheme == SCHEME.in_flight]


@pytest.mark.parametrize("given, expected", [
    ({"near": []}, [0, 1, 2]), ({"near": [1]}, [0, 2]),
    ({"near": [], "pairs": [((0, 2), True, False)]}, [1]), ({"near": [], "pairs": [((0, 2), False, True)]}, [1]),
    ({"near": [], "pairs": [((0, 2), False, False)]}, [0, 1, 2]),
    ({"near": [], "pairs": [((0, 2), False, False)], "begin": 0.0}, [1]),
    ({"near": [1], "joints": [(0, 1), (2, None)]}, [2]), ({"near": [0], "joints": [(1, 2), (0, 1)]}, []),
    ({"near": [], "target": ZERO}, []), ({"near": [], "apart": (0, 2, 4)}, [2])])
def test_bodies_near_nothing_fly(given, expected):
    """Near the soil, near another body, joined to one that is, on a line, near something a moment ago."""
    assert flying(steps(**given)) == expected


def test_increments_apart_are_counted():
    found = steps([1], apart=(0, 4, 4))
    assert [body.state.apart for body in found] == [1, 0, 4]


@pytest.mark.parametrize("apart, near, factor", [
    (flight.AFTER, False, 1 / 3), (flight.AFTER + 1, False, 1.0), (flight.AFTER + 1, True, 3.0), (0, False, 1.0)])
def test_the_algorithmic_acceleration_of_a_smooth_motion_changes_with_the_scheme(apart, near, factor):
    """It is v̇ of αf - αm steps earlier: of 1 with ρ∞ = 0, of 1/3 with 0.5."""
    body = steps([0] if near else [], apart=(apart,) * 3)[0]
    np.testing.assert_allclose(body.state.algorithmic, 1.0 - 0.1 * factor, rtol=1e-12)


@pytest.mark.parametrize("active, joints, expected", [
    ([], [], set()), ([3], [], {0, 1}), ([3], [(1, 2)], {0, 1, 2})])
def test_bodies_that_hit_each_other_in_flight_are_found_and_land(active, joints, expected):
    bodies = steps([])
    model = SimpleNamespace(scheme=SCHEME, joints=[SimpleNamespace(bodies=pair) for pair in joints])
    pairs = SimpleNamespace(near=[SimpleNamespace(pair=SimpleNamespace(numbers=(0, 1)))])
    step = SimpleNamespace(model=model, bodies=bodies, pairs=pairs)
    struck = flight.hit(step, SimpleNamespace(pairs=SimpleNamespace(contacts=[[SimpleNamespace(active=np.array(active))]])))
    assert struck == expected
    before = SimpleNamespace(bodies=[replace(body.state, apart=flight.AFTER + 1) for body in bodies])
    after = flight.landed(model, State(0.0, 0, None, before.bodies, []), struck)
    for number, (old, new) in enumerate(zip(before.bodies, after.bodies)):
        assert new.apart == (0 if number in expected else old.apart)
        np.testing.assert_allclose(1.0 - new.algorithmic, (3.0 if number in expected else 1.0) * (1.0 - old.algorithmic))


def test_a_scheme_that_is_given_is_that_of_all_bodies():
    given = Scheme.generalised_alpha(0.0)
    assert all(body.scheme is given and body.state.apart == flight.AFTER for body in steps([], scheme=given))


def test_the_scheme_changes_without_an_error_of_first_order():
    """A swing, cos t, whose scheme changes every 0.3 s: the error falls with the square of the step, as within one."""
    errors = []
    for dt in (0.02, 0.01):
        u, v, second, algorithmic, used = 1.0, 0.0, -1.0, None, SCHEME
        for n in range(round(3.0 / dt)):
            scheme = SCHEME.in_flight if int((n + 0.5) * dt / 0.3) % 2 else SCHEME
            if algorithmic is not None and scheme is not used:
                algorithmic = scheme.carried(second, algorithmic, used)
            used, du = scheme, 0.0
            for _ in range(3):      # linear: v̇ = -u at the end
                residual = scheme.advance(du, v, second, algorithmic, dt)[1] + u + du
                du -= residual / (scheme.mass_factor(dt) + 1.0)
            gain, second, algorithmic = scheme.advance(du, v, second, algorithmic, dt)
            u, v = u + du, v + gain
        errors.append(abs(u - np.cos(3.0)))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
