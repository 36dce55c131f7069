"""The articulated anchor of demos/ac14.toml: masses of its parts, and a coarse form of its drag."""

import numpy as np
import pytest

from hybrid.body.mesh import generate
from hybrid.body.smooth_mass import mass_and_surface
from hybrid.runtime.data import DEMOS, GEOMETRY
from hybrid.scene.file import load_scene
from hybrid.setup.build import build

# Published of the halves: mass [kg], moment of inertia about y [kg m²], x of the centre [m]
PUBLISHED = {"ac14_fluke": (3291.6, 275.0, 0.62), "ac14_shank": (1058.4, 337.5, 1.7592)}
HINGE = np.array([0.489, 0.0, 0.0])

@pytest.mark.parametrize("name", PUBLISHED)
def test_masses_and_inertias_are_near_the_published_ones(name):
    mass, inertia, centre = PUBLISHED[name]
    found, _ = mass_and_surface(generate(GEOMETRY / f"{name}.geo"), 7850.0)
    assert found.mass == pytest.approx(mass, rel=0.02)
    assert found.inertia[1, 1] == pytest.approx(inertia, rel=0.02)
    np.testing.assert_allclose(found.centre[[0, 2]], [centre, 0.0], atol=0.01)


def test_the_hinge_holds_and_the_fluke_turns_downwards():
    """Over the first 0.4 m of drag: the whole demo turns it to its stop at 35 degrees, after 1.7 m."""
    simulation = build(load_scene(DEMOS / "ac14.toml", ["stage.drag.steps=20", "output.pictures=[]"]))
    records = list(simulation.steps())
    poses = dict(zip(simulation.body_names, simulation.state.bodies))
    at = [poses[name].position + poses[name].rotation @ (HINGE - mass.centre) * (1, 0, 1)
          for name, mass in zip(simulation.body_names, simulation.masses)]
    np.testing.assert_allclose(at[0][[0, 2]], at[1][[0, 2]], atol=1e-6)
    angle = np.array([record.joints[0].angle for record in records])
    assert angle[-1] == pytest.approx(14.2, abs=1.5) and angle.max() < 35.0
    tension = np.array([record.bodies[0].line_tension for record in records])
    assert tension[-20:].mean() == pytest.approx(22e3, rel=0.2)
    assert sum(record.rejections for record in records) <= 2
