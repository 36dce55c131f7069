"""Ghost penalty: which faces, what it leaves free, its tangent, and the condition of cut cells."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from tiled import tile

from hybrid.grid.axes import FACES, graded_nodes, make_grid
from hybrid.laws.hencky import Hencky
from hybrid.linalg.stencil_pattern import make_pattern
from hybrid.soil.basis import evaluate_basis
from hybrid.soil.filled_cells import FilledCells, fill_cells
from hybrid.soil.ghost import find_faces
from hybrid.soil.model import Soil
from hybrid.soil.points import at_rest

YOUNG, FACTOR = 1e6, 0.3
FREE = dict.fromkeys(FACES, "free")


def block(cells=3, offset=0.0, factor=FACTOR, plane=False, faces=FREE, size=1.0, graded=False):
    """A cube of soil of `cells` cells in a grid with room around it, moved by `offset` [m] along all axes."""
    nodes = size * np.arange(-1.0, cells + 3.0)
    if graded:
        nodes = graded_nodes(-1.0, cells + 2.0, 0.5, (0.0, 1.0), 1.5)
    axes = (nodes, np.array([0.5]) if plane else nodes, nodes)
    extent = np.array([(0.0, 1.0) if len(a) == 1 else (a[0], a[-1]) for a in axes])
    grid = make_grid(axes, extent, faces)
    constants = tile(grid, np.array([nodes[1]] * 3), np.array([nodes[-3]] * 3), (2, 2, 2), 1000.0)
    soil = Soil(grid, constants, Hencky(np.full(len(constants), YOUNG), 0.3), domain="none", ghost_factor=factor)
    points = at_rest(constants, np.zeros((len(constants), 3)), np.zeros((len(constants), 3)))
    points.position = points.position + offset * ~grid.collapsed
    return soil, soil.begin(points, np.zeros(3))


def stiffness(soil, step):
    displacement = np.zeros((soil.grid.node_count, 3))
    pattern = make_pattern(step.active, soil.grid.fixed, soil.grid.shape)
    values = np.zeros(len(pattern.indices))
    soil.add_stiffness(step, soil.evaluate(step, displacement), pattern, values)
    return csr_matrix((values, pattern.indices, pattern.indptr)), pattern


def nodes_of(grid):
    return np.stack(np.meshgrid(*grid.axes, indexing="ij"), -1).reshape(-1, 3)


def weights(step):
    """{face: penalty over that of an empty cell} of a step."""
    return {tuple(map(int, face)): modulus / (FACTOR * YOUNG)
            for face, modulus in zip(step.cuts.faces, step.cuts.modulus)}


def test_full_cells_are_left_alone():
    """Of a cube on whole cells no face, in plane strain neither."""
    assert not len(block(3)[1].cuts.faces) and not len(block(3, plane=True)[1].cuts.faces)


def test_cells_are_tied_to_their_fullest_neighbour_only():
    """A plane block of 2 x 2 cells moved by s of a cell along both axes fills its outer cells by s or 1 - s: each is
    tied to the full one in the middle, with (1 - s)² or s², and a corner to both of its neighbours if they are alike,
    else to the fuller one."""
    s = 0.2
    found = weights(block(2, s, plane=True)[1])
    along = {face: w for face, w in found.items() if face[2] == 2 and face[3] == 0}     # the row through the middle
    assert along == {(1, 0, 2, 0): pytest.approx(s**2), (2, 0, 2, 0): pytest.approx((1 - s) ** 2)}
    corner = {face: w for face, w in found.items() if face[3] == 0 and face[2] == 3}    # above that row
    assert corner == {(2, 0, 3, 0): pytest.approx((1 - s**2) ** 2)}
    assert len(found) == 4 + 2 * 4 - 2 and {face[3] for face in found} == {0, 2}


def test_a_weight_grows_from_zero_as_a_cell_empties():
    largest = [max(weights(block(2, s, plane=True)[1]).values()) for s in (1e-3, 1e-2, 0.1)]
    assert largest == sorted(largest, reverse=True) and largest[0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("beside, modulus", [((0.7, 1.0), 1.0), ((0.0, 0.0), 1000.0)])
def test_a_trace_of_rock_on_rock_holds_clay_beside_it_by_the_modulus_of_clay_only(beside, modulus):
    """A plane row of rock, E = 1000, with a trace of it above its first cell; clay, E = 1, or nothing is on the others."""
    share = np.array([[1.0, 1.0, 1.0], [1e-9, *beside]]).T[:, None]
    young = np.array([[1000.0, 1000.0, 1000.0], [1000.0, 1.0, 1.0]]).T[:, None]
    grid = SimpleNamespace(cells_from_owners=lambda values: values, owned_cells=True)
    found = find_faces(FilledCells(None, None, share, share, share * young, None), grid, FACTOR)
    assert [0, 0, 0, 2] in found.faces.tolist() and found.modulus.max() == pytest.approx(FACTOR * modulus)


def test_soil_up_to_the_end_of_the_grid_is_not_cut_there():
    """Points fill the grid along y and z and end half-way in a cell along x."""
    axes = (np.arange(5.0), np.arange(4.0), np.arange(4.0))
    grid = make_grid(axes, np.array([(a[0], a[-1]) for a in axes]), FREE)
    constants = tile(grid, np.zeros(3), np.array([3.0, 3.0, 3.0]), (1, 1, 1), 1.0)
    position = constants.position + [0.5, 0.0, 0.0]
    cells = fill_cells(evaluate_basis(position, constants.half_width, grid.axes), position, constants.half_width,
                       constants.volume, np.full(27, 8.0), grid)
    faces = find_faces(cells, grid, 1.0)
    assert {tuple(f) for f in faces.faces} == {(i, j, k, 0) for i in (0, 2) for j in range(3) for k in range(3)}
    np.testing.assert_allclose(faces.modulus, 8.0 * 0.25)


@pytest.mark.parametrize("plane", [False, True], ids=["block", "plane strain"])
def test_linear_fields_are_free(plane):
    """Translation, rotation and constant strain, on cells of any size; other fields are not."""
    with_, without = (block(factor=f, plane=plane, graded=True, offset=0.1) for f in (FACTOR, 0.0))
    nodes, rng = nodes_of(with_[0].grid), np.random.default_rng(1)
    linear = 1e-3 * (nodes @ rng.standard_normal((3, 3)) + rng.standard_normal(3))
    linear *= ~with_[0].grid.collapsed
    force = [soil.evaluate(step, linear).force for soil, step in (with_, without)]
    assert np.abs(force[0] - force[1]).max() < 1e-9
    curved = 1e-3 * nodes[:, [2, 1, 0]] ** 2 * ~with_[0].grid.collapsed
    force = [soil.evaluate(step, curved).force for soil, step in (with_, without)]
    assert np.abs(force[0] - force[1]).max() > 1.0
    assert np.abs((force[0] - force[1]).sum(axis=0)).max() < 1e-9


@pytest.mark.parametrize("plane", [False, True], ids=["block", "plane strain"])
def test_stiffness_is_the_derivative_of_the_force(plane):
    """Exactly, the penalty being linear, next to held faces too; and symmetric."""
    faces = FREE | {"z_min": "fixed", "x_min": "roller"}
    pairs = [block(2, 0.3, f, plane, faces, graded=True) for f in (FACTOR, 0.0)]
    K, K0 = (stiffness(*pair)[0] for pair in pairs)
    pattern = stiffness(*pairs[0])[1]
    d = 1e-4 * np.random.default_rng(2).standard_normal((pairs[0][0].grid.node_count, 3)) * pattern.free
    force = [soil.evaluate(step, d).force[pattern.free] for soil, step in pairs]
    np.testing.assert_allclose((K - K0) @ d[pattern.free], force[0] - force[1], atol=1e-9 * np.abs(force).max())
    assert abs(K - K.T).max() < 1e-13 * abs(K).max()


def condition(offset, factor, size=1.0):
    """Condition number of the stiffness of a cube moved through the grid, rigid motions left out."""
    soil, step = block(2, offset * size, factor, size=size)
    eigenvalues = np.linalg.eigvalsh(stiffness(soil, step)[0].toarray())
    return eigenvalues[-1] / eigenvalues[6]


def test_condition_does_not_depend_on_the_cut():
    """A rigid translation through a cell: without the penalty the condition grows as the cut shrinks, with it it does
    not, and it is the same for small cells."""
    bare, tied = ([condition(cut, factor) for cut in (0.5, 0.3, 0.1, 1e-3)] for factor in (0.0, FACTOR))
    assert bare[2] > 1e4 * bare[1] > 1e6 * bare[0]      # and past what can be computed for the last
    assert max(tied) < 15 * tied[0] and tied[1] < 1e-3 * bare[1]
    assert condition(1e-7, FACTOR) < 1.01 * tied[-1]
    assert condition(1e-4, FACTOR, 0.01) == pytest.approx(condition(1e-4, FACTOR), rel=1e-6)
