"""Transfer between points and nodes: conservation, exactness, and no dependence on the number of threads."""

from dataclasses import replace

import numba
import numpy as np
import pytest
from tiled import tile

from hybrid.grid.axes import make_grid
from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.linalg.stencil_pattern import make_pattern
from hybrid.soil.basis import evaluate_basis
from hybrid.soil.model import Soil
from hybrid.soil.points import at_rest
from hybrid.soil.transfer import grid_to_points, interpolate

FREE = dict.fromkeys(("x_min", "x_max", "y_min", "y_max", "z_min", "z_max"), "free")
NODES = {
    "uniform": tuple(np.linspace(0.0, 2.0, n) for n in (9, 7, 17)),
    "graded": tuple(2 * np.linspace(0.0, 1.0, n) ** 1.4 for n in (7, 6, 8)),
    "collapsed": (np.linspace(0.0, 2.0, 13), np.array([1.0]), np.linspace(0.0, 2.0, 5)),
}


def soil_on(axes, basis="gimp"):
    """A Soil that fills the inner cells of a grid, and its points, shifted so that domains straddle nodes."""
    rng = np.random.default_rng(5)
    grid = make_grid(axes, np.array([(0.0, 2.0)] * 3), FREE)
    ends = np.array([(a[1], a[-2]) if len(a) > 1 else (0.0, 2.0) for a in grid.axes]).T
    constants = tile(grid, *ends, (2, 2, 2), 1700.0)
    law = DruckerPrager(np.full(len(constants), 1e6), 0.3, 30.0, 5.0, 500.0)
    points = at_rest(constants, np.zeros((len(constants), 3)), np.zeros((len(constants), 3)))
    shift = 0.5 * grid.smallest_cell * rng.uniform(-1, 1, points.position.shape)
    points.position[:, ~grid.collapsed] += shift[:, ~grid.collapsed]
    points.velocity[:] = rng.standard_normal(points.velocity.shape)
    points.acceleration[:] = 10 * rng.standard_normal(points.velocity.shape)
    points.algorithmic = 10 * rng.standard_normal(points.velocity.shape)
    return Soil(grid, constants, law, basis=basis), points


@pytest.fixture(params=[(name, basis) for name in NODES for basis in ("gimp", "mpm")], ids="-".join)
def case(request):
    name, basis = request.param
    soil, points = soil_on(NODES[name], basis)
    return soil, points, soil.begin(points, np.zeros(3))


def test_projection_conserves_mass_and_momentum(case):
    soil, points, step = case
    mass = soil.constants.mass
    assert step.mass.sum() == pytest.approx(mass.sum(), rel=1e-14)
    movable = ~soil.grid.collapsed
    for nodal, carried in zip(step.history, (points.velocity, points.acceleration, points.algorithmic), strict=True):
        exact, size = mass @ carried, mass @ np.abs(carried)
        assert np.all(np.abs(step.mass @ nodal - exact)[movable] <= 1e-14 * size[movable])
        assert not nodal[:, ~movable].any()    # a collapsed axis does not move
        assert not nodal[~step.active].any()


def test_moment_of_mass_is_conserved(case):
    """Linear reproduction: the centre of mass of the nodes is that of the points."""
    soil, points, step = case
    nodes = np.stack([a.ravel() for a in np.meshgrid(*soil.grid.axes, indexing="ij")], axis=1)
    movable = ~soil.grid.collapsed
    nodal, exact = step.mass @ nodes, soil.constants.mass @ points.position
    np.testing.assert_allclose(nodal[movable], exact[movable], rtol=1e-13)


def test_interpolation_is_exact_for_linear_fields(case):
    soil, points, step = case
    rng = np.random.default_rng(1)
    gradient, constant = rng.standard_normal((3, 3)), rng.standard_normal(3)
    gradient[soil.grid.collapsed] = 0.0
    nodes = np.stack([a.ravel() for a in np.meshgrid(*soil.grid.axes, indexing="ij")], axis=1)
    found = interpolate(step.basis, soil.grid.shape, nodes @ gradient + constant)
    np.testing.assert_allclose(found, points.position @ gradient + constant, atol=1e-12)


