"""Residuals that are round-off of the soil's stiffness: under hardly any load, and in soil that has come to rest."""

from dataclasses import replace

import pytest

from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Faces, Grid, Load, Material, Soil, Solver, Stage
from hybrid.setup.build import build
from hybrid.step import newton, soil_terms
from hybrid.study.scenes import box, collapsed, loaded_by_weight, scene


def hardly_loaded(share, tolerance):
    """(Records, mean vertical stress over that of the weight) of a block under a share of gravity."""
    side, height = Axis(0.0, 1.0, 0.5), 2.0
    soil = Soil(Material(law="hencky", young=1e7, poisson=0.3, density=1000.0), geostatic=False, top=height)
    simulation = build(loaded_by_weight("block", Grid(side, side, Axis(0.0, 2.5, 0.5), Faces()), soil, 2, -10.0 * share,
                                        solver=Solver(linear="direct", tolerance=tolerance, line_search=False)))
    records = list(simulation.steps())
    return records, simulation.state.points.stress[:, 2, 2].mean() / (-share * 1e4 * height / 2)


def test_a_residual_within_round_off_is_accepted_where_it_is_small_beside_the_forces():
    """A weight of 2e-5 N on a stiffness that rounds to 5e-10 N; and of 2e-9 N, of which that is a quarter."""
    records, stress = hardly_loaded(1e-9, 1e-9)
    assert sum(r.judged for r in records) == 2 and sum(r.rejections for r in records) == 0
    assert all(1e-8 < r.residual <= newton.AT_ROUND_OFF for r in records) and stress == pytest.approx(1.0, abs=1e-3)
    assert [r.judged for r in hardly_loaded(1.0, 1e-6)[0]] == [0, 0]
    with pytest.raises(StepError, match="round-off of its stiffness"):
        hardly_loaded(1e-13, 1e-9)


def test_weightless_soil_that_comes_to_rest_goes_on(monkeypatch):
    """A column that a load lets go: waves die out until the forces themselves are round-off of its stiffness. The broken
    variant, which judges them by the forces of the moment, stops."""
    def let_go():
        x, z = Axis(0.0, 0.4, 0.1), Axis(0.0, 1.2, 0.1)
        soil = {"top": 0.6}
        lid = box(0.4, 1.0, 0.5, density=5000.0, position=(0.2, 0.5, 0.0), rest_on=0.6, held=("x", "ry"))
        stages = Stage("on", 40, loads=(Load(force=(0.0, 0.0, -5000.0)),)), Stage("off", 60)
        material = {"law": "hencky", "young": 1e7, "poisson": 0.0}
        column = scene("column", Grid(x, collapsed(), z, Faces()), material, [lid], 0.0025, stages, soil=soil)
        light = replace(column.soil, material=replace(column.soil.material, density=20.0))
        return list(build(replace(column, soil=light)).steps())

    assert len(let_go()) == 100
    monkeypatch.setattr(soil_terms, "STILL", 0.0)
    with pytest.raises(StepError, match="round-off of its stiffness"):
        let_go()
