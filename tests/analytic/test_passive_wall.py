"""Passive pressure of sand on an upright smooth wall in plane strain that stands in the soil and is pushed, against Rankine.

A wall down to a smooth base compresses the soil evenly, so cells do not matter. A wall that ends in the soil drags on the
nodes below its foot, so that the wedge is about a cell deeper than the wall: its force is too large by 2 h/d, first order
in the cells, and is extrapolated.
"""

import pytest

from hybrid.laws.cone import plane_strain_strength
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.blade import draft

WEIGHT, COHESION, STEPS = 16.52e3, 300.0, 20      # [N/m³], [Pa] of sand of 38 %
AHEAD = 6.0                                       # depths of soil in front of the wall


def force_over_rankine(cells, travel, cone="plane strain", depth=0.4, base=False):
    """Force [-] on a wall with `cells` in its depth, pushed by a share `travel` of that, over Rankine's with the angle of
    the law in plane strain; and that angle [degrees]. base: a smooth one at the foot, else the soil goes on below."""
    h = depth / cells
    wall = Body(GEOMETRY / "box.geo", 7850.0, name="wall", position=(0.0, 0.5, 0.0),
                parameters={"length": depth, "width": 1.0, "height": (3 if base else 2) * depth, "size": 0.5 * depth},
                driven=("x",), velocity=(travel * depth / STEPS, 0.0, 0.0), held=("y", "z", "rx", "ry", "rz"))
    grid = Grid(Axis(0.0, (AHEAD + 0.5) * depth, h), Axis(0.0, 1.0, collapsed=True),
                Axis((-1 if base else -3) * depth, depth, h), Faces(z_min="roller" if base else "fixed"))
    simulation = build(Scene(name="wall", grid=grid, soil=Soil(Material(relative_density=38.0, cone=cone), top=0.0),
                             bodies=(wall,), time=Time(1.0), stages=(Stage("push", STEPS),)))
    *_, record = simulation.steps()
    angle = plane_strain_strength(simulation.model.soil.law.parameters[0])[0]
    return -record.bodies[0].contact_force[0] / (draft((WEIGHT, COHESION, angle), 0.0, depth, 1e9) / 1e9), angle


@pytest.mark.parametrize("depth", [0.4, pytest.param(3.0, marks=pytest.mark.slow)])
def test_wall_on_a_smooth_base_feels_rankines_pressure(depth):
    ratio, _ = force_over_rankine(4, 0.3, depth=depth, base=True)
    risen = AHEAD / (AHEAD - 0.3)
    assert ratio / risen**2 == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
def test_wall_that_ends_in_the_soil_converges_to_rankines_pressure():
    """1.58, 1.41, 1.34, 1.21, 1.16 with 4, 6, 8, 12, 16 cells."""
    (coarse, _), (fine, _) = force_over_rankine(6, 0.05), force_over_rankine(12, 0.05)
    assert 1.3 < coarse < 1.5 and 1.15 < fine < 1.27
    assert 2 * fine - coarse == pytest.approx(1.0, abs=0.05)


def test_cone_matched_in_compression_is_a_far_stronger_sand():
    ratio, angle = force_over_rankine(4, 0.3, "compression", base=True)
    assert angle == pytest.approx(50.6, abs=0.1)
    assert ratio / (AHEAD / (AHEAD - 0.3)) ** 2 == pytest.approx(1.0, abs=0.08)
