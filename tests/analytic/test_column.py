"""Soil under its own weight: at rest from the start, compressed in a column, and in free fall.

Column (no lateral strain, ν = 0): the area of a section stays, so σ_zz = -ρ g (L - Z) at initial height Z.
Hencky's law E ln λ / λ = σ_zz gives λ = W(s)/s with s = ρ g (L - Z)/E and Lambert's W, and the height ∫ λ dZ.
"""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.scene import Axis, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.step.energy import balance_error, energies
from hybrid.step.equations import begin
from hybrid.step.loads import Loads
from hybrid.step.workspace import Workspace
from hybrid.study.precision.problems.column import SELF_WEIGHT

YOUNG, DENSITY, GRAVITY, LENGTH = SELF_WEIGHT.young, SELF_WEIGHT.density, SELF_WEIGHT.gravity, SELF_WEIGHT.length
WEIGHT = SELF_WEIGHT.weight


def column(cells, steps=50, full=False, basis="gimp", domain="moments"):
    """(points, initial heights, height) of a column under gravity in equal increments, without inertia."""
    size = LENGTH / cells
    side = Axis(start=0.0, end=size, size=size, collapsed=not full)
    scene = Scene(
        name="column", grid=Grid(side, side, Axis(start=0.0, end=LENGTH, size=size)),
        soil=Soil(Material(law="hencky", young=YOUNG, poisson=0.0, density=DENSITY), geostatic=False,
                  basis=basis, domain=domain),
        time=Time(step=1.0, inertia=False), stages=(Stage("load", steps, gravity=(0.0, 1.0)),),
        solver=Solver(linear="direct", tolerance=1e-9))
    simulation = build(scene)
    for record in simulation.steps():
        assert record.increments == 1
    points, constants = simulation.state.points, simulation.model.soil.constants
    top = np.argmax(points.position[:, 2])
    height = points.position[top, 2] + constants.half_width[top, 2] * points.deformation[top, 2, 2]
    return points, constants.position[:, 2], height


def errors(cells, **options):
    """Mean error of the stress relative to that at the bottom, and error of the height [m]."""
    points, Z, height = column(cells, **options)
    wanted = -DENSITY * GRAVITY * (LENGTH - Z)
    return np.abs(points.stress[:, 2, 2] - wanted).mean() / WEIGHT, abs(height - SELF_WEIGHT.height())


def rates(cells, **options):
    """Observed orders in the cell size of the errors of stress and height."""
    found = np.array([errors(n, **options) for n in cells])
    return -np.polyfit(np.log(cells), np.log(found), 1)[0]


def test_reference_height():
    assert SELF_WEIGHT.height() == pytest.approx(0.538602, abs=5e-7)


def test_column_of_the_benchmark():
    """16 cells, 2 points a cell, 50 steps: stress within 0.4 % of its largest, height within 0.6 mm."""
    stress, height = errors(16)
    assert stress < 4e-3 and height < 6e-4


def test_column_converges_with_gimp():
    """Though domains cross nodes and shrink to a half, stress and height converge faster than first order."""
    stress, height = rates([8, 16, 32, 64])
    assert stress > 1.5 and height > 1.2


def test_column_does_not_converge_with_standard_points():
    """Points that cross nodes spoil the stress of the standard method: the known failure is seen."""
    stress, height = rates([8, 16, 32, 64], basis="mpm", domain="none")
    assert stress < 0.3 and height < 0.3


def test_domains_have_to_follow_the_compression():
    """Rigid domains overlap as the column shortens: the error settles at a level."""
    assert errors(64, domain="none")[0] > 10 * errors(64)[0]


def test_column_in_one_step_has_the_orders_of_linear_elements():
    """Nothing crosses a node then: first order in the stress of a cell, second in the height."""
    assert rates([8, 16, 32, 64], steps=1) == pytest.approx([1.0, 2.0], abs=0.02)


def test_three_dimensions_agree_with_the_column():
    line, Z, height = column(8)
    block, Z3, height3 = column(8, full=True)
    order, order3 = np.argsort(Z), np.argsort(Z3, kind="stable").reshape(-1, 4)
    assert height3 == pytest.approx(height, rel=1e-12)
    position = block.position[order3, 2] - line.position[order, None, 2]
    stress = block.stress[order3, 2, 2] - line.stress[order, None, 2, 2]
    assert np.abs(position).max() < 1e-12 and np.abs(stress).max() < 1e-10 * WEIGHT
    block.stress[:, 2, 2] = 0.0
    assert np.abs(block.stress).max() < 1e-10 * WEIGHT


