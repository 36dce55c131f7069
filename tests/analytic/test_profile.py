"""Soil in layers: weight, stress at rest, stiffness and strength at the points, and a start that stays still."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.laws.cone import RATIO, STRENGTH
from hybrid.laws.hencky import Hencky
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Grid, Layer, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace

GRAVITY = 9.81
CRUST = Layer("crust", bottom=-0.5, law="von-mises", k0=0.8, material={
    "density": 1900.0, "young": 8e6, "poisson": 0.45, "strength": 25e3})
CLAY = Layer("clay", top=-0.5, bottom=-1.1, law="von-mises", material={
    "density": 1600.0, "young": 4e6, "poisson": 0.49, "strength": 8e3, "strength_gradient": 1.5e3, "hardening": -4e4,
    "residual_strength": 2e3})
DENSE = Layer("dense", top=-1.1, bottom=-1.6, law="willam-warnke", material={"relative_density": 80.0})
LAYERS = (CRUST, CLAY, DENSE)     # below them soil.material, a loose sand; -1.1 and -1.6 are no lines of the grid


def profile(layers=LAYERS, material=Material("drucker-prager", relative_density=38.0), steps=3, **soil):
    """Layered soil on a grid graded along all axes, 0.5 m of empty cells above it."""
    side = Axis(start=0.0, end=3.0, size=0.25, fine=(1.0, 2.0), growth=1.4)
    up = Axis(start=-2.5, end=0.5, size=0.25, fine=(-0.75, 0.5), growth=1.3)
    return Scene(name="profile", grid=Grid(side, side, up), soil=Soil(material, top=0.0, layers=layers, **soil),
                 time=Time(step=0.04), stages=(Stage("rest", steps),))


def heights(simulation):
    return simulation.model.soil.constants.position[:, 2]


def inside(simulation, layer):
    z = heights(simulation)
    return (z < (0.0 if layer.top is None else layer.top)) & (z >= layer.bottom)


def test_vertical_stress_is_the_weight_of_the_points_above():
    simulation = build(profile())
    c, z = simulation.model.soil.constants, heights(simulation)
    area = 9.0
    for level in np.unique(z):
        above, here = c.mass[z > level].sum(), c.mass[z == level].sum()
        wanted = -(above + here / 2) * GRAVITY / area
        np.testing.assert_allclose(simulation.state.points.stress[z == level, 2, 2], wanted, rtol=1e-13)


def test_densities_ratios_and_stiffness_are_those_of_the_layers():
    simulation = build(profile())
    c, stress, law = simulation.model.soil.constants, simulation.state.points.stress, simulation.model.soil.law
    z = heights(simulation)
    sand = ~(inside(simulation, CRUST) | inside(simulation, CLAY) | inside(simulation, DENSE))
    expected = [(inside(simulation, CRUST), 1900.0, 0.8), (inside(simulation, CLAY), 1600.0, 0.49 / 0.51),
                (inside(simulation, DENSE), 18.2e3 / 9.81, 1 - np.sin(np.radians(38.0))),
                (sand, 16.52e3 / 9.81, 1 - np.sin(np.radians(32.75)))]
    for points, density, k0 in expected:
        assert points.any()
        np.testing.assert_allclose(c.mass[points], density * c.volume[points], rtol=1e-12)
        np.testing.assert_allclose(stress[points, 0, 0], k0 * stress[points, 2, 2], rtol=1e-12)
    assert set(law.young[expected[0][0]]) == {8e6}
    for points, reference, exponent in ((expected[2][0], 48e6, 0.45), (sand, 22.8e6, 0.58125)):
        wanted = reference * (-stress[points, 0, 0] / 100e3) ** exponent
        np.testing.assert_allclose(law.young[points], wanted, rtol=1e-12)
    clay = expected[1][0]
    strength = 2 / np.sqrt(3) * (8e3 + 1.5e3 * (-0.5 - z[clay]))      # below the top of the layer
    np.testing.assert_allclose(law.parameters[clay, STRENGTH], strength, rtol=1e-13)
    np.testing.assert_allclose(law.parameters[sand, RATIO], 1.0)
    assert np.all(law.parameters[expected[2][0], RATIO] < 1)


@pytest.mark.parametrize("basis", ["gimp", "mpm"])
def test_layered_start_stays_still(basis):
    simulation = build(profile(basis=basis))
    before = simulation.state.points
    for record in simulation.steps():
        assert record.rejections == 0 and record.residual < 1e-12
    after = simulation.state.points
    assert np.abs(after.velocity).max() < 1e-10 and after.plastic_strain.max() < 1e-12
    assert np.abs(after.stress - before.stress).max() < 1e-12 * np.abs(before.stress).max()


def fastest(simulation, points):
    """Largest velocity [m/s] that one Newton correction gives the points."""
    state = replace(simulation.state, points=points)
    step = begin(simulation.model, state, 0.04, False, Workspace(simulation.model))
    evaluation = step.evaluate(step.predictor())
    step.assemble(evaluation)
    soil, body, _ = step.system.solve(evaluation.soil, evaluation.body)
    return np.abs(step.accept(step.evaluate(step.moved(evaluation.unknowns, soil, body))).points.velocity).max()


def test_layered_forces_balance_to_round_off():
    """A stress from each layer's own weight times depth, as if it were alone, sets the soil in motion."""
    simulation = build(profile())
    assert fastest(simulation, simulation.state.points) < 1e-10
    points, c = simulation.state.points, simulation.model.soil.constants
    naive = points.stress.copy()
    naive *= (c.mass / c.volume * GRAVITY * -heights(simulation) / -points.stress[:, 2, 2])[:, None, None]
    strain = simulation.model.soil.law.strain(np.diagonal(naive, axis1=1, axis2=2))
    elastic = points.b_elastic.copy()
    elastic[:, range(3), range(3)] = np.exp(2 * strain)
    assert fastest(simulation, replace(points, stress=naive, b_elastic=elastic)) > 1e-4


def test_elastic_layers_stay_elastic():
    """No strength, no history and no plastic work where no layer has any."""
    soft = Layer("soft", bottom=-1.0, material={"young": 1e6})
    law = build(profile((soft,), Material(law="hencky", young=5e6, poisson=0.3, density=1700.0))).model.soil.law
    assert type(law) is Hencky and law.parameters.shape[1] == 2 and set(law.young) == {1e6, 5e6}


@pytest.mark.parametrize("change, words", [
    ({"layers": (replace(CLAY, top=0.6, bottom=0.4),)}, "holds no point: z = 0.4 to 0.6 m"),
    ({"layers": (replace(CLAY, top=-1.0, bottom=-1.01),)}, "thinner than a point"),
    ({"layers": (replace(CLAY, material={**CLAY.material, "strength_gradient": -20e3}),)},
     "clay: .* leaves .* Pa at a"),
    ({"layers": (replace(CLAY, k0=0.2, material={**CLAY.material, "strength": 3e3}),)},
     "the stress at rest at a depth of .* is more than the law can carry.*k0"),
    ({"k0": 0.1}, "more than the law can carry"),
])
def test_layers_that_cannot_be(change, words):
    with pytest.raises(SceneError, match=words):
        build(profile(**change))
