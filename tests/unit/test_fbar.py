"""F-bar: what the mean gradient reproduces, what its force conserves, and that it does not lock."""

import numpy as np
import pytest
from scattered_points import GRIDS, clear_of_nodes, scattered
from tiled import tile

from hybrid.grid.axes import FACES, make_grid
from hybrid.laws.hencky import Hencky
from hybrid.scene import Axis, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.soil.basis import evaluate_basis
from hybrid.soil import fbar
from hybrid.soil.filled_cells import fill_cells
from hybrid.soil.kinematics import Kinematics
from hybrid.soil.matrices import invert
from hybrid.soil.model import Soil as SoilModel
from hybrid.soil.points import at_rest


def bases(name, standard=False):
    axes = GRIDS[name]
    position, half = scattered(axes)
    half = 0 * half if standard else half
    basis = evaluate_basis(position, half, axes)
    return axes, basis, mean_basis(position, half, axes, basis)


def mean_basis(position, half, axes, basis, volume=None, opens=False):
    """Mean basis of points with a `volume` (n,) [m³], else that of their domains."""
    extent = np.array([(a[0], a[-1]) if len(a) > 1 else (0.0, 1.0) for a in axes])
    grid = make_grid(axes, extent, dict.fromkeys(FACES, "free"))
    volume = 8 * half.prod(axis=1) if volume is None else volume
    return fbar.mean_basis(basis, fill_cells(basis, position, half, volume, np.ones(len(position)), grid), opens)


def gradients(basis, shape, displacement):
    """ΔF - I (n, 3, 3)."""
    points = len(basis.first)
    return Kinematics(points)(basis, shape, displacement, np.tile(np.eye(3), (points, 1, 1))).increment - np.eye(3)


@pytest.mark.parametrize("standard", [False, True], ids=["gimp", "mpm"])
@pytest.mark.parametrize("name", GRIDS)
def test_mean_gradient_of_a_linear_field_is_its_gradient(name, standard):
    axes, basis, mean = bases(name, standard)
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    linear = 0.1 * np.random.default_rng(0).standard_normal((3, 3))
    np.testing.assert_allclose(mean.value.sum(axis=2), 1.0, atol=1e-12)
    found = gradients(mean, [len(a) for a in axes], nodes @ linear.T)
    np.testing.assert_allclose(found, np.broadcast_to(linear, found.shape), atol=1e-9)


def test_mean_gradient_is_that_of_the_centres_of_full_cells():
    """A domain inside one cell takes that cell's, one that overlaps two a mean by volume."""
    axes = (np.array([0.0, 1.0, 3.0]),) * 3
    place = np.array([[0.5, 0.5, 0.5], [1.0, 0.5, 0.5], [0.9, 0.4, 1.6]])
    half = np.array([[0.3] * 3, [0.2] * 3, [0.2] * 3])
    basis = evaluate_basis(place, half, axes)
    mean = mean_basis(place, half, axes, basis, np.full(3, 100.0))
    displacement = 0.1 * np.random.default_rng(3).standard_normal((27, 3))
    centres = np.array([[0.5, 0.5, 0.5], [2.0, 0.5, 0.5], [0.5, 0.5, 2.0], [2.0, 0.5, 2.0]])
    a, b, c, d = gradients(evaluate_basis(centres, np.zeros((4, 3)), axes), (3, 3, 3), displacement)
    wanted = [a, 0.5 * (a + b), 0.75 * c + 0.25 * d]
    np.testing.assert_allclose(gradients(mean, (3, 3, 3), displacement), wanted, atol=1e-12)


def test_mean_gradient_is_that_of_the_middle_of_the_soil_in_a_cut_cell():
    """Two points of unequal volume in a cell of which a tenth is filled; halfway to the centre where 1 - CUT / 2 is."""
    axes = (np.array([0.0, 1.0, 3.0]),) * 3
    place, half = np.array([[0.2, 0.3, 0.6], [0.5, 0.3, 0.2]]), np.full((2, 3), 0.05)
    basis, volume = evaluate_basis(place, half, axes), np.array([0.025, 0.075])
    displacement = 0.1 * np.random.default_rng(3).standard_normal((27, 3))
    middle, centre = np.array([0.425, 0.3, 0.3]), np.full(3, 0.5)
    for scale, at in ((1.0, middle), (10.0 * (1.0 - 0.5 * fbar.CUT), 0.5 * (middle + centre))):
        mean = mean_basis(place, half, axes, basis, scale * volume)
        wanted = gradients(evaluate_basis(at[None], np.zeros((1, 3)), axes), (3, 3, 3), displacement)
        np.testing.assert_allclose(gradients(mean, (3, 3, 3), displacement), np.repeat(wanted, 2, axis=0), atol=1e-12)


def test_points_that_can_open_keep_a_share_of_their_own_gradient():
    """In plane strain, where the gradient is linear in m_v; in clay beside them, none."""
    axes, rng = (np.linspace(0.0, 1.0, 6), np.linspace(0.0, 1.0, 5), np.array([0.0])), np.random.default_rng(6)
    place, half = np.column_stack([rng.uniform(0.1, 0.9, (50, 2)), np.zeros(50)]), np.tile([0.05, 0.05, 0.5], (50, 1))
    basis, opens = evaluate_basis(place, half, axes), np.arange(50) < 20
    displacement = rng.standard_normal((30, 3)) * (1, 1, 0)
    own, mean, found = (gradients(one, (6, 5, 1), 0.01 * displacement) for one in (
        basis, mean_basis(place, half, axes, basis), mean_basis(place, half, axes, basis, opens=opens)))
    share = np.where(opens, fbar.OWN, 0.0)[:, None, None]
    np.testing.assert_allclose(found, mean + share * (own - mean), atol=1e-14)
    assert np.abs(own - mean)[opens].max() > 1e-2


