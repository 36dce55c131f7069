"""Sand that falls and opens comes to rest at the volume that it had."""

import pytest

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Grid, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import NO_OUTPUT

def fallen(step=0.005, time=1.6, **material):
    """(Height of the middle [m] of a layer 0.6 m high that has fallen by 0.3 m on a held plate, and the last record)."""
    grid = Grid(Axis(-0.1, 0.1, 0.1), Axis(0.0, 0.1, collapsed=True), Axis(-0.2, 1.2, 0.1))
    sand = Material(**{"law": "mohr-coulomb", "young": 5e6, "poisson": 0.3, "density": 1600.0, "friction_angle": 33.0,
                       "dilation_angle": 0.0, "cohesion": 0.0} | material)
    soil = Soil(sand, top=0.9, lower=(-0.1, 0.0, 0.3), geostatic=False)
    plate = Body(GEOMETRY / "box.geo", 2400.0, name="plate", position=(0.0, 0.05, -0.05),
                 held=("x", "y", "z", "rx", "ry", "rz"),
                 parameters={"length": 0.6, "width": 0.1, "height": 0.1, "size": 0.3})
    simulation = build(Scene(name="fallen", grid=grid, soil=soil, bodies=(plate,), time=Time(step),
                             stages=(Stage("fall", round(time / step)),), output=NO_OUTPUT))
    *_, record = simulation.steps()
    return simulation.state.points.position[:, 2].mean(), record


@pytest.mark.parametrize("more", [
    {}, *(pytest.param(more, marks=pytest.mark.slow) for more in ({"cohesion": 2e3}, {"dilation_angle": 5.0})),
    {"law": "drucker-prager"}, {"law": "willam-warnke"}])
def test_a_layer_that_has_fallen_is_as_high_as_before(more):
    middle, record = fallen(**more)
    assert middle == pytest.approx(0.3, abs=0.005) and 0.0 <= record.energies["plastic"] < 0.5 * 56.5    # J, of the fall


def test_without_a_memory_it_stays_swollen(monkeypatch):
    monkeypatch.setattr("hybrid.soil.closing._any", lambda opened: None)
    assert fallen()[0] > 0.44


def test_without_sharing_half_of_its_points_stay_without_stress(monkeypatch):
    monkeypatch.setattr("hybrid.soil.closing.shared", lambda points, *given: points)
    assert fallen()[0] > 0.309


@pytest.mark.slow
def test_the_height_does_not_depend_on_the_step():
    assert fallen(0.001)[0] == pytest.approx(fallen(0.005)[0], abs=0.01)
