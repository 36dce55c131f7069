"""Soil with initial stress: it stays at rest in equilibrium; otherwise the imbalance is measured and reported, and the
soil settles.

At a vertical cut of height H the horizontal stress K0 ρ g z is not balanced. In a block of length L the residual force
is the thrust K0 ρ g H²/2, less the part on the fixed base: half of the lowest of n cells with 2 points each,

    share = K0 H/2L (1 - 1/n + 3/8n²)         of the weight
"""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors.initial_equilibrium import InitialImbalance, initial_imbalance
from hybrid.output.sheet_text import format_sheet
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Faces, Grid, Layer, Material, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.simulation import Simulation
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace

STIFF = Material(law="hencky", young=5e6, poisson=0.3, density=1700.0)
SAND = Material(relative_density=38.0)
SOFT = Layer("soft", top=-0.6, material={"young": 2e6, "density": 1500.0, "poisson": 0.4})
SIDE = Axis(start=0.0, end=3.0, size=0.25, fine=(1.0, 2.0), growth=1.4)
UP = Axis(start=-2.0, end=0.5, size=0.25, fine=(-0.75, 0.5), growth=1.3)
FLAT = Axis(start=0.0, end=1.0, collapsed=True)
VARIANTS = {
    "sand": {"material": SAND}, "layers": {"layers": (SOFT,)}, "F-bar": {"fbar": True},
    "F-bar, sand": {"material": SAND, "fbar": True}, "ghost penalty": {"ghost": 1 / 30}, "mpm": {"basis": "mpm"},
    "mpm, F-bar, ghost": {"basis": "mpm", "fbar": True, "ghost": 1 / 30}, "unchanging": {"domain": "none"},
    "affine": {"transfer": "affine"}, "3 points": {"points_per_axis": 3},
}


def level(x=SIDE, y=FLAT, material=STIFF, steps=5, time=(), **soil):
    """Level soil to z = 0 on a graded grid, in plane strain unless `y` is given."""
    return Scene(name="level", grid=Grid(x, y, UP), soil=Soil(material, top=0.0, **soil),
                 time=Time(step=0.04, **dict(time)), stages=(Stage("rest", steps),), solver=Solver(linear="direct"))


def stays(simulation):
    """Largest velocity [m/s] of any point in a run that must need no step halved."""
    before, fastest = simulation.state.points.stress, 0.0
    warned = simulation.sheet().get("warnings", [])     # of methods that some variants try on purpose
    for record in simulation.steps():
        assert record.rejections == 0 and not set(record.notes) - set(warned)
        fastest = max(fastest, np.abs(simulation.state.points.velocity).max())
    assert np.abs(simulation.state.points.stress - before).max() < 1e-11 * np.abs(before).max()
    return fastest


@pytest.mark.parametrize("variant", VARIANTS)
def test_level_soil_stays_still(variant):
    simulation = build(level(**VARIANTS[variant]))
    assert simulation.imbalance.share < 1e-12
    assert stays(simulation) < 1e-10


@pytest.mark.parametrize("axes", [{"x": FLAT}, {"x": FLAT, "fbar": True, "ghost": 1 / 30},
                                  {"y": Axis(start=0.0, end=1.0, size=0.5), "fbar": True, "ghost": 1 / 30}])
def test_columns_and_blocks_stay_still(axes):
    assert stays(build(level(**axes))) < 1e-10


def test_weight_that_is_not_balanced_moves_the_soil():
    """The same soil with 0.1 % of its stress missing: measured as that share, and seen to move."""
    simulation = build(level())
    points = simulation.state.points
    points.b_elastic[:] = np.eye(3) + 0.999 * (points.b_elastic - np.eye(3))
    points.stress *= 0.999
    assert now(simulation).share == pytest.approx(1e-3, rel=0.15)      # held nodes of the base carry some of it
    for record in simulation.steps():
        pass
    assert np.abs(simulation.state.points.velocity).max() > 1e-6


# ------------------------------------------------------------------ a vertical cut


def cut(cells=4, steps=1, material=STIFF, length=2, damped=False, stages=(), time=(), **soil):
    """Soil of 1 m height and `length` [m] on a rough base, held at its left, cut free at its right."""
    size = 1.0 / cells
    grid = Grid(Axis(start=0.0, end=length + 0.5, size=size), FLAT, Axis(start=-1.0, end=0.5, size=size),
                Faces(z_min="fixed"))
    pair = {"beta": 0.5625, "gamma": 1.0} if damped else {}
    return Scene(name="cut", grid=grid, soil=Soil(material, top=0.0, upper=(length, 1.0, 0.0), **soil),
                 time=Time(step=0.04, **dict(time)), stages=(Stage("settle", steps, **pair), *stages),
                 solver=Solver(linear="direct", tolerance=1e-9))


