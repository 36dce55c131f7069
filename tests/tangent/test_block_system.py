"""The assembled block system against finite differences of its residual: soil, coupling, bodies, inertia.

Slope test: with K exact, |R(u + h d) - R(u) - h K d| falls as h². Rates are asserted; a broken tangent falls as h.
"""

import numpy as np
import pytest

from hybrid.build import build
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.system.cache import Systems
from hybrid.system.equations import Step


def scene(geometry, law, friction, depth=0.02, held=()):
    """A small block of soil with a sphere pressed `depth` into its middle."""
    velocity, spin = np.array((0.4, 0.1, -depth / 0.01)), np.array((0.5, -1.0, 0.3))
    velocity[np.isin(("x", "y", "z"), held)] = 0.0
    spin[np.isin(("rx", "ry", "rz"), held)] = 0.0
    material = {
        "hencky": Material(law="hencky", young=1e6, poisson=0.3, density=1800.0),
        "drucker-prager": Material(law="drucker-prager", young=1e6, poisson=0.3, density=1800.0, friction_angle=30.0,
                                   dilation_angle=5.0, cohesion=2e3),
    }[law]
    axis = Axis(start=0.0, end=0.8, size=0.2)
    return Scene(
        name="block", grid=Grid(axis, axis, Axis(start=-0.6, end=0.2, size=0.2), Faces(z_min="fixed")),
        soil=Soil(material, top=0.0),
        bodies=(Body(geometry=geometry / "sphere.geo", density=3000.0, parameters={"radius": 0.25, "size": 0.12},
                     position=(0.43, 0.37, 0.25 + 0.005), velocity=tuple(velocity), spin=tuple(spin),
                     friction=friction, held=held),),
        time=Time(step=0.01), stages=(Stage("one", 1),))


def prepared(described, seed=1, size=2e-3):
    """A Step of the scene and trial unknowns away from rest."""
    simulation = build(described)
    rng = np.random.default_rng(seed)
    points = simulation.state.points
    points.velocity[:] = 0.1 * rng.standard_normal(points.velocity.shape)
    points.acceleration[:] = rng.standard_normal(points.acceleration.shape)
    step = Step(simulation.model, simulation.state, described.time.step, True, Systems(simulation.model))
    soil = size * rng.standard_normal(step.pattern.size)
    body = np.array([2e-3, -1e-3, -3e-3, 0.02, -0.03, 0.04])[simulation.model.body_free[0]]
    return step, step.moved(step.start(), soil, body)


def dense_tangent(step):
    from scipy.sparse import csr_matrix

    system, pattern = step.system, step.pattern
    uu = csr_matrix((system.values, pattern.indices, pattern.indptr)).toarray()
    return np.block([[uu, system.uw], [system.wu, system.ww]])


def remainders(step, unknowns, direction, sizes, spoil=lambda K: K):
    """|R(u + h d) - R(u) - h K d| for each h."""
    start = step.evaluate(unknowns)
    step.assemble(start)
    slope = spoil(dense_tangent(step)) @ direction
    n = step.pattern.size
    base = np.concatenate([start.soil, start.body])
    out = []
    for h in sizes:
        there = step.evaluate(step.moved(unknowns, direction[:n], direction[n:], h))
        out.append(np.linalg.norm(np.concatenate([there.soil, there.body]) - base - h * slope))
    return np.array(out)


def observed_rate(step, unknowns, spoil=lambda K: K, seed=3):
    rng = np.random.default_rng(seed)
    n, m = step.pattern.size, step.system.body_unknowns
    direction = np.concatenate([rng.standard_normal(n), rng.standard_normal(m)])
    sizes = 2e-5 / 2.0 ** np.arange(4)
    r = remainders(step, unknowns, direction, sizes, spoil)
    return np.polyfit(np.log(sizes), np.log(r), 1)[0]


@pytest.mark.parametrize("law", ["hencky", "drucker-prager"])
@pytest.mark.parametrize("friction", [0.0, 0.02, 0.3, 50.0])
def test_block_tangent_is_consistent(geometry, law, friction):
    step, unknowns = prepared(scene(geometry, law, friction))
    touch = step.evaluate(unknowns).contacts[0].corners
    assert len(touch) >= 4
    if friction == 0.02:
        assert touch.slip.all()
    if friction == 50.0:
        assert not touch.slip.any()
    assert observed_rate(step, unknowns) > 1.85


def test_plastic_points_are_tested(geometry):
    step, unknowns = prepared(scene(geometry, "drucker-prager", 0.3))
    trial = step.evaluate(unknowns).soil_trial
    flow = np.abs(trial.strain.strain - trial.response.elastic).max(axis=1) > 1e-9
    apex = np.abs(trial.response.tangent).max(axis=(1, 2)) == 0.0
    assert 0.1 < flow.mean() < 1.0 and apex.any() and not apex.all()


@pytest.mark.parametrize("block", ["uu", "uw", "wu", "ww"])
def test_slope_test_fails_on_a_broken_block(geometry, block):
    step, unknowns = prepared(scene(geometry, "hencky", 0.3))
    n = step.pattern.size
    rows, columns = slice(0, n) if block[0] == "u" else slice(n, None), slice(0, n) if block[1] == "u" else slice(n, None)

    def spoil(K):
        K = K.copy()
        K[rows, columns] *= 1.01
        return K

    assert observed_rate(step, unknowns, spoil) < 1.5


def test_held_components_of_a_body_are_no_unknowns(geometry):
    step, unknowns = prepared(scene(geometry, "hencky", 0.3, held=("y", "rx", "rz")))
    assert step.system.body_unknowns == 3
    assert observed_rate(step, unknowns) > 1.85
