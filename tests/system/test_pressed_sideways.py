"""A plate pressed against the side of elastic soil, and the same pressed on its top: one problem, turned by 90 degrees. A
ram that pushes a block, driven in two ways."""

from dataclasses import replace

import pytest
from flying_bodies import scene as in_space

from hybrid.scene import Axis, Faces, Grid, Load, Motion, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import box, collapsed, elastic, scene

DEPTH, WIDTH = Axis(-1.0, 0.6, 0.2), Axis(-1.0, 1.4, 0.2)


def pressed(axis, load=None, **driven):
    """Displacement [m] and force [N] along `axis` of a plate on four cells of soil, whose side is one metre of 2.4."""
    upright = axis == "z"
    shape = (0.8, 1.0, 0.4) if upright else (0.4, 1.0, 0.8)
    place = (0.1, 0.5, 0.2) if upright else (0.2, 0.5, 0.1)
    plate = box(*shape, friction=0.4, position=place, held=("x" if upright else "z", "ry"), **driven)
    faces = Faces(z_min="fixed", x_max="roller") if upright else Faces(x_min="fixed", x_max="free", z_max="roller")
    grid = Grid(WIDTH, collapsed(), DEPTH, faces) if upright else Grid(DEPTH, collapsed(), WIDTH, faces)
    upper = (1.4, 1.0, 0.0) if upright else (0.0, 1.0, 1.4)
    stage = Stage("press", 1, loads=() if load is None else (Load(force=load),))
    record, = build(scene("plate", grid, elastic(2e6, 0.3), [plate], 1.0, [stage],
                          {"lower": (-1.0, 0.0, -1.0), "upper": upper}, {"inertia": False})).steps()
    number = 2 if upright else 0
    return record.bodies[0].position[number] - 0.2, record.bodies[0].contact_force[number]


@pytest.mark.parametrize("given", ["load", "driven"])
def test_a_side_answers_as_the_top_does(given):
    """By rounded edges it answered 20 % more, and 11 % less."""
    if given == "load":
        side, top = pressed("x", (-3000.0, 0.0, 0.0)), pressed("z", (0.0, 0.0, -3000.0))
    else:
        side = pressed("x", driven=("x",), velocity=(-0.001, 0.0, 0.0))
        top = pressed("z", driven=("z",), velocity=(0.0, 0.0, -0.001))
    assert side == pytest.approx(top, rel=1e-5) and top[1] > 2900.0


def test_a_ram_is_no_free_body_however_it_is_driven():
    """By a stage alone its own weight, instead of that of the block, gave the stiffness."""
    def pair(**how):
        block = box(0.5, 0.5, 0.5, name="block", position=(0.0, 0.0, 2.0), friction=0.5)
        ram = box(0.2, 0.2, 0.2, name="ram", position=(-0.36, 0.0, 2.0), held=("y", "z", "rx", "ry", "rz"), **how)
        stage = Stage("push", 1, motions=() if how else (Motion(body="ram", component="x", velocity=0.1),))
        return build(replace(in_space([block, ram], 1, 0.01), stages=(stage,))).model.pairs[0]

    assert pair().stiffness == pytest.approx(pair(driven=("x",), velocity=(0.1, 0.0, 0.0)).stiffness, rel=1e-12)
