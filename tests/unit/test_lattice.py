"""Points known by their numbers in each cell: what several processes lay out is what one lays out."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.grid.axes import cell_numbers
from hybrid.grid.blocks import cut_into_blocks
from hybrid.laws.user import made, refuse_unlike
from hybrid.laws.von_mises import VonMises
from hybrid.runtime.errors import LawError, SceneError
from hybrid.scene import Axis, Faces, Grid, Layer, Material, Scene, Soil, Stage, Time
from hybrid.scene.defaults import resolve
from hybrid.setup.grid import build_grid
from hybrid.setup.soil import count_points, lay_out
from hybrid.state import PointConstants
from hybrid.step import processes

SAND = Material(law="drucker-prager", young=2e7, poisson=0.3, density=1700.0, friction_angle=35.0, dilation_angle=5.0,
                cohesion=2e4)
LAYERS = (Layer("dense", bottom=-2.0, top=-1.0, material={"density": 2000.0, "hardening": 1e5}),)
SLOPE = ((0.0, 0.5), (1.5, 0.5), (2.5, -1.1), (4.0, -1.0))
GRAVITY = np.array([0.0, 0.0, -9.81])


def soil_and_grid(**soil):
    """A graded grid of 4 x 1 x 3 m and soil in it."""
    grid = Grid(Axis(start=0.0, end=4.0, size=0.2, fine=(1.0, 2.0), growth=1.3), Axis(start=0.0, end=1.0, size=0.25),
                Axis(start=-2.0, end=1.0, size=0.125, fine=(-0.5, 0.5), growth=1.3), Faces(z_min="fixed"))
    scene, _ = resolve(Scene(name="s", grid=grid, soil=Soil(SAND, **soil), time=Time(1.0), stages=(Stage("rest", 1),)))
    return scene.soil, build_grid(scene)[0]


def boxes_of(grid, counts, parts):
    for low, high in cut_into_blocks(counts, parts):
        cells = np.zeros(counts.shape, bool)
        cells[tuple(map(slice, low, high))] = True
        yield cells


GROUNDS = pytest.mark.parametrize("soil", [{"top": 0.0}, {"top": 0.0, "layers": LAYERS}, {"top": 0.5, "ground": SLOPE},
                                           {"top": 0.5, "ground": SLOPE, "layers": LAYERS}])


@GROUNDS
def test_counts_are_those_of_the_points(soil):
    described, grid = soil_and_grid(**soil)
    position = lay_out(described, grid, GRAVITY)[0].position
    cell, shape = cell_numbers(position, grid)
    counts = count_points(described, grid)
    assert counts.shape == tuple(shape) and (counts.ravel() == np.bincount(cell, minlength=counts.size)).all()


@GROUNDS
@pytest.mark.parametrize("parts", [2, 5])
def test_blocks_together_are_the_whole(soil, parts, monkeypatch):
    """To round-off of the weight above, and each part makes no more points at a time than it has, or a column."""
    described, grid = soil_and_grid(**soil)
    constants, stress, law = lay_out(described, grid, GRAVITY)
    counts, made_at_once = count_points(described, grid), []
    whole, numbers = len(constants), []
    make = PointConstants.__init__

    def watched(self, *given, **named):
        make(self, *given, **named)
        made_at_once.append(len(self))

    monkeypatch.setattr(PointConstants, "__init__", watched)
    for cells in boxes_of(grid, counts, parts):
        part, own, own_law = lay_out(described, grid, GRAVITY, cells=cells)
        assert len(part) == counts[cells].sum() and (np.diff(part.number) > 0).all()
        for name in ("position", "half_width", "volume", "mass", "geostatic_gradient"):
            np.testing.assert_array_equal(getattr(part, name), getattr(constants, name)[part.number])
        np.testing.assert_allclose(own, stress[part.number], rtol=0.0, atol=1e-12 * np.abs(stress).max())
        np.testing.assert_allclose(own_law.rows, law.rows[part.number], rtol=1e-11)
        numbers.append(part.number)
    assert sorted(np.concatenate(numbers)) == list(range(whole)) and max(made_at_once) < 1.4 * whole / parts


def test_shares_are_even_however_few_cells_there_are():
    counts = np.zeros((3, 1, 40), int)
    counts[2, 0, 10:20] = 4
    shares = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(processes.ranks, "started", lambda: 16)
        for rank in range(16):
            patch.setattr(processes.ranks, "rank", lambda rank=rank: rank)
            shares.append(processes.share(counts))
    assert (np.sum(shares, axis=0)[counts > 0] == 1).all() and max(counts[own].sum() for own in shares) == 4


def test_ground_below_the_grid_leaves_no_soil():
    described, grid = soil_and_grid(top=0.5, ground=SLOPE)
    with pytest.raises(SceneError, match="no soil lies below it"):
        count_points(replace(described, ground=((0.0, -5.0), (1.0, -5.0))), grid)


@pytest.mark.parametrize("wrong", ["order", "number", "top", "drawn"])
def test_a_law_of_other_points_is_refused(wrong):
    described, grid = soil_and_grid(top=0.0)
    constants, stress, _ = lay_out(described, grid, GRAVITY)

    def clay(points, stress):
        n, z = len(points), points.position[:, 2]
        strength = 1e3 + {"": 200.0 * z, "order": 5.0 * np.arange(n), "number": n * np.ones(n), "top": 500.0 * (z.max() - z),
                          "drawn": 1e3 * np.random.default_rng(1).random(n)}[kind[0]]
        return VonMises(np.full(n, 1e6), 0.3, strength)

    kind = [""]
    refuse_unlike(made(clay, constants, stress))
    kind[0] = wrong
    with pytest.raises(LawError, match="is not that of all points there"):
        refuse_unlike(made(clay, constants, stress))
