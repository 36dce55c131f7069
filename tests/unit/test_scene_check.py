"""Values of a scene: ranges and contradictions, and that each error names a remedy."""

import dataclasses

import pytest
from small_scene import refused

from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Faces, Grid, Material, Motion, Scene, Soil, Stage, Time
from hybrid.scene.check_grid import grid_faults
from hybrid.scene.file import load_scene, validate
from hybrid.scene.table import described
from hybrid.study.scenes import box, soil_scene


@pytest.mark.parametrize("override, words", [
    ("grid.x.growth=1", ["grid.x.growth = 1", "above 1 and at most 2"]),
    ("grid.x.growth=2.5", ["above 1 and at most 2"]),
    ("grid.x.fine=[-1, 2]", ["grid.x.fine = [-1, 2]", "[0, 4]"]),
    ("grid.x.fine=[2, 1]", ["grid.x.fine"]),
    ("grid.x.end=0", ["above start = 0"]),
    ("grid.x.size=0", ["grid.x.size", "positive"]),
    ("grid.x.collapsed=true", ["fine and collapsed"]),
    ("grid.y.nodes=[0, 2, 1]", ["increasing"]),
    ("grid.y.nodes=[]", ["increasing"]),
    ("grid.y.end=7", ["nodes give the extent"]),
    ("soil.top=2", ["soil.top = 2", "at most 1"]),
    ("soil.lower=[-1, 0, -2]", ["soil.lower", "inside the grid"]),
    ("soil.upper=[0, 1, 0]", ["soil.lower", "along each axis"]),
    ("soil.points_per_axis=0", ["from 1 to 10"]),
    ("soil.k0=0", ["soil.k0", "positive"]),
    ("soil.material.relative_density=0", ["above 0 and at most 100 %"]),
    ("soil.material.poisson=0.5", ["poisson = 0.5", "below 0.5"]),
    ("soil.material.friction_angle=90", ["90 deg"]),
    ("soil.material.cohesion=-1", ["at least 0"]),
    ("body.0.geometry=none.geo", ["none.geo", "existing file", "relative to the scene file"]),
    ("body.0.density=0", ["body.0.density", "kg/m³"]),
    ("body.0.friction=-0.1", ["body.0.friction = -0.1", "at least 0"]),
    ("body.0.penalty=0", ["positive"]),
    ("body.0.tangential=0", ["positive"]),
    ("body.0.rotation=[0, 0, 0, 30]", ["axis other than zero"]),
    ("body.0.velocity=[0, 1, 0]", ["held y"]),
    ("body.0.spin=[0, 1, 1]", ["held rz"]),
    ("body.0.name=a/b", ["plain file name"]),
    ("body.0.pull.stiffness=0", ["N/m"]),
    ("body.0.pull.length=-1", ["positive"]),
    ("body.0.pull.velocity=[0, 0, 0]", ["direction"]),
    ("body.0.pull.direction=[0, 0, 0]", ["other than zero"]),
    ("time.step=0", ["time.step = 0", "positive"]),
    ("time.gamma=0.4", ["0.5 to 1"]),
    ("time.beta=0.2", ["gamma/2 = 0.25"]),
    ("time.gamma=1", ["gamma/2 = 0.5"]),
    ("stage.0.gamma=1", ["stage.0.beta = 0.25", "gamma/2 = 0.5"]),
    ("time.spectral_radius=1.5", ["time.spectral_radius = 1.5", "from 0 to 1"]),
    ("time.scheme=generalized-alpha", ["did you mean 'generalised-alpha'", "valid: newmark"]),
    ("time.smallest=1", ["at most step = 0.04"]),
    ("time.accuracy=0", ["time.accuracy = 0", "at most 1", "1e-3 is usual"]),
    ("stage=[]", ["at least one", "[[stage]]"]),
    ("stage.0.steps=0", ["stage.0.steps = 0", "at least 1"]),
    ("stage.0.step=-1", ["positive"]),
    ("stage.1.name=settle", ["different"]),
    ("solver.tolerance=0", ["1e-14"]),
    ("output.every=-1", ["at least 0"]),
    ("output.pictures=[0]", ["at least 1 each"]),
])
def test_ranges_have_limit_and_remedy(path, override, words):
    message = refused(path, override)
    assert all(word in message for word in words), message
    assert "; " in message  # what follows is the remedy


def test_accuracy_needs_inertia(path):
    message = refused(path, "time.accuracy=1e-3", "time.inertia=false")
    assert "time.accuracy = 0.001: must be left out in a quasi-static scene" in message