def test_linear_field_gives_its_gradient(case):
    soil, points, step = case
    gradient = np.random.default_rng(1).uniform(-0.1, 0.1, (3, 3))
    gradient[soil.grid.collapsed] = gradient[:, soil.grid.collapsed] = 0.0
    nodes = np.stack([a.ravel() for a in np.meshgrid(*soil.grid.axes, indexing="ij")], axis=1)
    increment = soil.evaluate(step, nodes @ gradient.T).strain.increment
    assert np.abs(increment - np.eye(3) - gradient).max() < 1e-12


def test_internal_forces_are_in_balance(case):
    """Their sum vanishes, and so does their moment about any point, taken at the displaced nodes."""
    soil, points, step = case
    rng = np.random.default_rng(9)
    displacement = 0.02 * soil.grid.smallest_cell * rng.standard_normal((soil.grid.node_count, 3))
    displacement[soil.grid.fixed] = 0.0
    force = soil.evaluate(step, displacement).force
    nodes = np.stack([a.ravel() for a in np.meshgrid(*soil.grid.axes, indexing="ij")], axis=1) + displacement
    size = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-13 * size
    if not soil.grid.collapsed.any():
        assert np.abs(np.cross(nodes, force).sum(axis=0)).max() < 1e-13 * size * 2.0


def computed(soil, points, displacement):
    """Everything the soil adds into shared arrays, from one begin to the stiffness."""
    step = soil.begin(points, np.array([0.0, 0.0, -9.81]))
    trial = soil.evaluate(step, displacement)
    pattern = make_pattern(step.active, soil.grid.fixed, soil.grid.shape)
    values = np.zeros(len(pattern.indices))
    soil.add_stiffness(step, trial, pattern, values)
    after = soil.accept(step, trial, displacement, displacement, displacement)
    return (step.mass, step.velocity, step.acceleration, trial.force.copy(), trial.stress, values,
            after.position, after.b_elastic, after.half_width)


@pytest.mark.parametrize("name", NODES)
def test_results_do_not_depend_on_the_number_of_threads(name):
    soil, points = soil_on(NODES[name])
    displacement = 0.01 * np.random.default_rng(3).standard_normal((soil.grid.node_count, 3))
    displacement[soil.grid.fixed] = 0.0
    threads, found = numba.get_num_threads(), []
    try:
        for count in (1, 2, 2):
            numba.set_num_threads(count)
            found.append(computed(soil, points, displacement))
    finally:
        numba.set_num_threads(threads)
    for one, two, again in zip(*found):
        assert np.abs(one).max() > 0.0
        assert np.array_equal(one, two) and np.array_equal(two, again)


def nodes_of(grid):
    return np.stack([a.ravel() for a in np.meshgrid(*grid.axes, indexing="ij")], axis=1)


def spin_of_points(soil, points):
    """Angular momentum (3,): of the points, and of the motion within them, Σ m D : C."""
    mass = soil.constants.mass
    orbit = mass @ np.cross(points.position, points.velocity)
    half = points.half_width if soil.basis == "gimp" else np.zeros_like(points.half_width)
    basis = evaluate_basis(points.position, half, soil.grid.axes)
    arm = np.zeros((len(points), 3))
    for axis, nodes in enumerate(soil.grid.axes):
        for a in range(3):
            at = nodes[np.minimum(basis.first[:, axis] + a, len(nodes) - 1)]
            arm[:, axis] += basis.value[:, axis, a] * (at - points.position[:, axis]) ** 2
    own = points.affine[:, 0] * arm[:, None, :]
    return orbit + mass @ np.stack([own[:, 2, 1] - own[:, 1, 2], own[:, 0, 2] - own[:, 2, 0],
                                    own[:, 1, 0] - own[:, 0, 1]], axis=1)


