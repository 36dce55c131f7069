"""What a failed step is told to come from, and when long plastic increments are told of."""

import re

import numpy as np
import pytest

from hybrid.monitors.failure_hints import drawn_out, rounding
from hybrid.monitors.plastic_increment import LIMIT, Flow
from hybrid.scene import Time
from hybrid.setup.build import build
from hybrid.soil.domains import cells_wide
from hybrid.study.scenes import soil_scene


def test_width_of_a_domain_in_cells():
    """Of a turned, drawn out domain, in cells of two sizes; nothing along a collapsed axis."""
    axes = np.array([0.0, 1.0, 3.0]), np.zeros(1), np.array([0.0, 1.0, 2.0])
    quarter = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [3.0, 0.0, 0.0]])    # x goes to z, three times as long
    found = cells_wide(np.full((2, 3), 0.25), np.array([np.eye(3), quarter]),
                       np.array([[0.5, 0.0, 0.5], [2.0, 0.0, 0.5]]), axes)
    np.testing.assert_allclose(found, [[0.5, 0.0, 0.5], [0.25, 0.0, 1.5]])


@pytest.mark.parametrize("stretch, told", [(1.0, False), (1.7, False), (1.9, True)])
def test_soil_drawn_out_is_told_of(stretch, told):
    """With two points a cell from 0.9 of a cell on; not where there is inertia."""
    simulation = build(soil_scene(time=Time(step=1.0, inertia=False)))
    points = simulation.state.points
    points.deformation[0, 2, 2] = stretch
    texts = drawn_out(simulation.model, points)
    assert bool(texts) == told and all(re.search(r"wide, limit 0.9.*soil\.points_per_axis", text) for text in texts)
    assert not drawn_out(build(soil_scene()).model, points)


def test_rounding_grows_with_stiffness_and_size():
    """A tenth of it is what cubes of 0.1 m make: K = E/3 < E at ν = 0, E 0.01 m² times 2e-16, by the root of their
    number."""
    soil = build(soil_scene()).model.soil
    assert rounding(soil, 100) == pytest.approx(10 * 2.2e-16 * 1e6 * 0.01 * 10, rel=0.01)
    stiffer = build(soil_scene(young=1e9)).model.soil
    assert rounding(stiffer, 400) == pytest.approx(2e3 * rounding(soil, 100))


def test_long_plastic_increments_are_told_of_once():
    flow = Flow()
    assert flow.notes(1.0, LIMIT) == ()
    (text,) = flow.notes(2.0, 0.15)
    assert "0.15" in text and f"limit {LIMIT:g}" in text and "stage.steps" in text
    assert flow.notes(3.0, 1.0) == ()