MATERIALS = {
    "hencky": Material(law="hencky", young=5e6, poisson=0.3, density=1700.0),
    "sand": Material(relative_density=38.0),
}


def at_rest(material, steps=5):
    """Soil in geostatic stress on a grid graded along all three axes, 0.5 m of empty cells above it."""
    side = Axis(start=0.0, end=4.0, size=0.25, fine=(1.0, 2.0), growth=1.4)
    up = Axis(start=-2.0, end=0.5, size=0.25, fine=(-0.75, 0.5), growth=1.3)
    return Scene(name="rest", grid=Grid(side, side, up), soil=Soil(MATERIALS[material], top=0.0),
                 time=Time(step=0.04), stages=(Stage("rest", steps),))


@pytest.mark.parametrize("material", MATERIALS)
def test_geostatic_start_stays_still(material):
    simulation = build(at_rest(material))
    before = simulation.state.points
    for record in simulation.steps():
        assert record.rejections == 0 and record.residual < 1e-12
    after = simulation.state.points
    assert simulation.state.step == 5 and simulation.state.time == pytest.approx(0.2)
    assert np.abs(after.velocity).max() < 1e-10 and np.abs(after.position - before.position).max() < 1e-12
    assert np.abs(after.stress - before.stress).max() < 1e-12 * np.abs(before.stress).max()
    assert after.plastic_strain.max() < 1e-12
    depth = -before.position[:, 2]
    density = simulation.model.soil.constants.mass[0] / simulation.model.soil.constants.volume[0]
    np.testing.assert_allclose(before.stress[:, 2, 2], -density * GRAVITY * depth, rtol=1e-12)


@pytest.mark.parametrize("material", MATERIALS)
def test_geostatic_forces_balance_to_round_off(material):
    """One Newton correction, that a run would not even make, moves nothing; with 1 % more gravity it does."""
    simulation = build(at_rest(material))
    model, fastest = simulation.model, []
    for factor in (1.0, 1.01):
        heavier = replace(model, loads=Loads(factor * model.gravity))
        step = begin(heavier, simulation.state, 0.04, False, Workspace(heavier))
        evaluation = step.evaluate(step.predictor())
        step.assemble(evaluation)
        soil, body, _ = step.system.solve(evaluation.soil, evaluation.body)
        moved = step.evaluate(step.moved(evaluation.unknowns, soil, body))
        fastest.append(np.abs(step.accept(moved).points.velocity).max())
    assert fastest[0] < 1e-10 < 1e-4 < fastest[1]


def test_block_in_free_fall():
    """Newmark's rule is exact for a uniform acceleration: positions, momentum and energy; no stress."""
    axis, dt, steps = Axis(start=-1.0, end=1.2, size=0.2), 0.04, 12
    gravity, velocity = np.array([1.0, 0.5, -9.81]), np.array([-0.7, 0.4, 1.1])
    scene = Scene(
        name="fall", grid=Grid(axis, axis, Axis(start=-2.0, end=1.2, size=0.2), Faces(*["free"] * 6)),
        soil=Soil(Material(law="hencky", young=1e5, poisson=0.3, density=1500.0), lower=(-0.2, -0.4, 0.0),
                  upper=(0.4, 0.2, 0.6), geostatic=False),
        gravity=tuple(gravity), time=Time(step=dt), stages=(Stage("fall", steps),),
        solver=Solver(tolerance=1e-13, linear="direct"))
    simulation = build(scene)
    start = simulation.state.points
    start.velocity[:], start.acceleration[:] = velocity, gravity
    before, cells = energies(simulation.model, simulation.state), set()
    for n, record in enumerate(simulation.steps(), 1):
        points, t = simulation.state.points, n * dt
        fallen = points.position - start.position
        assert np.abs(fallen - (velocity * t + gravity * t**2 / 2)).max() < 1e-12
        mass = simulation.model.soil.constants.mass
        np.testing.assert_allclose(mass @ points.velocity, mass.sum() * (velocity + gravity * t), rtol=1e-11)
        assert np.abs(points.stress).max() < 1e-7      # [Pa], of a Young's modulus of 1e5
        assert abs(balance_error(record.energies, before)) < 1e-10 * mass.sum()
        cells.add(int(np.floor(points.position[0, 2] / 0.2)))
    assert len(cells) > 3      # domains have crossed nodes on the way