def test_only_axes_that_deform_are_scaled():
    """In plane strain b_trial has the determinant of ΔF_0 squared, and no strain across the plane."""
    axes, rng = (np.linspace(0.0, 1.0, 6), np.linspace(0.0, 1.0, 5), np.array([0.0])), np.random.default_rng(6)
    place = np.column_stack([rng.uniform(0.1, 0.9, (200, 2)), np.zeros(200)])
    half = np.tile([0.05, 0.05, 0.5], (200, 1))
    basis = evaluate_basis(place, half, axes)
    mean = mean_basis(place, half, axes, basis)
    displacement = 0.03 * rng.standard_normal((30, 3)) * (1, 1, 0)
    trial = Kinematics(200, fbar=True)(basis, (6, 5, 1), displacement, np.tile(np.eye(3), (200, 1, 1)), mean)
    volume = 1 / np.linalg.det(trial.mean_inverse)
    assert np.abs(volume / np.linalg.det(trial.increment) - 1).max() > 0.01
    np.testing.assert_allclose(trial.strain.sum(axis=1), np.log(volume), atol=1e-12)
    np.testing.assert_allclose(np.abs(trial.strain).min(axis=1), 0.0, atol=1e-12)


def test_mean_gradient_of_a_moving_point_is_continuous():
    axes = GRIDS["graded"]
    position, half = scattered(axes)
    keep = clear_of_nodes(position, half, axes, 1e-3)
    displacement = np.random.default_rng(1).standard_normal((np.prod([len(a) for a in axes]), 3))
    found = []
    for step in (0.0, 1e-7):
        basis = evaluate_basis(position[keep] + step, half[keep], axes)
        mean = mean_basis(position[keep] + step, half[keep], axes, basis)
        found.append(gradients(mean, [len(a) for a in axes], 1e-3 * displacement))
    assert np.abs(found[1] - found[0]).max() < 1e-5


def test_force_has_no_resultant_and_no_moment():
    """Of scattered, stressed points in free space, at the trial positions of the nodes."""
    axes = GRIDS["graded"]
    grid = make_grid(axes, np.array([(a[0], a[-1]) for a in axes]), dict.fromkeys(FACES, "free"))
    constants = tile(grid, grid.extent[:, 0], grid.extent[:, 1], (2, 1, 2), 1000.0)
    soil = SoilModel(grid, constants, Hencky(np.full(len(constants), 1e6), 0.3), fbar=True)
    strain = 0.02 * np.random.default_rng(4).standard_normal((len(constants), 3))
    step = soil.begin(at_rest(constants, np.zeros_like(strain), strain), np.zeros(3))
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    displacement = 0.01 * np.random.default_rng(5).standard_normal(nodes.shape)
    force = soil.evaluate(step, displacement).force
    size = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-13 * size
    assert np.abs(np.cross(nodes + displacement, force).sum(axis=0)).max() < 1e-13 * size


def sagging(poisson, fbar, full=False, cells=4):
    """Sag [m] of a beam of 4 x 1 m, clamped at its left end, under its weight in plane strain, small strains.

    full: the same in three dimensions between rollers.
    """
    size = 1.0 / cells
    along = Axis(start=0.0, end=5.0, size=size)
    up = Axis(start=-1.0, end=1.0, size=size)
    scene = Scene(
        name="beam", grid=Grid(along, Axis(start=0.0, end=size, size=size, collapsed=not full), up,
                               Faces(x_min="fixed", x_max="free", z_min="free")),
        soil=Soil(Material(law="hencky", young=1e6, poisson=poisson, density=1.0), lower=(0.0, 0.0, 0.0),
                  upper=(4.0, size, 1.0), geostatic=False, fbar=fbar),
        time=Time(step=1.0, inertia=False), stages=(Stage("load", 1),), solver=Solver(linear="direct"))
    simulation = build(scene)
    for _ in simulation.steps():
        pass
    return -simulation.state.points.position[:, 2].mean() + 0.5


def test_beam_does_not_lock():
    """Timoshenko's mean sag q/EI (L^4/20 ...): E/(1-ν²) is all that Poisson's ratio changes; locked, nearly nothing."""
    scale = {nu: 1 - nu**2 for nu in (0.0, 0.4999)}
    stiff, soft = (sagging(0.4999, fbar) / scale[0.4999] for fbar in (False, True))
    loose = sagging(0.0, True) / scale[0.0]
    assert soft == pytest.approx(loose, rel=0.03)
    assert stiff < 0.25 * loose


def test_plane_strain_agrees_with_three_dimensions_as_cells_shrink():
    """Between rollers all three axes are scaled, in plane strain two: 2 % apart with 2 cells in the beam's depth."""
    apart = [abs(sagging(0.45, True, True, cells) / sagging(0.45, True, False, cells) - 1) for cells in (2, 4)]
    assert apart[1] < 0.4 * apart[0] < 0.01


def test_a_matrix_without_inverse_is_no_error():
    """An update may flatten soil altogether, which is to be refused and not to end the run."""
    out = np.empty((3, 3))
    assert invert(np.zeros((3, 3)), out) == 0.0 and not np.isfinite(out).any()
