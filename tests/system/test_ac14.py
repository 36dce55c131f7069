"""The articulated anchor of demos/ac14.toml: masses of its parts, and a coarse form of its drag."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.body.mesh import generate
from hybrid.body.smooth_mass import mass_and_surface
from hybrid.runtime.data import DEMOS, GEOMETRY
from hybrid.scene import Body, Joint, Load
from hybrid.scene.file import load_scene
from hybrid.setup.build import build
from hybrid.study.scenes import plane

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
    """Over the first 0.2 m of drag, in cells of 0.4 m: those of the demo turn it to its stop at 35 degrees, after 1.9 m."""
    coarse = [f"grid.{axis}.{key}" for axis in "xyz" for key in ("size=0.4", "doublings=2")]
    simulation = build(load_scene(DEMOS / "ac14.toml", [*coarse, "stage.drag.steps=10", "output.pictures=[]"]))
    records = list(simulation.steps())
    poses = dict(zip(simulation.body_names, simulation.state.bodies))
    at = [poses[name].position + poses[name].rotation @ (HINGE - mass.centre) * (1, 0, 1)
          for name, mass in zip(simulation.body_names, simulation.masses)]
    np.testing.assert_allclose(at[0][[0, 2]], at[1][[0, 2]], atol=1e-6)
    angle = np.array([record.joints[0].angle for record in records])
    assert angle[24] == pytest.approx(11.5, abs=1.0)
    assert angle[-1] == pytest.approx(14.3, abs=1.0) and angle.max() < 35.0
    tension = np.array([record.bodies[0].line_tension for record in records])
    assert tension[-10:].mean() == pytest.approx(25.7e3, rel=0.2)
    assert sum(record.rejections for record in records) <= 1


def test_the_fluke_reaches_its_stop_and_stays_there():
    """Turned by a constant moment M without gravity: sqrt(2 J θ / M) to the stop at 35 degrees, where it rests with -M on
    the hinge and the stop, without rebound or chatter."""
    moment = 5e3
    parts = tuple(Body(name=name, geometry=GEOMETRY / f"ac14_{name}.geo", density=7850.0, parameters={"size": 0.3},
                       position=(0.0, 0.0, 5.0), held=held, friction=0.0)
                  for name, held in (("shank", ("x", "y", "z", "rx", "ry", "rz")), ("fluke", ("y", "rx", "rz"))))
    scene = replace(plane(parts[0], 40, 0.01, gravity=(0.0, 0.0, 0.0)), bodies=parts, joints=(
        Joint("crown", "hinge", ("fluke", "shank"), tuple(HINGE), axis=(0.0, 1.0, 0.0), limits=(-35.0, 35.0)),))
    scene = replace(scene, stages=(replace(scene.stages[0], loads=(Load(body="fluke", moment=(0.0, moment, 0.0)),)),))
    simulation = build(scene)
    records = list(simulation.steps())
    angle, resisted = (np.array([one(record.joints[0]) for record in records])
                       for one in (lambda joint: joint.angle, lambda joint: joint.force[4]))
    mass = simulation.masses[1]
    about_hinge = mass.inertia[1, 1] + mass.mass * np.sum((mass.centre - HINGE)[[0, 2]] ** 2)
    reached = np.flatnonzero(angle > 34.999)
    assert 0.01 * (reached[0] + 1) == pytest.approx(np.sqrt(2 * about_hinge * np.radians(35) / moment), abs=0.011)
    assert reached[-1] + 1 - reached[0] == len(reached) == len(records) - reached[0] > 8     # once, and to the end
    np.testing.assert_allclose(angle[reached], 35.0, atol=1e-5)
    np.testing.assert_allclose(resisted[reached[1:]], -moment, rtol=1e-6)
    assert np.abs(simulation.state.bodies[1].spin).max() < 1e-9
    assert max(record.iterations for record in records) <= 6