def now(simulation):
    """Imbalance of the present state."""
    step = begin(simulation.model, simulation.state, 0.04, False, Workspace(simulation.model))
    return initial_imbalance(step, step.evaluate(step.at_rest()))


@pytest.mark.parametrize("cells", [4, 8])
@pytest.mark.parametrize("basis", ["gimp", "mpm"])
def test_the_thrust_behind_a_cut_is_measured(cells, basis):
    simulation = build(cut(cells, basis=basis))
    K0 = 0.3 / 0.7
    assert simulation.imbalance.share == pytest.approx(K0 / 4 * (1 - 1 / cells + 3 / (8 * cells**2)), rel=1e-10)
    place = simulation.imbalance.place
    assert place[0] == 2.0 and place[2] == pytest.approx(-1.0 + 1.0 / cells)       # at the base of the face


def test_model_sheet_and_first_record_report_the_imbalance():
    """With the place and a remedy that depends on what the first stage does; once in a run, never where all is well."""
    simulation = build(cut(steps=3))
    sheet = format_sheet(simulation.sheet())
    assert re.search(r"initial imbalance +8\.3 % of the weight, largest at node \(2, 0\.5, -0\.75\) m", sheet)
    notes = [(record.step, note) for record in simulation.steps() for note in record.notes]
    assert len(notes) == 1 and notes[0][0] == 1
    assert notes[0][1].startswith(
        "initial imbalance: 8.3 % of the weight, largest at node (2, 0.5, -0.75) m, is not balanced at the start, "
        "limit")
    assert "stage.gamma = 1" in notes[0][1]
    assert "set soil.geostatic = false and turn gravity on by stage.gravity = [0.0, 1.0]" in notes[0][1]
    halfway, resumed = build(cut(steps=3)), build(cut(steps=3))
    next(halfway.steps())
    resumed.state = halfway.state
    assert all(record.notes == () for record in resumed.steps())
    for scene, words in ((cut(damped=True), "'settle' damps"), (cut(time={"inertia": False}), "has no inertia"),
                         (cut(geostatic=False), "no stress yet and its weight acts at once")):
        (record,) = build(scene).steps()
        assert words in record.notes[0]
        assert "soil.geostatic = false" not in record.notes[0]      # not where it is so already
    assert build(level()).sheet()["modelled"]["initial imbalance"].startswith("balanced, to ")
    quiet = build(replace(cut(geostatic=False), stages=(Stage("load", 1, gravity=(0.0, 1.0)),)))
    assert quiet.imbalance.share == 0.0 and "initial imbalance" in quiet.sheet()["modelled"]
    assert next(quiet.steps()).notes == ()
    weightless = build(replace(cut(), gravity=(0.0, 0.0, 0.0)))
    assert weightless.imbalance is None and "initial imbalance" not in weightless.sheet()["modelled"]


COHESIVE = Material(law="drucker-prager", young=5e6, poisson=0.3, density=1700.0, friction_angle=30.0,
                    dilation_angle=0.0, cohesion=10e3)


def test_plastic_flow_after_a_cut_depends_on_steps_that_do_not_resolve_its_swing():
    """Cohesion of 2.5 kPa: half as long a step makes twice the plastic work. The run warns, with the period
    4 H sqrt(ρ/M) of the swing, until the step resolves it; not where nothing yields, nor without inertia."""
    weak, period = replace(COHESIVE, cohesion=2.5e3), 4 * np.sqrt(1700.0 / (5e6 * 0.7 / (1.3 * 0.4)))
    described = cut(steps=10, material=weak)
    coarse = list(build(described).steps())
    halved = replace(described, time=Time(step=0.02), stages=(Stage("settle", 20),))
    assert list(build(halved).steps())[-1].energies["plastic"] > 1.3 * coarse[-1].energies["plastic"] > 0
    (note,) = (text for text in coarse[0].notes if "of the period" in text)
    assert f"is {0.04 / period:.2g} of the period {period:.3g} s" in note
    assert "limit 0.1: " in note and f"stage.step = {0.1 * period:.2g} or less" in note
    for scene in (replace(described, time=Time(step=0.09 * period)), replace(described, time=Time(0.04, inertia=False)),
                  cut(material=STIFF)):
        assert "of the period" not in " ".join(next(build(scene).steps()).notes)


