"""Internal force of the soil: the virtual work of the stress, and no force or moment in sum."""

import numpy as np
import pytest
from scattered_points import GRIDS, scattered

from hybrid.grid.colouring import make_slabs
from hybrid.soil.basis import evaluate_basis
from hybrid.soil.forces import internal_force
from hybrid.soil.kinematics import Kinematics


class Deformed:
    """Scattered points at random increments of the nodes, under random Kirchhoff stresses."""

    def __init__(self, name):
        axes, rng = GRIDS[name], np.random.default_rng(4)
        position, half = scattered(axes)
        self.basis, self.shape = evaluate_basis(position, half, axes), tuple(map(len, axes))
        self.nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
        self.displacement = 0.01 * rng.standard_normal(self.nodes.shape)
        stress = rng.standard_normal((len(position), 3, 3))
        self.stress, self.volume = stress + stress.swapaxes(1, 2), rng.uniform(0.5, 1.5, len(position))
        self.trial = self.strains(self.displacement)
        self.force = internal_force(self.basis, make_slabs(self.basis.first, self.shape), self.shape, self.trial,
                                    self.stress, self.volume)

    def strains(self, displacement):
        count = len(self.basis.first)
        return Kinematics(count)(self.basis, self.shape, displacement, np.tile(np.eye(3), (count, 1, 1)))


@pytest.fixture(params=GRIDS)
def deformed(request):
    return Deformed(request.param)


def test_work_on_any_virtual_displacement_is_that_of_the_stress(deformed):
    """f·δu = Σ V0 τ : δF ΔF^-1, where δF is linear in δu."""
    virtual = np.random.default_rng(5).standard_normal(deformed.force.shape)
    gain = deformed.strains(virtual).increment - np.eye(3)
    work = np.einsum("n,nij,nik,nkj->", deformed.volume, deformed.stress, gain, deformed.trial.inverse)
    scale = np.linalg.norm(virtual) * np.linalg.norm(deformed.force)
    assert np.sum(deformed.force * virtual) == pytest.approx(work, abs=1e-12 * scale) and abs(work) > 1e-3 * scale


def test_force_and_moment_vanish_in_sum(deformed):
    """The moment about places of the deformed grid, as the stress is symmetric."""
    place, scale = deformed.nodes + deformed.displacement, np.abs(deformed.force).sum()
    assert np.abs(deformed.force.sum(axis=0)).max() < 1e-13 * scale
    assert np.abs(np.cross(place, deformed.force).sum(axis=0)).max() < 1e-12 * scale
