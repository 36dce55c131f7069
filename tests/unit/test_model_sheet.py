"""The model sheet has the sizes of a run, and lists what a scene does not model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array

from hybrid.linalg import solver_choice
from hybrid.scene import Axis, Material, Solver, Time
from hybrid.scene.file import load_scene
from hybrid.setup.build import build
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import plane, soil_scene, sphere

DEMOS = Path(__file__).parents[2] / "demos"


def test_held_soil_leaves_six_unknowns():
    sheet = build(load_scene(DEMOS / "rolling_sphere.toml")).sheet()
    assert sheet["modelled"]["soil unknowns"] == 0 and sheet["modelled"]["body unknowns"] == 6
    assert any("the soil is held" in line for line in sheet["not modelled"])
    assert sheet["modelled"]["time integration"] == (
        "generalised-alpha, spectral radius 0, of bodies in flight 0.5")
    assert "inactive nodes" not in sheet["modelled"]


@pytest.mark.parametrize("friction", [0.45, 0.0])
def test_sizes_are_those_of_the_first_step(friction):
    simulation = build(load_scene(DEMOS / "anchor.toml", [f"body.0.friction={friction}"]))
    sheet = simulation.sheet()
    step = begin(simulation.model, simulation.state, 0.04, False, Workspace(simulation.model))
    assert sheet["modelled"]["soil unknowns"] == step.pattern.size
    assert sheet["modelled"]["entries of the soil block"] == len(step.pattern.indices)
    assert sheet["modelled"]["material points"] == len(simulation.state.points)
    nodes, active = step.pattern.free.size // 3, step.pattern.free.reshape(-1, 3).any(axis=1).sum()
    assert sheet["modelled"]["inactive nodes"] == f"{nodes - active} of {nodes} (no soil, or fixed)"
    assert sheet["modelled"]["body unknowns"] == 3
    assert any("friction" in line for line in sheet["not modelled"]) == (friction == 0.0)


@pytest.mark.parametrize("options, contact", [
    ({}, "contact at 2400 faces of each domain"), ({"contact": "corners", "penalty": 50.0},
                                                   "contact at 8 corners of each domain")])
def test_contact_of_a_body(options, contact):
    ball = sphere(0.25, 0.1, name="ball", position=(0.0, 0.0, 0.5), friction=0.3, **options)
    simulation = build(plane(ball, 1, 0.01))
    body, sheet = simulation.model.bodies[0], simulation.sheet()
    (line,) = sheet["modelled"]["bodies"]
    assert line.startswith(f"ball: {len(body.surface.triangles)} contact triangles, {body.mass.mass:.6g} kg, "
                           f"6 free components, {contact}")
    assert not [text for text in sheet["not modelled"] if "ball" in text]


def test_driven_components_are_modelled_and_held_ones_are_not():
    """A component driven at rate 0 is driven all the same."""
    ball = sphere(0.25, 0.1, name="ball", position=(0.0, 0.0, 0.5), velocity=(1.0, 0.0, 0.0), driven=("x", "z"),
                  held=("rx", "rz"))
    sheet = build(plane(ball, 1, 0.01)).sheet()
    assert ", 2 free components, driven x z, contact at " in sheet["modelled"]["bodies"][0]
    assert "motion of ball in rx, rz: held" in sheet["not modelled"]


def test_demo_anchor_starts_in_equilibrium():
    """Geostatic stress on the demo's graded grid: the soil's residual is round-off."""
    simulation = build(load_scene(DEMOS / "anchor.toml"))
    step = begin(simulation.model, simulation.state, 0.04, False, Workspace(simulation.model))
    weight = np.linalg.norm(step.soil.weight)
    assert np.linalg.norm(step.evaluate(step.predictor()).soil) < 1e-12 * weight


@pytest.mark.parametrize("law, symmetric", [
    ({"law": "hencky"}, True),
    ({"law": "von-mises", "strength": 1e3}, True),
    ({"law": "von-mises", "strength": 1e3, "hardening": 1e5}, True),
    ({"law": "drucker-prager", "friction_angle": 30.0, "dilation_angle": 30.0, "cohesion": 1e3}, True),
    ({"law": "drucker-prager", "friction_angle": 30.0, "dilation_angle": 5.0, "cohesion": 1e3}, False),
    ({"law": "drucker-prager", "friction_angle": 30.0, "dilation_angle": 30.0, "cohesion": 1e3, "hardening": 1e5},
     False),
    ({"law": "willam-warnke", "friction_angle": 30.0, "dilation_angle": 30.0, "cohesion": 1e3}, False),
])
@pytest.mark.parametrize("fbar", [False, True])
def test_the_soil_tangent_is_symmetric_where_the_sheet_says_so(law, symmetric, fbar):
    described = soil_scene(gravity=(0.0, 0.0, -9.81), fbar=fbar)
    material = Material(young=1e6, poisson=0.3, density=1800.0, **law)
    simulation = build(replace(described, soil=replace(described.soil, material=material)))
    step = begin(simulation.model, simulation.state, 0.01, False, Workspace(simulation.model))
    shaken = 0.004 * np.random.default_rng(0).normal(size=step.predictor().displacement.shape)
    step.assemble(step.evaluate(replace(step.predictor(), displacement=shaken)))
    pattern = step.pattern
    tangent = csr_array((step.system.values, pattern.indices, pattern.indptr)).toarray()
    assert (np.abs(tangent - tangent.T).max() < 1e-12 * np.abs(tangent).max()) == symmetric
    assert simulation.sheet()["modelled"]["soil tangent"] == ("symmetric" if symmetric else "unsymmetric")


def test_what_sets_the_increments_and_what_stands_for_the_far_soil():
    described = soil_scene(y=Axis(0.0, 0.8, collapsed=True), time=Time(0.01, accuracy=1e-3))
    sheet = build(described).sheet()
    assert sheet["modelled"]["increments"] == (
        "as long as time.accuracy = 0.001 allows, an error of positions of 0.0002 m a step")
    assert "soil outside the grid: its faces are roller at x_min x_max, fixed at z_min, free at z_max" in sheet[
        "not modelled"]
    plain = build(replace(described, time=Time(0.01))).sheet()
    assert plain["modelled"]["increments"] == "one a step, halved where Newton's method fails"


def test_soil_that_was_dragged_along_does_not_hide_the_grid():
    """Points whose place at the start lies beyond the grid of now: all nodes are seen, as in the grid of the start."""
    simulation = build(soil_scene(x=(0.0, 1.6)))
    soil, before = simulation.model.soil, simulation.sheet()["modelled"]["soil unknowns"]
    away = soil.constants.position - (1.0, 0.0, 0.0)
    dragged = replace(soil, constants=replace(soil.constants, position=away))
    simulation.model = simulation.model.with_soil(dragged)
    assert simulation.sheet()["modelled"]["soil unknowns"] < before     # of the nodes that are seen from there
    both = np.where(np.arange(len(away))[:, None] % 2 == 0, away, soil.constants.position)
    simulation.model = simulation.model.with_soil(
        replace(soil, constants=replace(soil.constants, position=both)))
    assert simulation.sheet()["modelled"]["soil unknowns"] == before


def test_the_linear_solver_is_named_and_a_direct_factor_that_does_not_fit(monkeypatch):
    def row(**solver):
        return build(soil_scene(solver=Solver(**solver))).sheet()["modelled"]["linear solver"]

    assert row(linear="direct").startswith("a direct factor of about")
    assert row().startswith("GMRES, or a direct factor of about")
    monkeypatch.setattr(solver_choice, "available_memory", lambda: 2**10)
    assert row().startswith("GMRES alone: a direct factor does not fit: it needs about")