@pytest.mark.parametrize("material", [STIFF, COHESIVE], ids=["elastic", "cohesive"])
@pytest.mark.parametrize("way", ["damped", "quasi-static", "undamped"])
def test_a_cut_that_can_stand_settles(material, way):
    """40 damped steps, or steps without inertia, take up all but 1e-7 of the imbalance and velocities die out; without
    damping a tenth of it goes on swinging. The cohesive face of 1 m stands: it could be 4c tan(60°)/ρg = 4 m high. No
    ghost penalty: the sliver that bulges into the next cell creeps against it, and 3e-3 of the imbalance is left."""
    time = {"damped": {}, "quasi-static": {"inertia": False}, "undamped": {"scheme": "newmark"}}[way]
    simulation = build(cut(steps=40, material=material, damped=way == "damped", time=time, ghost=0.0))
    started, fastest = simulation.imbalance.share, []
    for record in simulation.steps():
        assert record.rejections == 0
        fastest.append(np.abs(simulation.state.points.velocity).max())
    left, moving = now(simulation).share / started, fastest[-1] / max(fastest)
    if way == "undamped":
        assert left > 0.05 and moving > 0.02
    else:
        assert left < 1e-6 and moving < 1e-3


@pytest.mark.parametrize("friction, dilation, cone", [
    (38.0, 10.0, None), (40.5, 10.5, None), (45.0, 0.0, None), (45.0, 45.0, None), (42.0, 5.0, "extension")])
def test_dense_sand_is_at_rest_under_the_cone_that_is_chosen_for_it(friction, dilation, cone):
    """A cone matched in plane strain, or in extension, carries less at rest than 1 - sin φ asks for: K0 is then what it
    carries with a margin."""
    sand = Material(law="drucker-prager", young=5e7, poisson=0.25, density=1900.0, friction_angle=friction,
                    dilation_angle=dilation, cohesion=0.0, cone=cone)
    simulation = build(level(material=sand))
    stress = simulation.state.points.stress
    k0 = stress[:, 0, 0] / stress[:, 2, 2]
    assert np.ptp(k0) < 1e-9 and 1.0 - np.sin(np.radians(friction)) < k0[0] < 1.5 * (1.0 - np.sin(np.radians(friction)))
    record = next(iter(simulation.steps()))
    assert simulation.state.points.plastic_strain.max() < 1e-9 and record.rejections == 0


@pytest.mark.parametrize("given, words, beyond", [(0.2, "at least", -0.02), (4.9, "at most", 0.02), (1e25, "at most", 0.02)])
def test_a_k0_that_the_soil_cannot_carry_is_refused_with_one_that_it_can(given, words, beyond):
    with pytest.raises(SceneError, match=f"more than the law can carry; set soil.k0 to {words} (.*), or raise") as refusal:
        build(level(material=SAND, k0=given))
    enough = float(re.search("k0 to at [a-z]+ ([0-9.]+)", str(refusal.value))[1])
    build(level(material=SAND, k0=enough))
    with pytest.raises(SceneError, match="more than the law can carry"):
        build(level(material=SAND, k0=enough + beyond))


@pytest.mark.parametrize("k0, named", [(0.4, True), (0.2, False)])
def test_the_law_that_carries_a_k0_which_the_cone_does_not_is_named(k0, named):
    """K_a = 1/3: sand of 30° is at rest at 0.4 under Mohr-Coulomb's law, and not under a cone matched in plane strain."""
    cone = Material(law="drucker-prager", young=5e7, poisson=0.25, density=1900.0, friction_angle=30.0, dilation_angle=0.0,
                    cohesion=0.0, cone="plane strain")
    with pytest.raises(SceneError, match="set soil.k0 to at least 0.46") as refusal:
        build(level(material=cone, k0=k0))
    assert ('law = "mohr-coulomb"' in str(refusal.value)) == named
    if named:
        build(level(material=replace(cone, law="mohr-coulomb", cone=None), k0=k0))


@pytest.mark.parametrize("share, stressed, period, count", [
    (1.0, True, 0.1, 1), (0.05, True, 0.1, 0), (1.0, False, 0.1, 0), (1.0, True, None, 0)])
