"""A block of clay too soft for its weight collapses: 8 x 8 m, plane strain, E = 1 MPa, ν = 0.3, ρ = 2000 kg/m³,
yield stress 20 kPa (von Mises), gravity of 10 m/s² turned on in 20 quasi-static steps, cells of 1 m.

Published by Coombs, Int. J. Numer. Methods Eng. 124 (2023) 4841-4875: it survives with the ghost penalty only.
"""

import numpy as np
import pytest

from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build

SIZE, YIELD = 8.0, 20e3


def collapse(strength=YIELD, **soil):
    """The run's simulation, and what stopped it (empty if nothing did)."""
    clay = Material(law="drucker-prager", young=1e6, poisson=0.3, density=2000.0, friction_angle=0.0,
                    dilation_angle=0.0, cohesion=strength / np.sqrt(3), cone="plane strain")
    grid = Grid(Axis(start=0.0, end=40.0, size=1.0), Axis(start=0.0, end=1.0, collapsed=True),
                Axis(start=0.0, end=9.0, size=1.0), Faces(x_max="free"))
    simulation = build(Scene(
        name="collapse", grid=grid, soil=Soil(clay, upper=(SIZE, 1.0, SIZE), geostatic=False, **soil),
        gravity=(0.0, 0.0, -10.0), time=Time(step=1.0, inertia=False), stages=(Stage("load", 20, gravity=(0.0, 1.0)),),
        solver=Solver(linear="direct")))
    try:
        for _ in simulation.steps():
            pass
    except StepError as failure:
        return simulation, str(failure)
    return simulation, ""


@pytest.mark.parametrize("soil", [{}, {"fbar": True}, {"basis": "mpm"}], ids=["gimp", "f-bar", "mpm"])
def test_survives_only_with_the_ghost_penalty(soil):
    """Without it the run stops before the full weight is applied, with a reason; accepted steps are kept.

    Round-off decides at which share of the weight: of four strengths that differ by 1e-8, at 0.75 (with F-bar too), with
    the standard basis at 0.95. Hence the earliest stop of three runs is tested.
    """
    runs = (collapse(YIELD * (1 + nudge), **{"fbar": False, "ghost": 0.0, **soil}) for nudge in (0.0, 1e-8, 2e-8))
    bare, reason = next((run for run in runs if run[1]), (None, ""))
    assert reason, "all three runs completed"
    assert 5 <= bare.state.step < 20
    assert any(text in reason for text in ("inside out", "residual", "would leave the grid"))
    tied, reason = collapse(**soil)
    assert not reason and tied.state.step == 20
    points, volume = tied.state.points, tied.model.soil.constants.volume
    assert points.position[:, 2].max() < 0.4 * SIZE and points.position[:, 0].max() > 3 * SIZE
    assert np.linalg.det(points.deformation) @ volume == pytest.approx(volume.sum(), rel=0.1)


@pytest.mark.parametrize("factor, limit", [(None, 1e-3), (1.0, 3e-3)])
def test_the_penalty_hardly_changes_a_block_that_stands(factor, limit):
    """Strong enough to stand at 16 % strain: mean displacement and energy with and without the penalty."""
    bare, tied = (collapse(ghost=ghost, fbar=False, strength=1e6)[0] for ghost in (0.0, factor))
    moved = [np.abs(s.state.points.position - s.initial_position).mean() for s in (bare, tied)]
    stored = [s.model.soil.stored_energy(s.state.points) for s in (bare, tied)]
    assert bare.state.step == tied.state.step == 20
    assert moved[1] == pytest.approx(moved[0], rel=limit) and stored[1] == pytest.approx(stored[0], rel=limit)


@pytest.mark.parametrize("ghost, low, high", [(None, 6.2, 6.6), (0.3, 4.6, 5.1)])
def test_clay_that_runs_out_is_not_braked(ghost, low, high):
    """3 x 2 m of clay let go on a rough base, 10 cells high; the front runs 6.41 m with 40 cells."""
    clay = Material(law="von-mises", young=1e6, poisson=0.49, density=1700.0, strength=2e3)
    grid = Grid(Axis(start=0.0, end=10.0, size=0.2), Axis(start=0.0, end=1.0, collapsed=True),
                Axis(start=0.0, end=2.4, size=0.2), Faces(z_min="fixed"))
    simulation = build(Scene(name="let go", grid=grid, soil=Soil(clay, upper=(3.0, 1.0, 2.0), geostatic=False, ghost=ghost),
                             time=Time(step=0.01), stages=(Stage("go", 250),)))
    for _ in simulation.steps():
        pass
    assert low < np.quantile(simulation.state.points.position[:, 0], 0.99) - 3.0 < high