def test_a_stage_may_have_a_pair_of_newmark_whatever_the_scheme(path):
    pair = ["stage.0.beta=0.5625", "stage.0.gamma=1"]
    for scheme in ("newmark", "generalised-alpha", "energy-momentum"):
        assert load_scene(path, [f"time.scheme={scheme}", *pair]).stages[0].gamma == 1.0


def test_all_faults_are_listed_at_once(path):
    message = refused(path, "time.beta=0.1", "stage.0.steps=0", "body.0.friction=-1")
    assert "3 faults" in message
    assert all(key in message for key in ("time.beta", "stage.0.steps", "body.0.friction"))


@pytest.mark.parametrize("given, absent", [
    ({"law": "hencky"}, "poisson, density, young"),
    ({"law": "hencky", "young": 1e6, "poisson": 0.2, "density": 1e3}, None),
    ({"law": "hencky", "reference_young": 1e6, "poisson": 0.2, "density": 1e3}, "stiffness_exponent"),
    ({"young": 1e6, "poisson": 0.2, "density": 1e3, "cohesion": 0.0}, "friction_angle, dilation_angle"),
])
def test_without_the_sand_preset_the_law_needs_its_parameters(scene, given, absent):
    changed = dataclasses.replace(scene, soil=Soil(Material(**given), top=0.0))
    if absent is None:
        validate(changed)
        return
    with pytest.raises(SceneError, match=f"soil.material: missing {absent} for law .*relative_density"):
        validate(changed)


@pytest.mark.parametrize("change, words", [
    ({"young": 1e6, "reference_young": 1e6}, "exclude each other"),
    ({"friction_angle": 10.0, "dilation_angle": 20.0}, "at most friction_angle = 10"),
    ({"friction_angle": 0.0, "dilation_angle": 0.0, "cohesion": 0.0}, "no strength"),
])
def test_materials_that_contradict_themselves(scene, change, words):
    with pytest.raises(SceneError, match=words):
        validate(dataclasses.replace(scene, soil=Soil(Material(relative_density=38.0, **change), top=0.0)))


@pytest.mark.parametrize("motion, component", [("velocity=[1, 0, 0]", "x"), ("spin=[0, 1, 0]", "ry")])
def test_a_quasi_static_scene_has_no_velocities_unless_driven(path, motion, component):
    assert not load_scene(path, ["time.inertia=false"]).time.inertia
    quasi_static = ["time.inertia=false", f"body.0.{motion}"]
    message = refused(path, *quasi_static)
    assert "time.inertia = true" in message and f"driven = ['{component}']" in message
    assert "unless driven" in refused(path, *quasi_static, "body.0.driven=['z']")
    assert load_scene(path, [*quasi_static, f"body.0.driven=['{component}']"]).bodies[0].driven == (component,)
    assert load_scene(path, [f"body.0.{motion}"]).time.inertia


def test_a_body_is_not_named_as_the_soil_is(path):
    assert "body.0.name = soil: must be other than 'soil'" in refused(path, "body.0.name=soil").replace('"', "")


@pytest.mark.parametrize("inertia", ["true", "false"])
def test_a_component_is_driven_or_held(path, inertia):
    message = refused(path, f"time.inertia={inertia}", "body.0.driven=['x', 'y', 'rz']")
    assert "body.0.driven = [y, rz]: must be other than held" in message and "one of the two lists" in message


@pytest.mark.parametrize("motion, words", [
    ({"driven": ("y",), "velocity": (0.0, 0.1, 0.0)}, r"body.0.velocity, spin = \[y\]: must be motions in the plane"),
    ({"driven": ("rx",), "spin": (0.1, 0.0, 0.0)}, r"body.0.velocity, spin = \[rx\]"),
    ({"driven": ("x", "y"), "velocity": (0.1, 0.0, 0.0)}, ""),
    ({"velocity": (0.1, 0.1, 0.0)}, r"body.0.velocity, spin = \[y\]: must be motions in the plane across"),
    ({"spin": (0.0, 1.0, 0.0), "velocity": (0.1, 0.0, 0.1)}, "")])
def test_a_body_does_not_move_across_a_collapsed_axis(motion, words):
    """It would leave the slice, and its force with it."""
    described = soil_scene([box(0.2, 0.2, 0.2, rest_on=0.0, **motion)], y=Axis(0.0, 0.2, collapsed=True), time=Time(0.01))
    if not words:
        assert validate(described)
        return
    with pytest.raises(SceneError, match=words):
        validate(described)