def test_soil_far_from_equilibrium_is_told_before_a_run_without_inertia(share, stressed, period, count):
    """Soil that yields and begins with stress: sand that lies on two held bodies had no first step."""
    texts = list(InitialImbalance(share, (0.0, 0.5, 0.0), stressed, period).hazards())
    assert len(texts) == count and all("limit 10%" in text and "stage.gravity = [0.0, 1.0]" in text for text in texts)


@pytest.mark.parametrize("inertia", [False, True])
def test_sand_on_a_held_body_presses_on_it_from_the_start(inertia, monkeypatch):
    """Nothing but the body is below it; without its contact all of the weight is out of balance, which is told."""
    table = Body(GEOMETRY / "box.geo", 2000.0, name="table", position=(0.5, 0.5, -0.25),
                 held=("x", "y", "z", "rx", "ry", "rz"),
                 parameters={"length": 3.0, "width": 3.0, "height": 0.5, "size": 5.0})
    axis = Axis(0.0, 1.0, 0.25)
    scene = Scene(name="laid", grid=Grid(axis, axis, Axis(-0.5, 1.0, 0.25)),
                  soil=Soil(SAND, lower=(0.0, 0.0, 0.0), upper=(1.0, 1.0, 0.5)), bodies=(table,),
                  time=Time(0.1, inertia=inertia), stages=(Stage("lie", 1),))
    simulation = build(scene)
    assert simulation.imbalance.share < 1e-9 and all("between rollers" in text for text in simulation.warned)
    record, = simulation.steps()
    weight = 9.81 * simulation.model.soil.constants.mass.sum()
    assert record.iterations == 0 and record.bodies[0].contact_force[2] == pytest.approx(-weight)
    monkeypatch.setattr("hybrid.setup.build.flush_contacts", lambda *given: given[-1])
    found = [text for text in build(scene).warned if "initial imbalance: 100 %" in text]
    assert len(found) == (not inertia)


def test_sand_behind_a_held_wall_presses_on_it_as_at_rest():
    """K0 γ H²/2 of a wall whose face is where the soil ends."""
    wall = Body(GEOMETRY / "box.geo", 2400.0, name="wall", position=(0.25, 0.5, -0.8),
                held=("x", "y", "z", "rx", "ry", "rz"),
                parameters={"length": 0.5, "width": 1.0, "height": 2.8, "size": 20.0})
    grid = Grid(Axis(0.0, 2.5, 0.25), Axis(0.0, 1.0, collapsed=True), Axis(-2.0, 0.5, 0.25))
    simulation = build(Scene(name="wall", grid=grid, soil=Soil(SAND, lower=(0.5, 0.0, -2.0), top=0.0), bodies=(wall,),
                             time=Time(1.0, inertia=False), stages=(Stage("rest", 1),)))
    assert simulation.imbalance.share < 3e-3        # hat functions do not share the pressure as stress in the soil does
    constants = simulation.model.soil.constants
    pressure = -simulation.state.points.stress[:, 0, 0] @ constants.volume / 2.0        # a mean over 2 m of the soil
    record, = simulation.steps()
    assert record.bodies[0].contact_force[0] == pytest.approx(-pressure, rel=0.01)


def test_a_block_that_falls_freely_in_plane_strain_is_not_out_of_balance():
    """All nodes are held along the collapsed axis, which hinders no fall."""
    side = Axis(0.0, 1.0, 0.25)
    scene = Scene(name="falls", grid=Grid(side, Axis(0.0, 1.0, collapsed=True), Axis(0.0, 2.0, 0.25), Faces(
                  x_min="free", x_max="free", z_min="free")),
                  soil=Soil(SAND, lower=(0.25, 0.0, 1.0), upper=(0.75, 1.0, 1.5), geostatic=False),
                  time=Time(0.01), stages=(Stage("fall", 1),))
    assert build(scene).imbalance is None


@pytest.mark.parametrize("start, inertia, expected", [
    ({}, True, ()), ({}, False, ("hazard",)), ({"settled at the start": "by 1 mm"}, True, ("note",))])
def test_check_tells_of_ground_that_did_not_settle_as_the_run_does(start, inertia, expected):
    imbalance, scheme = SimpleNamespace(hazards=lambda: ["hazard"]), SimpleNamespace(inertia=inertia)
    simulation = SimpleNamespace(imbalance=imbalance, start=start, _imbalance_notes=("note",),
                                 model=SimpleNamespace(scheme=scheme))
    assert Simulation._hazards.fget(simulation) == expected
