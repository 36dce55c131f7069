"""A pull line that cuts through the soil above an anchor, in a scene: its bearing, its work, and what it cannot do."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hybrid.body.embedded_line import LineSoil, shackle, shape_in_soil
from hybrid.output.history import History, body_names, read_history
from hybrid.output.pictures import Pictures
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Faces, Grid, Layer, Material, Pull, Scene, Soil, Stage, Time
from hybrid.scene.file import load_scene
from hybrid.setup.build import build

CLAY = Material(law="von-mises", young=1e7, poisson=0.49, density=1700.0, strength=1e4, strength_gradient=1e3)
SAND = Material(relative_density=50.0)


def scene(material=CLAY, **soil):
    pull = Pull((0.0, 0.0, 0.0), (0.05, 0.0, 0.0), 1e5, 6.0, diameter=0.04, direction=(6.0, 0.0, 0.9))
    box = Body(GEOMETRY / "box.geo", 7850.0, parameters={"length": 0.6, "width": 0.5, "height": 0.4, "size": 0.2},
               position=(0.0, 0.25, -0.9), held=("rx", "ry", "rz", "y"), friction=0.3, pull=pull)
    return Scene(name="line", grid=Grid(Axis(start=-1.6, end=1.6, size=0.2), Axis(start=0.0, end=0.5, collapsed=True),
                                        Axis(start=-2.4, end=0.2, size=0.2), Faces(z_min="fixed")),
                 soil=Soil(material, top=0.0, **soil), bodies=(box,), time=Time(1.0, inertia=False),
                 stages=(Stage("pull", 3),))


def test_force_at_the_shackle_is_that_of_the_closed_form():
    """Of a box in clay that is pulled at the mudline, 0.9 m above it, by less than it bears."""
    simulation = build(scene())
    soil = simulation.model.bodies[0].line.soil
    assert (soil.bearing, soil.gradient, soil.width) == pytest.approx((11 * 1e4 * 0.1, 11 * 1e3 * 0.1, 0.1))
    line, = simulation.sheet()["modelled"]["pull lines in soil"]
    assert line.startswith("body: bearing of 1.1e+04 N/m and 1100 N/m a metre")
    record = list(simulation.steps())[-1]
    body = simulation.state.bodies[0]
    distance = np.linalg.norm(body.target - body.position)
    tension, angle = shackle(1e5 * (distance - 6.0), 0.0, soil.load(-body.position[2])[0], 0.4)
    assert simulation.evaluation.bodies[0].trial.tension == pytest.approx(tension, rel=1e-9) and 0.3 < angle < 1.57
    balance = record.bodies[0].contact_force + tension * np.array([np.cos(angle), 0.0, np.sin(angle)])
    assert balance[[0, 2]] == pytest.approx([0.0, simulation.model.bodies[0].mass.mass * 9.81], abs=2e-3 * tension)


def test_of_a_body_across_a_plane_of_symmetry_half_of_the_line_is_modelled():
    """In space, the box whole or in half."""
    def bearing(start):
        described = scene()
        grid = replace(described.grid, y=Axis(start, 1.0, 0.25))
        box, = described.bodies
        return build(replace(described, grid=grid, bodies=(replace(box, position=(0.0, 0.0, -0.9)),)))

    whole, half = bearing(-1.0), bearing(0.0)
    assert half.mirrors and not whole.mirrors
    assert half.model.bodies[0].line.soil.bearing == pytest.approx(0.5 * whole.model.bodies[0].line.soil.bearing)


def test_sand_bears_with_the_depth():
    line = build(scene(SAND)).model.bodies[0].line.soil
    angle = np.radians(28 + 0.125 * 50)
    factor = np.exp(np.pi * np.tan(angle)) * np.tan(np.pi / 4 + angle / 2) ** 2
    density = build(scene(SAND)).model.soil.constants
    assert line.bearing == 0.0
    assert line.gradient == pytest.approx(factor * density.mass[0] / density.volume[0] * 9.81 * 0.1)


@pytest.mark.parametrize("soil", [{"layers": (Layer("top", bottom=-1.0),)}, {"ground": ((-1.0, 0.0), (1.0, -0.2))}])
def test_a_line_in_other_soil_is_refused(soil):
    with pytest.raises(SceneError, match="body.0.pull.diameter = 0.04: must be left out with soil"):
        build(scene(**soil))


@pytest.mark.parametrize("change", [{"direction": (6.0, 0.0, -0.9)}, {"direction": None}, {"length": 3.0}])
def test_a_line_whose_far_end_is_in_the_soil_is_refused(change):
    """It would count as one that is pulled along the ground."""
    described = scene()
    body, = described.bodies
    with pytest.raises(SceneError, match="body.pull.direction of body: the far end of the line, .* below the ground"):
        build(replace(described, bodies=(replace(body, pull=replace(body.pull, **change)),)))


DEMO = Path(__file__).parents[2] / "demos" / "embedded.toml"


def integrated(pull, depth, strength=5e3, gradient=1.5e3, width=2.5 * 0.076, friction=0.4):
    """Tension and angle at the shackle by T dθ/ds = -Q, dT/ds = μ Q, dz/ds = -sin θ from the mudline down, with
    Q = 11 (s_u + k z) b, and from 0 at the mudline over the first width."""
    def down(z, state):
        q = 11 * (strength + gradient * z) * width * min(1.0, z / width)
        return [-friction * q / np.sin(state[1]), q / (state[0] * np.sin(state[1]))]

    return solve_ivp(down, (0.0, depth), [pull, 1e-6], "Radau", rtol=1e-10, atol=1e-12).y[:, -1]


def test_an_anchor_in_clay_feels_what_the_differential_equation_says(tmp_path):
    """demos/embedded.toml in five steps: from the third one on the chain is not upright at the shackle. The
    forces of the history: that of the guides, soil and weight are in balance with the tension at its angle."""
    simulation = build(load_scene(DEMO, ["stage.0.steps=5", "body.anchor.pull.velocity=[0.5, 0.0, 0.0]"]))
    simulation.run([History(tmp_path), Pictures(tmp_path)])
    found = read_history(tmp_path)
    for k in (1, 2, 4):
        expected = integrated(found["anchor_mudline_pull_N"][k], 10.0)
        assert found["anchor_tension_N"][k] == pytest.approx(expected[0], rel=1e-4)
        assert found["anchor_shackle_angle_deg"][k] == pytest.approx(np.degrees(expected[1]), rel=1e-4)
    assert found["anchor_mudline_angle_deg"] == pytest.approx(np.zeros(5), abs=1e-3)
    angle = np.radians(found["anchor_shackle_angle_deg"])
    for axis, part, weight in (("x", np.cos(angle), 0.0), ("z", np.sin(angle), -8 * 7850.0 * 9.81)):
        rest = found[f"anchor_reaction_f{axis}_N"] + found[f"anchor_contact_f{axis}_N"] + weight
        assert rest == pytest.approx(-found["anchor_tension_N"] * part, abs=1e-3 * found["anchor_tension_N"].max())
    assert (tmp_path / "line_in_soil.png").stat().st_size > 5000
    assert body_names(found) == ["anchor"]


def test_the_shape_of_a_line_is_its_integral():
    """Rise over distance along the drawn line is tan θ, and it ends at the mudline."""
    soil = LineSoil(0.0, 1e4, 1e3, 0.2, 0.4)
    x, z = shape_in_soil(1e6, 0.3, 4.0, soil).T
    middle = 0.5 * (z[1:] + z[:-1])
    steep = [shackle(1e6, 0.3, soil.load(-height)[0], 0.4)[1] for height in middle]
    assert np.diff(z) / np.diff(x) == pytest.approx(np.tan(steep), rel=1e-3) and (x[0], z[0], z[-1]) == (0.0, -4.0, 0.0)


@pytest.mark.parametrize("direction, length, told", [([10.0, 0.0, 10.0], 14.2, 1), ([100.0, 0.0, 10.0], 100.5, 0)])
def test_a_far_end_that_is_nearer_than_where_the_line_comes_up_is_reported(direction, length, told):
    simulation = build(load_scene(DEMO, [f"body.0.pull.direction={direction}", f"body.0.pull.length={length}",
                                         "stage.0.steps=6"]))
    notes = [note for record in simulation.steps() for note in record.notes if "comes up to the mudline" in note]
    assert len(notes) == told and all("its far end is only 10" in note for note in notes)