def test_points_without_domains_have_no_faces(path):
    message = refused(path, "soil.basis=mpm", "body.0.contact=faces")
    assert message.endswith("contact = faces: must be 'corners' with soil.basis = 'mpm', whose points have no faces; "
                            "leave it out")


def test_a_spin_is_compared_in_space(path):
    """Given along the body's axes: e_x of a body turned by 90 degrees about z is e_y of space."""
    turned = ["time.inertia=false", "body.0.rotation=[0, 0, 2, 90]", "body.0.spin=[1, 0, 0]"]
    assert "driven = ['ry']" in refused(path, *turned, "body.0.driven=['rx']", "body.0.held=['y']")
    assert load_scene(path, [*turned, "body.0.driven=['ry']", "body.0.held=['y', 'rx', 'rz']"])
    assert "zero along held ry" in refused(path, *turned[1:], "body.0.held=['ry']")
    assert load_scene(path, [*turned[1:], "body.0.held=['rx', 'rz']"])


def test_collapsed_axes_need_no_size(path):
    plane = load_scene(path, ["grid.y={start = 0, end = 1, collapsed = true}"])
    assert plane.grid.y.collapsed and plane.grid.y.size is None
    flat = "{start = -2, end = 1, collapsed = true}"
    assert "uncollapsed" in refused(path, *(f"grid.{axis}={flat}" for axis in "xyz"), "soil.top=0.0")


def test_every_field_of_the_scene_is_explained():
    """Each class documents its fields, with the unit."""
    import hybrid.scene as module

    documented = [c for c in vars(module).values() if dataclasses.is_dataclass(c)]
    assert len(documented) == 18
    for cls in documented:
        for f in dataclasses.fields(cls):
            unit = f" [{described(f).unit}]" if described(f).unit else ""
            assert described(f).meaning and f"    {f.name:<23}{unit} " in cls.__doc__, f"{cls.__name__}.{f.name}"


@pytest.mark.parametrize("fine, size, remedy", [((-0.53, 0.2), 0.1, "[-0.6, 0.2]"), ((-0.5, 0.27), 0.1, "[-0.5, 0.3]"),
                                                ((-0.97, 0.5), 0.3, "[-0.9, 0.3]"),
                                                ((-0.5, 0.2), 0.1, None), ((-0.5, -0.1), 0.1, None)])
def test_an_interval_of_fine_cells_without_a_line_at_the_top_of_the_soil_is_refused_with_one_that_has(fine, size, remedy):
    """Outside of it the lines depend on how the cells grow."""
    def faults(fine, **given):
        grid = Grid(Axis(0.0, 1.0, 0.1), Axis(0.0, 1.0, 0.1), Axis(-1.0, 0.5, size, fine=fine), Faces())
        soil = Soil(Material(law="hencky", young=1e6, poisson=0.3, density=1e3), **{"top": 0.0} | given)
        return list(grid_faults(Scene(name="soil", grid=grid, soil=soil, time=Time(0.1), stages=(Stage("go", 1),))))

    found = faults(fine)
    assert len(found) == bool(remedy) == len(faults(fine, upper=(1.0, 1.0, 0.123)))     # whose z soil.top replaces
    if remedy:
        assert found[0].startswith("soil.top = 0: must be on a line of the grid") and remedy in found[0]
        assert not faults(tuple(float(end) for end in remedy.strip("[]").split(",")))


@pytest.mark.parametrize("velocity, first, lost", [
    ((0.0, 0.0, -3.0), True, True), ((0.0, 0.0, -3.0), False, False), ((1.0, 0.0, 0.0), True, False)])
def test_a_velocity_that_the_first_stage_holds_is_refused(velocity, first, lost):
    """It would be lost without a word; a later stage stops a body that moves."""
    ram = box(0.2, 0.2, 0.2, name="ram", position=(0.4, 0.4, 0.0), rest_on=0.1, velocity=velocity)
    holds, goes = Stage("settle", 1, motions=(Motion(held=("z",)),)), Stage("go", 1)
    scene = dataclasses.replace(soil_scene([ram]), stages=(holds, goes) if first else (goes, holds))
    if not lost:
        assert validate(scene).stages == scene.stages
        return
    with pytest.raises(SceneError, match=r"stage.0.motion.0.held = \[z\]: must be other than what ram moves along"):
        validate(scene)
