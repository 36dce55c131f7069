"""Sand against walls, on slopes and let go, by limit analysis and by tests."""

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Material, Soil, Stage, Time
from hybrid.study.random.fresh.problem import G, Problem, body, force, scene, slice_


def wall(depth=2.4, inertia=True, **material):
    """A smooth wall pushed into sand down to a smooth base: Rankine's K_p γ H²/2; the wall stands in it from the start
    and fills the grid behind its face."""
    size = depth / 8
    values = {"law": "drucker-prager", "young": 40e6, "poisson": 0.3, "density": 1750.0, "friction_angle": 34.0,
              "dilation_angle": 4.0,
              "cohesion": 100.0} | material
    grid = Grid(Axis(start=-4 * size, end=5 * depth, size=size), slice_(), Axis(start=0.0, end=1.5 * depth, size=size))
    step = 0.05 if inertia else 1.0
    blade = body("box.geo", {"length": 4 * size, "width": 1.0, "height": 2 * depth, "size": 20.0},
                 position=(-2 * size, 0.5, depth),
                 driven=("x",), velocity=(0.03 * depth / 30 / step, 0.0, 0.0), held=("y", "z", "rx", "ry", "rz"))
    soil = Soil(Material(**values), top=depth)
    passive = np.tan(np.radians(45 + values["friction_angle"] / 2)) ** 2
    exact = passive * 0.5 * values["density"] * G * depth**2 + 2 * values["cohesion"] * depth * np.sqrt(passive)
    return Problem(f"smooth wall pushed into sand of {values['friction_angle']:g}°, force over Rankine's",
                   scene("wall", grid, soil, [blade],
                   Time(step, inertia=inertia), 30), 1.0, 1.0, force(0, exact), 0.1)

def footed_wall(across, depth=1.3):
    """The wall with half as much sand again under its foot, `across` cells in its depth: Rankine's force down to the
    foot."""
    size = depth / across
    below = round(0.5 * across) * size
    grid = Grid(Axis(start=-4 * size, end=5 * depth, size=size), slice_(),
                Axis(start=-below, end=1.5 * depth, size=size), Faces(z_min="fixed"))
    one = wall(depth)
    blade = replace(one.scene.bodies[0], parameters={"length": 4 * size, "width": 1.0, "height": 1.5 * depth, "size": 20.0},
                    position=(-2 * size, 0.5, 0.75 * depth), velocity=(0.05 * depth / 30 / 0.05, 0.0, 0.0))
    return replace(one, title=f"smooth wall that ends in the sand, {across} cells deep, over Rankine's",
                   scene=replace(one.scene, grid=grid, bodies=(blade,)))


def retreat(depth=2.1):
    """The same wall drawn back: Rankine's K_a γ H²/2, less what cohesion carries."""
    problem = wall(depth)
    one, soil = problem.scene, problem.scene.soil
    angle, cohesion, density = soil.material.friction_angle, soil.material.cohesion, soil.material.density
    active = np.tan(np.radians(45 - angle / 2)) ** 2
    exact = active * 0.5 * density * G * depth**2 - 2 * cohesion * depth * np.sqrt(active)
    blade, x = replace(one.bodies[0], velocity=(-0.01 * depth / 30 / 0.05, 0.0, 0.0)), one.grid.x
    grid = replace(one.grid, x=replace(x, start=x.start - x.size))
    sand = replace(soil, lower=(-x.size, 0.0, 0.0))     # the sand begins inside of the wall
    return Problem("the same wall drawn back", replace(one, bodies=(blade,), grid=grid, soil=sand), 1.0, 1.0,
                   force(0, exact), 0.1)


