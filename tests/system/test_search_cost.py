"""What contact costs in a step follows the corners near the body, not all points, nor all triangles.

Wall times of search, evaluation and assembly of one pair, as ratios within one run: two set-ups take turns and each is
judged by its fastest turn. The bounds leave twice what was measured, for machines that are busy with other things.
"""

from time import perf_counter

import numpy as np
import pytest

from hybrid.contact.contact_pair import ContactPair
from hybrid.linalg.system_cache import Systems
from hybrid.scene import Body
from hybrid.setup.build import build
from hybrid.step.equations import Step
from hybrid.study.scenes import soil_scene, steel

TURNS = 12
SHARES = pytest.mark.parametrize("second_pass", [0.0, 0.5])


def prepared(body, cells=8):
    """Function that does a step's contact of `body`, pressed 30 mm into cells³/2 cells of 0.1 m; it returns
    the ContactPair."""
    width = 0.1 * cells
    simulation = build(soil_scene([body], x=(0.0, width), y=(0.0, width), z=(-width / 2, 0.2), size=0.1))
    model, state = simulation.model, simulation.state
    step = Step(model, state, 0.001, False, Systems(model))
    grid, at = model.soil.grid, state.bodies[0]
    rest, pose = np.zeros((grid.node_count, 3)), (at.position - (0.0, 0.0, 0.03), at.rotation)
    values, uw = np.zeros(len(step.pattern.indices)), np.zeros((step.pattern.size, 6))
    wu, force = np.zeros((6, step.pattern.size)), np.zeros((grid.node_count, 3))

    def work():
        pair = ContactPair(model.bodies[0], at, state.contacts[0], state.points, state.points.half_width, grid, step.soil.active,
                    0.1, (rest, pose))
        contact = pair.evaluate(rest, pose)
        pair.add_residual(contact, force)
        pair.add_tangent(contact, step.pattern, values, uw, wu)
        return pair

    return work


def compared(small, large):
    """Times of `large` over `small`, and the Pairs of both."""
    times, pairs = [[], []], [small(), large()]
    for _ in range(TURNS):
        for own, work in zip(times, (small, large)):
            begin = perf_counter()
            work()
            own.append(perf_counter() - begin)
    return min(times[1]) / min(times[0]), *pairs


def ball(geometry, second_pass, size=0.06, cells=8):
    return Body(geometry=geometry / "sphere.geo", density=3000.0, rest_on=0.0, friction=0.3, second_pass=second_pass,
                position=(0.05 * cells + 0.013, 0.05 * cells + 0.007, 0.0),
                parameters={"radius": 0.25, "size": size, "growth": 0.5})


@SHARES
def test_eight_times_as_many_points_around(geometry, second_pass):
    """The same corners, and the same time: measured 0.9 to 1.1; all points are passed over once, by their place."""
    few, many = (prepared(ball(geometry, second_pass, cells=cells), cells) for cells in (8, 16))
    ratio, one, other = compared(few, many)
    assert len(one.corners) == len(other.corners) > 200
    assert ratio < 2.0


@SHARES
def test_sixteen_times_as_many_triangles(geometry, second_pass):
    """The corners stay and are found by a tree: measured 1.3, and 1.7 to 2.1 with four times as many samples."""
    coarse, fine = (prepared(ball(geometry, second_pass, size)) for size in (0.06, 0.015))
    ratio, one, other = compared(coarse, fine)
    triangles = [len(pair.body.surface.triangles) for pair in (one, other)]
    assert triangles[1] > 14 * triangles[0]
    assert len(other.corners) == pytest.approx(len(one.corners), rel=0.05)
    assert ratio < (4.0 if second_pass else 2.5)


@SHARES
def test_more_corners_near_the_body(geometry, second_pass):
    """A plate of nine times the area: time in proportion to the corners, 6.3 times as many; measured 6.3 to 8.9."""
    def plate(edge):
        return prepared(steel(edge, edge, 0.1, position=(1.0, 1.0, 0.0), rest_on=0.0, friction=0.3,
                            second_pass=second_pass), 20)

    ratio, one, other = compared(plate(0.5), plate(1.5))
    growth = len(other.corners) / len(one.corners)
    assert growth > 4.0
    assert 0.2 * growth < ratio < 2.0 * growth