@pytest.mark.parametrize("basis", ["gimp", "mpm"])
@pytest.mark.parametrize("name", ["uniform", "graded"])
def test_affine_transfer_conserves_both_momenta(name, basis):
    """From points to nodes and from nodes to points, with the gradients that the points carry."""
    soil, points = soil_on(NODES[name], basis)
    mass, nodes = soil.constants.mass, nodes_of(soil.grid)
    points.affine = np.random.default_rng(2).standard_normal((len(points), 1, 3, 3))
    step = soil.begin(points, np.zeros(3))
    size = mass @ np.linalg.norm(np.cross(points.position, points.velocity), axis=1)
    np.testing.assert_allclose(step.mass @ step.velocity, mass @ points.velocity, atol=1e-13 * size)
    spin = step.mass @ np.cross(nodes, step.velocity)
    np.testing.assert_allclose(spin, spin_of_points(soil, points), atol=1e-13 * size)
    (velocity,), affine = grid_to_points(step.basis, soil.grid.axes, points.position, [step.velocity])
    np.testing.assert_allclose(velocity, interpolate(step.basis, soil.grid.shape, step.velocity), atol=1e-14 * size)
    seen = replace(points, velocity=velocity, affine=affine)
    np.testing.assert_allclose(mass @ seen.velocity, step.mass @ step.velocity, atol=1e-13 * size)
    np.testing.assert_allclose(spin_of_points(soil, seen), spin, atol=1e-12 * size)


def test_affine_transfer_keeps_linear_fields(case):
    """To the nodes, up to the outermost, and back; without the gradients the outermost nodes lag behind."""
    soil, points, _ = case
    slope = np.random.default_rng(3).uniform(-1, 1, (2, 3, 3))
    slope[:, soil.grid.collapsed] = slope[:, :, soil.grid.collapsed] = 0.0
    points.velocity, points.acceleration = (points.position @ part.T for part in slope)
    points.affine = np.tile(slope, (len(points), 1, 1, 1))
    errors = []
    for given in (points, replace(points, affine=None)):
        step = soil.begin(given, np.zeros(3))
        errors.append([np.abs(field - nodes_of(soil.grid) @ part.T)[step.active].max()
                       for field, part in zip((step.velocity, step.acceleration), slope)])
    assert max(errors[0]) < 1e-12 < 1e-2 < min(errors[1])
    step = soil.begin(points, np.zeros(3))
    _, found = grid_to_points(step.basis, soil.grid.axes, points.position, [step.velocity, step.acceleration])
    np.testing.assert_allclose(found, np.broadcast_to(slope, found.shape), atol=1e-9)


@pytest.mark.parametrize("transfer, share", [("increments", 0.0), ("affine", 1.0)])
def test_rates_that_points_take_up(transfer, share):
    """Momentum is that of the nodes; with affine transfer all of the velocity is theirs, with increments none."""
    soil, points = soil_on(NODES["graded"])
    soil = replace(soil, transfer=transfer)
    step = soil.begin(points, np.zeros(3))
    trial = soil.evaluate(step, np.zeros((soil.grid.node_count, 3)))
    gain = np.random.default_rng(6).standard_normal((soil.grid.node_count, 3))
    after = soil.accept(step, trial, 0 * gain, gain, 0 * gain)
    mass = soil.constants.mass
    size = mass.sum()
    np.testing.assert_allclose(mass @ after.velocity, step.mass @ (step.velocity + gain), atol=1e-13 * size)
    assert (after.affine is None) == (transfer != "affine")
    wanted = points.velocity + interpolate(step.basis, soil.grid.shape, gain)
    lost = np.sum(mass[:, None] * (after.velocity - wanted) ** 2)
    nodal = interpolate(step.basis, soil.grid.shape, step.velocity + gain)
    np.testing.assert_allclose(after.velocity, (1 - share) * wanted + share * nodal, atol=1e-12)
    assert (lost < 1e-20 * size) == (transfer == "increments")
