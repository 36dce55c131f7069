"""Second pass of contact: force and tangent of samples against deforming faces, by finite differences.

Faces are warped and turned, gaps and ways finite, so that every term of the derivation is at work: the normal that
turns with the corners, the weights that follow the sample, the edges that carry the way of friction.
"""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.body.attitude import exp_so3
from hybrid.contact import body_to_soil
from hybrid.contact.body_to_soil import SampleSet
from hybrid.contact.exposed_faces import Frame

CENTRE, ROTATION, RATIO = np.array([0.1, -0.2, 0.3]), exp_so3(np.array([0.4, -0.7, 0.2])), 0.5
LAWS = {"frictionless": 0.0, "slip": 0.01, "stick": 50.0}


def made(count=3, seed=2, pressure=0.0):
    """Samples 10 mm below warped faces, and the places (4 count, 3) of the corners."""
    rng = np.random.default_rng(seed)
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.1
    place = np.concatenate([
        square @ exp_so3(rng.standard_normal(3)).T + 0.3 * rng.standard_normal(3) for _ in range(count)])
    place += 0.02 * rng.standard_normal(place.shape)
    corner = np.arange(4 * count).reshape(-1, 4)
    frame, at = Frame.from_corners(place[corner]), rng.uniform(-0.8, 0.8, (count, 2))
    x = frame.origin + np.einsum("ma,mai->mi", at, frame.edges) - 0.01 * frame.normal
    anchor = at + 0.05 * rng.standard_normal(at.shape)
    return SampleSet(np.arange(count), (x - CENTRE) @ ROTATION, corner, 1e5 * (1 + np.arange(count)), anchor, anchor,
                  np.full(count, pressure), np.zeros(count, int), np.zeros((count, 3))), place


def residual(samples, place, law, step):
    """(count, 18) forces, moments and forces on corners after a step (6 + 12 count,) of the pose and the corners."""
    pose = CENTRE + step[:3], exp_so3(step[3:6]) @ ROTATION
    contact = body_to_soil.evaluate(samples, place + step[6:].reshape(-1, 3), *pose, LAWS[law], RATIO)
    assert len(contact) == len(samples)
    on_corner = contact.shares[:, :, None] * contact.force[:, None]
    moment = np.cross(contact.arm, contact.force)
    return np.concatenate([-contact.force, -moment, on_corner.reshape(len(samples), 12)], axis=1)


def exact(samples, place, law):
    """The same derivative (count, 18, 6 + 12 count) from the tangent."""
    contact = body_to_soil.evaluate(samples, place, CENTRE, ROTATION, LAWS[law], RATIO)
    out = np.zeros((len(samples), 18, 6 + 12 * len(samples)))
    for n in range(len(samples)):
        out[n, :, :6] = contact.matrix[n, :, :6]
        out[n, :, 6 + 12 * n:18 + 12 * n] = contact.matrix[n, :, 6:]
    return out


@pytest.mark.parametrize("pressure", [0.0, 700.0])
@pytest.mark.parametrize("law", LAWS)
def test_tangent_equals_central_differences(law, pressure):
    samples, place = made(pressure=pressure)
    h, columns = 1e-6, []
    for e in np.eye(6 + place.size):
        columns.append((residual(samples, place, law, h * e) - residual(samples, place, law, -h * e)) / (2 * h))
    tangent = exact(samples, place, law)
    scale = np.abs(tangent).max()
    np.testing.assert_allclose(np.moveaxis(columns, 0, -1), tangent, atol=2e-8 * scale)


def rate(law, spoil=lambda K: K):
    samples, place = made()
    direction = np.random.default_rng(5).standard_normal(6 + place.size)
    base, slope = residual(samples, place, law, 0 * direction), spoil(exact(samples, place, law)) @ direction
    sizes = 4e-5 / 2.0 ** np.arange(4)
    left = [np.linalg.norm(residual(samples, place, law, h * direction) - base - h * slope) for h in sizes]
    return np.polyfit(np.log(sizes), np.log(left), 1)[0]


@pytest.mark.parametrize("law", LAWS)
def test_remainder_is_second_order(law):
    assert rate(law) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("term", ["xi", "normal", "tau"])
def test_slope_test_fails_without_one_variation(term, monkeypatch):
    """Weights that do not follow the sample, a normal that does not turn, edges that do not stretch."""
    complete = body_to_soil._variations
    monkeypatch.setattr(body_to_soil, "_variations", lambda *args: replace(
        complete(*args), **{term: np.zeros_like(getattr(complete(*args), term))}))
    assert rate("stick") < 1.3


def test_normal_force_is_the_gradient_of_the_stored_energy():
    samples, place = made()
    contact = body_to_soil.evaluate(samples, place, CENTRE, ROTATION, 0.0, RATIO)
    for n in range(place.size):
        shift = np.zeros(place.size)
        shift[n] = 1e-6
        there, back = (
            body_to_soil.evaluate(samples, place + s * shift.reshape(-1, 3), CENTRE, ROTATION, 0.0, RATIO).energy
            for s in (1, -1))
        force = (contact.shares[:, :, None] * contact.force[:, None]).reshape(-1)[n]
        assert (there - back) / 2e-6 == pytest.approx(force, rel=1e-6, abs=1e-5 * np.abs(contact.force).max())


@pytest.mark.parametrize("law", LAWS)
def test_force_and_moment_cancel(law):
    samples, place = made()
    contact = body_to_soil.evaluate(samples, place, CENTRE, ROTATION, LAWS[law], RATIO)
    on_corner = contact.shares[:, :, None] * contact.force[:, None]
    np.testing.assert_allclose(on_corner.sum(axis=1), contact.force, rtol=1e-12)
    arm = place[samples.corner] - CENTRE
    np.testing.assert_allclose(np.cross(arm, on_corner).sum(axis=1), np.cross(contact.arm, contact.force), atol=1e-9)


def test_slip_moves_the_anchor_to_the_limit_and_keeps_the_force():
    samples, place = made()
    contact = body_to_soil.evaluate(samples, place, CENTRE, ROTATION, LAWS["slip"], RATIO)
    assert contact.slip.all() and contact.dissipated > 0
    anchor = Frame.from_corners(place[samples.corner]).local_coordinates(contact.anchor)[0]
    from_there = replace(samples, anchor=anchor, origin=anchor)
    again = body_to_soil.evaluate(from_there, place, CENTRE, ROTATION, LAWS["slip"], RATIO)
    np.testing.assert_allclose(again.force, contact.force, rtol=1e-10)
    assert again.dissipated == pytest.approx(0.0, abs=1e-9 * contact.dissipated)
