"""Nothing depends on the units of length, time and mass: a scene a thousand times as small, in a time four times as long, of
another mass, has the same iterations and the same answers to the last bit. Units are powers of two, which round nothing.

A length, stress or time written into the program (a tolerance of 1e-9 m, an air gap of a millimetre) would show here."""

from dataclasses import replace

import numpy as np
import pytest
from similar import factor, similar

from hybrid.runtime.data import DEMOS
from hybrid.scene.file import load_scene
from hybrid.setup.build import build

UNITS = [(2.0**-10, 4.0, 2.0**-20), (2.0**10, 2.0**-6, 2.0**24)]
# Clay pressed, a ball on held ground, a slope put under gravity
SCENES = {"first": 3, "rolling_sphere": 8, "slope": 4}


def run(scene, steps):
    simulation = build(scene)
    return simulation, [record for record, _ in zip(simulation.steps(), range(steps))]


def assert_similar(one, other, units):
    """The same iterations; places and forces are those of the other in other units."""
    (simulation, records), (scaled, found) = one, other
    assert [record.iterations for record in records] == [record.iterations for record in found]
    np.testing.assert_array_equal(scaled.state.points.position, simulation.state.points.position * units[0])
    np.testing.assert_array_equal(scaled.state.points.stress, simulation.state.points.stress * factor("Pa", units))
    for expected, body in zip(records[-1].bodies, found[-1].bodies):
        np.testing.assert_allclose(body.position, expected.position * units[0], rtol=1e-13)
        np.testing.assert_allclose(body.contact_force, expected.contact_force * factor("N", units), rtol=1e-9,
                                   atol=1e-12 * np.abs(expected.contact_force).max() * factor("N", units))


@pytest.mark.parametrize("name", SCENES)
def test_units_do_not_matter(name):
    scene, steps = load_scene(DEMOS / f"{name}.toml"), SCENES[name]
    expected = run(scene, steps)
    for units in UNITS:
        assert_similar(expected, run(similar(scene, units), steps), units)


def test_a_length_of_its_own_would_show():
    """As that of a penalty which is given and not scaled."""
    def with_penalty(scene):
        return replace(scene, bodies=tuple(replace(body, penalty=1e3) for body in scene.bodies))

    scene, units = load_scene(DEMOS / "rolling_sphere.toml"), UNITS[0]
    expected = run(with_penalty(scene), 4)
    assert_similar(expected, run(similar(with_penalty(scene), units), 4), units)
    with pytest.raises(AssertionError):
        assert_similar(expected, run(with_penalty(similar(scene, units)), 4), units)