def bank(angle, height=2.0, size=0.2, friction=34.0, dilation=4.0, geostatic=True):
    """A bank of sand on a layer half as high: on planes along the slope sand flows from Davis' angle (1968) on, tan = sin
    φ cos ψ/(1 - sin φ sin ψ), and nothing stands above φ. What stands has not moved; what slides stops below φ. Mean
    angle of the middle half at the end."""
    run_out = height / np.tan(np.radians(angle))
    wide = np.ceil((run_out + 4 * height) / size) * size
    ground = ((0.0, 1.5 * height), (height, 1.5 * height), (height + run_out, 0.5 * height), (wide, 0.5 * height))
    grid = Grid(Axis(start=0.0, end=float(wide), size=size), slice_(),
                Axis(start=0.0, end=1.5 * height + size, size=size), Faces(z_min="fixed"))
    soil = Soil(Material(law="drucker-prager", young=30e6, poisson=0.3, density=1700.0, friction_angle=friction,
                         dilation_angle=dilation,
                         cohesion=0.0), top=1.5 * height, ground=ground, geostatic=geostatic)
    sine = np.sin(np.radians(friction))
    davis = np.degrees(np.arctan(sine * np.cos(np.radians(dilation)) / (1 - sine * np.sin(np.radians(dilation)))))

    def measure(run):
        points = run.simulation.state.points
        edges = np.arange(0.0, wide, size)
        column = np.digitize(points.position[:, 0], edges) - 1
        top = np.array([np.max((points.position + points.half_width)[column == i, 2], initial=0.0)
                        for i in range(len(edges))])
        middle = (top > 0.75 * height) & (top < 1.25 * height)
        return float(-np.degrees(np.arctan(np.polyfit(edges[middle], top[middle], 1)[0])))

    low, high = (angle, angle) if angle < davis else (davis - 4.0, friction)
    return Problem(f"bank of sand of {friction:g}° built at {angle:g}°, angle it has after 2 s",
                   scene("bank", grid, soil, [], Time(0.02), 100), low, high,
                   measure, 0.06)


def slab(angle, depth=1.0, friction=34.0, steps=20, step=0.02):
    """A long slab of sand on a rough plane, gravity turned, its ends free; gravity is turned on in T = 0.4 s and acts as
    long again. Way of its upper half, away from the ends: 7/6 g (sin β - cos β tan φ') T², tan φ' from sin φ (simple
    shear without dilation) to tan φ."""
    size, time = depth / 6, steps * step
    grid = Grid(Axis(start=0.0, end=36 * depth, size=size), slice_(), Axis(start=0.0, end=depth + 2 * size, size=size),
                Faces(z_min="fixed", x_min="free", x_max="free"))
    soil = Soil(Material(law="drucker-prager", young=20e6, poisson=0.3, density=1700.0, friction_angle=friction,
                         dilation_angle=0.0, cohesion=0.0),
                lower=(2 * depth, 0.0, 0.0), upper=(32 * depth, 1.0, depth), geostatic=False)
    turn, phi = np.radians(angle), np.radians(friction)
    low, high = (max(0.0, 7 / 6 * G * (np.sin(turn) - np.cos(turn) * slope) * time**2)
                 for slope in (np.tan(phi), np.sin(phi)))

    def measure(run):
        first, last = run.simulation.initial_position, run.simulation.state.points.position
        middle = (abs(first[:, 0] - 13 * depth) < 3 * depth) & (first[:, 2] > 0.5 * depth)
        return float((last - first)[middle, 0].mean())

    one = scene("slab", grid, soil, [], Time(step), steps, (G * float(np.sin(turn)), 0.0, -G * float(np.cos(turn))))
    stages = Stage("on", steps, gravity=(0.0, 1.0)), Stage("go", steps)
    return Problem(f"slab of sand of {friction:g}° on a rough plane of {angle:g}° [m]", replace(one, stages=stages), low,
                   high, measure,
                   0.1 if high else 0.01)


def column(ratio, half=0.3, cells=8):
    """Half a column of sand let go in plane strain on a rough base: 1.2 a L0 farther for a < 2.3 (Lube, Huppert, Sparks &
    Freundt 2005)."""
    size = half / cells
    height = round(ratio * cells) * size
    time = 4 * np.sqrt(height / G)
    grid = Grid(Axis(start=0.0, end=float(np.ceil((1 + 1.6 * ratio) * cells + 2) * size), size=size), slice_(half),
                Axis(start=0.0, end=height + size, size=size), Faces(z_min="fixed"))
    soil = Soil(Material(law="drucker-prager", young=5e6, poisson=0.3, density=1600.0, friction_angle=30.0,
                         dilation_angle=0.0, cohesion=0.0),
                upper=(half, half, height), geostatic=False)
    return Problem(f"column of sand, a = {ratio:g}, plane strain, let go: run-out over L0",
                   scene("column", grid, soil, [], Time(float(time / 150)), 150),
                   1.2 * ratio, 1.2 * ratio, toe(half, height, size), 0.2)


