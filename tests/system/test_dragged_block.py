"""A block dragged over elastic ground without inertia by a line at its foot, which rocks as it comes to bear on other rows
of contact points: friction is μ N in every step, whichever points bear it."""

import numpy as np

from hybrid.contact import contact_points
from hybrid.scene import Axis, Faces, Grid, Material, Motion, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import NO_OUTPUT, box

FRICTION, WEIGHT = 0.5, 2400.0 * 9.81 * 1.3 * 0.6      # [-], [N]


def friction(cell, way, steps):
    """Friction over μ W (steps,) while the block moves by a `way` [m] in a step."""
    grid = Grid(Axis(-4.0, 5.0, cell), Axis(0.0, 1.0, collapsed=True), Axis(-2.0, 1.5, cell), Faces(z_min="fixed"))
    soil = Soil(Material(law="hencky", young=50e6, poisson=0.3, density=1800.0), top=0.0)
    block = box(1.3, 1.0, 0.6, 20.0, density=2400.0, position=(1.07, 0.5, 0.0), rest_on=0.0, friction=FRICTION, name="block")
    towed = Motion("block", point=(0.65, 0.0, -0.2), component="x", velocity=way)
    scene = Scene(name="dragged", grid=grid, soil=soil, bodies=(block,), time=Time(1.0, inertia=False), output=NO_OUTPUT,
                  stages=(Stage("rest", 1), Stage("tow", steps, motions=(towed,))))
    _, *records = build(scene).steps()
    return np.array([-record.bodies[0].contact_force[0] for record in records]) / (FRICTION * WEIGHT)


def test_friction_does_not_depend_on_which_points_bear_a_block():
    """Here points 10 um under its face come to bear half of it within a step of 15 mm."""
    np.testing.assert_allclose(friction(0.125, 0.015, 9), 1.0, atol=2e-3)


def test_anchored_at_the_end_of_their_path_they_would_have_none(monkeypatch):
    find = contact_points.predicted_contact_points

    def at_the_end(start, end, body, pose, surface, clearance):
        anchor, side = find(start, end, body, pose, surface, clearance)
        stays_off = ~side.any(axis=1)
        anchor[stays_off] = ((end - pose[0]) @ pose[1])[stays_off]
        return anchor, side

    monkeypatch.setattr(contact_points, "predicted_contact_points", at_the_end)
    assert friction(0.125, 0.015, 9).min() < 0.95
