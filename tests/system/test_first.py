"""The first scene of README.md: the force on the footing is the one the page names, and Prandtl's to 5 %."""

from pathlib import Path

import numpy as np
import pytest

from hybrid.scene.file import load_scene
from hybrid.setup.build import build

DEMO = Path(__file__).parents[2] / "demos" / "first.toml"
HALF_WIDTH, STRENGTH, PAGE = 0.8, 10e3, 42.8e3      # [m], [Pa], [N] as README.md has it


def test_clay_carries_what_the_page_and_prandtl_say():
    records = list(build(load_scene(DEMO)).steps())
    force = np.array([record.bodies[0].contact_force[2] for record in records])
    assert len(force) == 20 and all(record.notes == () and record.rejections == 0 for record in records)
    assert force[-1] == pytest.approx(PAGE, rel=2e-3)
    assert force[-1] / (HALF_WIDTH * STRENGTH) == pytest.approx(2 + np.pi, rel=0.05)
    assert np.ptp(force[-3:]) < 0.005 * force[-1]        # the clay flows: the force has stopped growing
