"""A body that turns without inertia has a spin in its records: that of its last increment."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from put_on_soil import put_on_soil

from hybrid.body.attitude import exp_so3
from hybrid.scene import Load, Stage
from hybrid.setup.build import build
from hybrid.step import records
from hybrid.study.scenes import box


def test_the_spin_of_a_footing_that_a_moment_tilts_is_the_rate_of_its_rotation():
    strip = box(1.0, 1.0, 0.3, density=2400.0, position=(0.0, 0.5, 0.0), rest_on=0.0, friction=0.5, held=("x",))
    scene = put_on_soil(strip, size=0.2, x=(-1.6, 1.6), z=(-1.2, 0.6))
    load = Load(moment=((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 1000.0, 0.0)))
    simulation = build(replace(scene, stages=(Stage("tilt", 4, loads=(load,)),)))
    before, turned = simulation.state.bodies[0].rotation, []
    for record in simulation.steps():
        after = simulation.state.bodies[0].rotation
        turned.append((after[0, 2] - before[0, 2], record.bodies[0].spin[1] * record.dt))
        before = after
    angle, spin = np.array(turned).T
    assert spin[-1] > 1e-5 and spin == pytest.approx(angle, rel=1e-3)


def test_it_is_in_the_frame_of_the_body():
    before, spin = exp_so3(np.array([0.4, -0.7, 0.2])), np.array([0.02, 0.05, -0.03])
    step = SimpleNamespace(scheme=SimpleNamespace(inertia=False), body=SimpleNamespace(free=np.ones(6, bool)), dt=2.0,
                           state=SimpleNamespace(rotation=before))
    after = SimpleNamespace(rotation=before @ exp_so3(2.0 * spin), spin=None)
    np.testing.assert_allclose(records._spin(step, after), spin, rtol=1e-12)