@cache
def _tables():
    """Folder of tables of ground, removed at the end of the process."""
    return tempfile.TemporaryDirectory()


def round_column(ratio=1.0, radius=0.3, cells=6):
    """A quarter of a cylinder of sand let go on a rough base, with a fiftieth of a cell of it around: 1.24 a r0 farther
    for a < 1.7 (Lube, Huppert, Sparks & Hallworth 2004)."""
    size, height = radius / cells, ratio * radius
    time, fine = 4 * np.sqrt(height / G), np.arange(0.0, 3.2 * radius, size / 10)
    side = Axis(start=0.0, end=float(np.ceil((1 + 1.6 * ratio) * cells + 2) * size), size=size)
    grid = Grid(side, side, Axis(start=0.0, end=height + size, size=size), Faces(z_min="fixed"))
    table = Path(_tables().name) / f"cylinder {ratio:g} {radius:g} {cells}.csv"
    table.write_text("x,y,z\n" + "\n".join(f"{x:.6g},{y:.6g},{height if np.hypot(x, y) < radius else size / 50:.6g}"
                                           for x in fine for y in fine))
    soil = Soil(Material(young=5e6, poisson=0.3, density=1600.0, friction_angle=30.0, dilation_angle=0.0, cohesion=0.0),
                top=height, ground=table,
                geostatic=False)
    return Problem(f"cylinder of sand, a = {ratio:g}, let go: run-out over r0",
                   scene("round", grid, soil, [], Time(float(time / 100)), 100),
                   1.24 * ratio, 1.24 * ratio, toe(radius, height, size), 0.2)


def toe(start, height, size):
    """measure: way of the toe, the farthest place where what was above z = 0 m is as deep as a fiftieth of its first
    `height` [m], from means over strips or rings as wide as a cell of `size` [m], over where it `start`s [m]."""
    def measure(run):
        axes = np.flatnonzero(~run.simulation.model.soil.grid.collapsed[:2])
        constants, points = run.simulation.model.soil.constants, run.simulation.state.points
        distance = np.linalg.norm(points.position[:, axes], axis=1)
        let_go = run.simulation.initial_position[:, 2] > 0.0
        edges = np.arange(0.0, distance.max() + 2 * size, size)
        volume, middle = np.histogram(distance[let_go], edges,
                                      weights=constants.volume[let_go])[0], 0.5 * (edges[1:] + edges[:-1])
        depth = volume / size / (np.ptp(run.simulation.model.soil.grid.extent[1]) if len(axes) == 1
                                 else 0.5 * np.pi * middle)
        last = np.flatnonzero(depth > height / 50)[-1]
        after = depth[last + 1] if last + 1 < len(depth) else 0.0
        return float(middle[last] + size * (depth[last] - height / 50) / (depth[last] - after)) / start - 1.0

    return measure


def dropped(diameter=0.0254, drop=0.1, density=2200.0):
    """A quarter of a sphere dropped on glass beads: 0.14/μ (ρ_b/ρ_g)^½ D^⅔ H^⅓, H the drop and the depth (Uehara,
    Ambroso, Ojha & Durian 2003)."""
    friction, bed, size, step = 0.3, 1510.0, diameter / 5, 0.0005
    side = Axis(start=0.0, end=14 * size, size=size)
    grid = Grid(side, side, Axis(start=-16 * size, end=6 * size, size=size), Faces(z_min="fixed"))
    ball_ = body("sphere.geo", {"radius": diameter / 2, "size": diameter / 10}, density=density, rest_on=0.0,
                 friction=friction,
                 velocity=(0.0, 0.0, -float(np.sqrt(2 * G * drop))), held=("x", "y", "rx", "ry", "rz"))
    soil = Soil(Material(young=1e6, poisson=0.3, density=bed, friction_angle=float(np.degrees(np.arctan(friction))),
                         dilation_angle=0.0, cohesion=0.0),
                top=0.0)
    factor, exact = 0.14 / friction * np.sqrt(density / bed) * diameter ** (2 / 3), 0.0
    for _ in range(50):
        exact = factor * (drop + exact) ** (1 / 3)

    def measure(run):
        return -min(float(record.bodies[0].position[2]) for record in run.records) + diameter / 2

    return Problem("sphere dropped on glass beads, depth [m]", scene("dropped", grid, soil, [ball_], Time(step), 100),
                   exact, exact, measure, 0.2)
