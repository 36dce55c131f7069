"""Small problems with known answers, set up once with nothing but geometry, physics, grid and steps.

    .venv/bin/python -m hybrid.study.random.afresh [NAME ...]      # runs them and writes afresh.json beside this file

Each Problem gives its closed form or published value and the error that its few cells excuse. `demos/random/README.md` has the
table. All sizes, strengths and starts differ from those of the demos, the tests and the other studies.
"""

import json
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from hybrid.bench.stamp import stamp
from hybrid.output import atomic
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import HybridError
from hybrid.scene import Axis, Body, Faces, Grid, Joint, Material, Scene, Soil, Stage, Time
from hybrid.study.failure.simulate import simulate
from hybrid.study.random.family import Run

PATH = Path(__file__).with_name("afresh.json")
PUSHED = {"driven": ("z",), "held": ("x", "y", "rx", "ry", "rz")}
WEIGHTLESS = (0.0, 0.0, 0.0)
G = 9.81


@dataclass(frozen=True)
class Problem:
    """title; the Scene; exact answer, from `low` to `high` (the same where it is one number); measure(Run): the answer found; allowed:
    largest deviation from that range [-], of `high`, or of 1 where it is 0."""

    title: str
    scene: Scene
    low: float
    high: float
    measure: Callable
    allowed: float


@dataclass(frozen=True)
class Outcome:
    """What a Problem gave: error: beyond low to high [-], None of a run that failed, whose reason is the last of the messages."""

    name: str
    title: str
    low: float
    high: float
    found: float | None
    error: float | None
    allowed: float
    messages: tuple
    seconds: float


def body(file, values, **table):
    """Body of 1000 kg/m³ unless `table` says otherwise."""
    return Body(**{"geometry": GEOMETRY / file, "density": 1000.0, "parameters": values, "name": file[:-4]} | table)


def scene(name, grid, soil, bodies, time, steps, gravity=(0.0, 0.0, -G), **tables):
    """Scene of one stage."""
    return Scene(name=name, grid=grid, soil=soil, bodies=tuple(bodies), time=time, stages=(Stage("go", steps),), gravity=gravity, **tables)


def clay(strength, density=1.0):
    """Undrained clay, E = 500 s_u."""
    return Material(law="von-mises", young=500 * strength, poisson=0.49, density=density, strength=strength)


def slice_(width=1.0):
    """The axis that plane strain leaves out."""
    return Axis(start=0.0, end=width, collapsed=True)


def force(axis, scale):
    """measure: size of the last contact force of the first body along an axis over `scale` [N]."""
    return lambda run: abs(run.records[-1].bodies[0].contact_force[axis]) / scale


# ------------------------------------------------------------------ clay


def strip(half=3.1, strength=37e3, size=0.4):
    """Half a strip footing, which ends inside a cell."""
    grid = Grid(Axis(start=0.0, end=30 * size, size=size), slice_(), Axis(start=-24 * size, end=2 * size, size=size), Faces(z_min="fixed"))
    foot = body("box.geo", {"length": 2 * half, "width": 1.0, "height": half, "size": 20 * half}, position=(0.0, 0.5, 0.0), rest_on=0.0,
                velocity=(0.0, 0.0, -0.02 * half / 20), **PUSHED)
    soil = Soil(clay(strength), top=0.0, geostatic=False)
    return Problem("strip footing", scene("strip", grid, soil, [foot], Time(1.0, inertia=False), 20, WEIGHTLESS), 2 + np.pi, 2 + np.pi,
                   force(2, half * strength), 0.09)


def circle(radius=0.35, strength=62e3):
    """A quarter of a rough circular footing, three cells in its radius."""
    size = radius / 3
    side = Axis(start=0.0, end=12 * size, size=size)
    grid = Grid(side, side, Axis(start=-9 * size, end=size, size=size), Faces(z_min="fixed"))
    foot = body("cylinder.geo", {"radius": radius, "height": radius, "size": radius / 4}, rest_on=0.0, adhesion=1.0,
                velocity=(0.0, 0.0, -0.04 * radius / 20), **PUSHED)
    soil = Soil(clay(strength), top=0.0, geostatic=False)
    return Problem("circular footing, smooth to rough", scene("circle", grid, soil, [foot], Time(1.0, inertia=False), 20, WEIGHTLESS), 5.69, 6.05,
                   force(2, np.pi / 4 * radius**2 * strength), 0.05)


def deep_cylinder(diameter=0.4, strength=12e3, adhesion=0.0, factor=9.14):
    """A pipe in the clay from the start, five diameters deep, moved sideways by 0.15 diameters."""
    d, size = diameter, diameter / 8
    x = Axis(start=-6 * d, end=6 * d, size=size, fine=(-1.25 * d, 1.25 * d), growth=1.3)
    z = Axis(start=-5 * d, end=5 * d, size=size, fine=(-1.25 * d, 1.25 * d), growth=1.3)
    pipe = body("cylinder.geo", {"radius": d / 2, "height": d, "size": d / 16}, position=(0.0, 0.5 * d, 0.0), rotation=(1.0, 0.0, 0.0, 90.0),
                velocity=(0.15 * d / 20, 0.0, 0.0), driven=("x",), held=("y", "z", "rx", "ry", "rz"), adhesion=adhesion)
    density = 20 * strength / (G * 5 * d)
    soil = Soil(clay(strength, density))
    return Problem(f"pipe deep in clay, sideways, α = {adhesion:g}", scene("deep", Grid(x, slice_(d), z, Faces(z_min="fixed")), soil, [pipe],
                   Time(1.0, inertia=False), 20), factor, factor, force(0, d * d * strength), 0.08)


def half_buried(diameter=0.6, strength=3e3):
    """A smooth pipe pushed half its diameter into weightless clay from the surface: 6 (w/D)^0.25, a fit for rough and smooth ones."""
    d, size = diameter, diameter / 8
    grid = Grid(Axis(start=0.0, end=3 * d, size=size), slice_(d), Axis(start=-3 * d, end=d, size=size), Faces(z_min="fixed"))
    pipe = body("cylinder.geo", {"radius": d / 2, "height": d, "size": d / 16}, position=(0.0, 0.5 * d, 0.0), rotation=(1.0, 0.0, 0.0, 90.0),
                rest_on=0.0, velocity=(0.0, 0.0, -0.5 * d / 40), **PUSHED)
    exact = 6 * 0.5**0.25
    return Problem("pipe pushed half in", scene("laid", grid, Soil(clay(strength), top=0.0, geostatic=False), [pipe],
                   Time(1.0, inertia=False), 40, WEIGHTLESS), exact, exact, force(2, 0.5 * d * d * strength), 0.1)


def plate_anchor(width=1.2, strength=9e3, across=12):
    """A strip plate deep in clay that stays attached, pulled up: 11.42 (thin plate; this one is a third as thick as wide)."""
    b, size = width, width / across
    grid = Grid(Axis(start=0.0, end=5 * b, size=size, fine=(0.0, b), growth=1.3), slice_(b),
                Axis(start=-5 * b, end=5 * b, size=size, fine=(-b, b), growth=1.3), Faces(z_min="fixed"))
    plate = body("box.geo", {"length": b, "width": b, "height": b / 3, "size": 10 * b}, position=(0.0, 0.5 * b, 0.0), tension="full",
                 velocity=(0.0, 0.0, 0.1 * b / 20), **PUSHED)
    soil = Soil(clay(strength, 1700.0))

    def measure(run):
        weight = 1700.0 * G * b * b * b / 6        # of the clay that the plate replaces, half of it
        return abs(-run.records[-1].bodies[0].contact_force[2] + weight) / (0.5 * b * b * strength)

    return Problem("plate anchor, deep, attached", scene("plate", grid, soil, [plate], Time(1.0, inertia=False), 20), 11.42, 11.42, measure, 0.15)


def ball(diameter=0.113, strength=15e3):
    """A quarter of a smooth ball in the clay from the start, three diameters deep, pushed down: 11 to 13."""
    d, size = diameter, diameter / 6
    side = Axis(start=0.0, end=2.5 * d, size=size, fine=(0.0, 0.7 * d), growth=1.4)
    z = Axis(start=-2.5 * d, end=3.0 * d, size=size, fine=(-0.9 * d, 0.7 * d), growth=1.4)
    probe = body("sphere.geo", {"radius": d / 2, "size": d / 12}, velocity=(0.0, 0.0, -0.2 * d / 16), **PUSHED)
    soil = Soil(clay(strength, 20 * strength / (G * 3 * d)))

    def measure(run):
        forces = [record.bodies[0].contact_force[2] for record in run.records]
        buoyancy = 20 * strength / (3 * d) * np.pi / 24 * d**3
        return (forces[-1] - buoyancy) / (np.pi / 16 * d**2 * strength)

    return Problem("ball penetrometer, deep, smooth", scene("ball", Grid(side, side, z, Faces(z_min="fixed")), soil, [probe],
                   Time(1.0, inertia=False), 16), 11.0, 13.0, measure, 0.1)


# ------------------------------------------------------------------ bodies on held ground


def ride(shape, slope, mu, heading, radius, cell, steps=60, step=0.01, start=(0.13, 0.07)):
    """Distance from rest on a slope, gravity turned; shape: "sphere", "cylinder" or "block"."""
    turn = np.radians(heading)
    along = np.array([np.cos(turn), np.sin(turn)])
    down, across = G * np.sin(np.radians(slope)), G * np.cos(np.radians(slope))
    k = {"sphere": 0.4, "cylinder": 0.5, "block": np.inf}[shape]
    slides = down > (1 + 1 / k) * mu * across
    rate = down - mu * across if slides else 0.0 if shape == "block" else down / (1 + k)
    exact = 0.5 * rate * (steps * step) ** 2
    ends = np.array([start, np.array(start) + exact * along])
    low, high = np.floor((ends.min(0) - 3 * radius) / cell) * cell, np.ceil((ends.max(0) + 3 * radius) / cell) * cell
    grid = Grid(*(Axis(start=float(a), end=float(b), size=cell) for a, b in zip(low, high)), Axis(start=-cell, end=0.0, size=cell))
    file, values, rotation = {"sphere": ("sphere.geo", {"radius": radius, "size": radius / 5}, None),
                              "cylinder": ("cylinder.geo", {"radius": radius, "height": 1.5 * radius, "size": radius / 5}, (*along, 0.0, 90.0)),
                              "block": ("box.geo", {"length": 2 * radius, "width": 2 * radius, "height": radius, "size": 9.0}, (0.0, 0.0, 1.0, heading))}[shape]
    rider = body(file, values, density=2600.0, position=(*start, 0.0), rest_on=0.0, friction=mu,
                 rotation=None if rotation is None else tuple(map(float, rotation)))
    soil = Soil(Material(law="hencky", young=3e7, poisson=0.0, density=1800.0), held=True, geostatic=False)
    what = "slides" if slides else "sticks" if shape == "block" else "rolls"

    def measure(run):
        return float((run.simulation.state.bodies[0].position - run.simulation.initial_bodies[0].position)[:2] @ along)

    return Problem(f"{shape} on {slope}°, μ = {mu:g}, heading {heading}°, {what} [m]", scene("ride", grid, soil, [rider], Time(step), steps,
                   (*(down * along), -across)), exact, exact, measure, 0.005 if exact else 1e-3)


def pendulum(release=140.0):
    """A bar on a hinge, let go from 140 degrees: energy at the lowest place gives its spin, sqrt(2 m g l (1 - cos) / I)."""
    length, step, steps = 0.9, 0.0025, 640
    bar = body("box.geo", {"length": length, "width": 0.07, "height": 0.05, "size": 20.0}, density=7850.0, position=(0.0, 0.0, 2.0),
               rotation=(0.0, 1.0, 0.0, 90.0 - release), friction=0.0)
    pin = Joint("pin", "hinge", ("box",), point=(-length / 2, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    grid = Grid(*(Axis(start=-0.6, end=0.6, size=0.3),) * 2, Axis(start=-0.3, end=0.0, size=0.3))
    soil = Soil(Material(law="hencky", young=1e6, poisson=0.0, density=1800.0), held=True, geostatic=False)
    inertia = length**2 / 12 + 0.05**2 / 12 + length**2 / 4
    exact = np.sqrt(G * length * (1 - np.cos(np.radians(release))) / inertia)

    def measure(run):
        return max(float(np.linalg.norm(record.bodies[0].spin)) for record in run.records)

    return Problem("bar on a hinge from 140°, greatest spin [1/s]", scene("pendulum", grid, soil, [bar], Time(step), steps, joints=(pin,)),
                   exact, exact, measure, 0.005)


# ------------------------------------------------------------------ elastic soil


def oedometer(height=2.3, squeeze=0.12, young=8e6, poisson=0.3):
    """A platen on a column between smooth walls: A M ln(H/h) H/h, M the constrained modulus (Hencky's law)."""
    size = height / 9
    grid = Grid(Axis(start=0.0, end=2 * size, size=size), slice_(0.7), Axis(start=0.0, end=height + size, size=size), Faces(z_min="fixed"))
    platen = body("box.geo", {"length": 6 * size, "width": 0.7, "height": size, "size": 20.0}, position=(size, 0.35, 0.0), rest_on=height,
                  velocity=(0.0, 0.0, -squeeze * height / 10), **PUSHED)
    soil = Soil(Material(law="hencky", young=young, poisson=poisson, density=1700.0), top=height, geostatic=False)
    modulus = young * (1 - poisson) / (1 + poisson) / (1 - 2 * poisson)
    exact = modulus * np.log(1 / (1 - squeeze)) / (1 - squeeze)
    return Problem("platen on a column, stress over exact", scene("oedometer", grid, soil, [platen], Time(1.0, inertia=False), 10, WEIGHTLESS),
                   1.0, 1.0, force(2, exact * 2 * size * 0.7), 0.01)


def hertz(radius=1.7, young=4e6, patch=0.15):
    """A quarter of a sphere on an elastic half space; cells of a third of the patch, a block 40 patches wide."""
    a = patch * radius
    side = Axis(start=0.0, end=40 * a, size=a / 3, fine=(0.0, 2 * a), growth=1.4)
    down = Axis(start=-40 * a, end=0.0, size=a / 3, fine=(-2 * a, 0.0), growth=1.4)
    grid = Grid(side, side, down, Faces(z_min="fixed", x_max="free", y_max="free"))
    probe = body("sphere.geo", {"radius": radius, "size": a / 5, "growth": 0.8}, rest_on=0.0, velocity=(0.0, 0.0, -patch**2 * radius / 4), **PUSHED)
    soil = Soil(Material(law="hencky", young=young, poisson=0.3, density=1700.0), geostatic=False)
    exact = 4 / 3 * young / (1 - 0.3**2) * np.sqrt(radius * (patch**2 * radius) ** 3)
    return Problem("sphere on elastic soil, force over Hertz's", scene("hertz", grid, soil, [probe], Time(1.0, inertia=False), 4, WEIGHTLESS),
                   1.0, 1.0, force(2, exact / 4), 0.09)


def heave(height=6.0, young=60e6):
    """A column whose weight acts at once: the surface swings to twice its static settlement, after 2 H / c."""
    size, density, steps = height / 24, 1900.0, 60
    grid = Grid(*(slice_(size),) * 2, Axis(start=0.0, end=height, size=size), Faces(z_min="fixed"))
    soil = Soil(Material(law="hencky", young=young, poisson=0.0, density=density), geostatic=False)
    time = 2 * height / np.sqrt(young / density)
    exact = density * G * height**2 / young

    def measure(run):
        first, last = run.simulation.initial_position, run.simulation.state.points
        top = np.argmax(first[:, 2])
        return float(first[top, 2] - last.position[top, 2])

    return Problem("column whose weight acts at once, greatest settlement [m]", scene("heave", grid, soil, [], Time(time / steps), steps),
                   exact, exact, measure, 0.05)


# ------------------------------------------------------------------ sand


def wall(depth=2.4, inertia=True, **material):
    """A smooth wall pushed into sand down to a smooth base: Rankine's K_p γ H²/2; the wall stands in it from the start and fills the
    grid behind its face."""
    size = depth / 8
    values = {"law": "drucker-prager", "young": 40e6, "poisson": 0.3, "density": 1750.0, "friction_angle": 34.0, "dilation_angle": 4.0,
              "cohesion": 100.0} | material
    grid = Grid(Axis(start=-4 * size, end=5 * depth, size=size), slice_(), Axis(start=0.0, end=1.5 * depth, size=size))
    step = 0.05 if inertia else 1.0
    blade = body("box.geo", {"length": 4 * size, "width": 1.0, "height": 2 * depth, "size": 20.0}, position=(-2 * size, 0.5, depth),
                 driven=("x",), velocity=(0.03 * depth / 30 / step, 0.0, 0.0), held=("y", "z", "rx", "ry", "rz"))
    soil = Soil(Material(**values), top=depth)
    passive = np.tan(np.radians(45 + values["friction_angle"] / 2)) ** 2
    exact = passive * 0.5 * values["density"] * G * depth**2 + 2 * values["cohesion"] * depth * np.sqrt(passive)
    return Problem(f"smooth wall pushed into sand of {values['friction_angle']:g}°, force over Rankine's", scene("wall", grid, soil, [blade],
                   Time(step, inertia=inertia), 30), 1.0, 1.0, force(0, exact), 0.1)


PROBLEMS = {
    "strip": lambda: strip(),
    "strip, small": lambda: strip(half=0.031, strength=370e3, size=0.004),
    "strip, shifted": lambda: strip(half=3.3),
    "circle": lambda: circle(),
    "deep pipe, smooth": lambda: deep_cylinder(),
    "deep pipe, rough": lambda: deep_cylinder(diameter=1.1, strength=40e3, adhesion=1.0, factor=11.94),
    "half-buried pipe": lambda: half_buried(),
    "plate anchor": lambda: plate_anchor(),
    "ball": lambda: ball(),
    "ball rolls": lambda: ride("sphere", 20, 0.5, 33, 0.4, 0.3),
    "ball slides": lambda: ride("sphere", 65, 0.05, 211, 0.11, 0.2, steps=40),
    "drum rolls": lambda: ride("cylinder", 45, 0.9, 118, 0.55, 0.5),
    "block slides": lambda: ride("block", 30, 0.3, 61, 0.4, 0.35),
    "block sticks": lambda: ride("block", 20, 0.5, 290, 0.4, 0.35),
    "pendulum": lambda: pendulum(),
    "oedometer": lambda: oedometer(),
    "hertz": lambda: hertz(),
    "heave": lambda: heave(),
    "wall": lambda: wall(),
    "wall, quasi-static": lambda: wall(inertia=False),
}


def measure(name):
    """Outcome of the Problem of this name."""
    problem, begin = PROBLEMS[name](), perf_counter()
    try:
        simulation, records, messages = simulate(problem.scene)
        found = float(problem.measure(Run(simulation, records)))
    except HybridError as failure:
        return Outcome(name, problem.title, problem.low, problem.high, None, None, problem.allowed, (str(failure),), round(perf_counter() - begin, 1))
    error = (found - np.clip(found, problem.low, problem.high)) / (problem.high or 1.0)
    return Outcome(name, problem.title, problem.low, problem.high, found, float(error), problem.allowed, tuple(dict.fromkeys(messages)),
                   round(perf_counter() - begin, 1))


def table(rows):
    """Lines of a Markdown table of recorded outcomes, dicts."""
    lines = ["| problem | exact | found | beyond it | messages | time |", "|---|---|---|---|---|---|"]
    for row in rows:
        exact = f"{row['low']:.4g}" + (f" to {row['high']:.4g}" if row["high"] != row["low"] else "")
        found, error = ("stops", "-") if row["found"] is None else (f"{row['found']:.4g}", f"{100 * row['error']:+.2g} %")
        lines.append(f"| {row['name']}: {row['title']} | {exact} | {found} | {error} | {len(row['messages']) or '-'} | {row['seconds']:.0f} s |")
    return lines


def recorded():
    """Rows of the record, dicts."""
    return json.loads(PATH.read_text(encoding="utf-8"))["problems"]


def main(names):
    """Run the problems of these names, all if none, and keep what they gave in PATH."""
    kept = {row["name"]: row for row in recorded()} if PATH.is_file() else {}
    for name in names or PROBLEMS:
        kept[name] = asdict(measure(name))
        print(json.dumps(kept[name], ensure_ascii=False), flush=True)
        rows = ",\n".join(json.dumps(kept[each], ensure_ascii=False) for each in PROBLEMS if each in kept)
        with atomic(PATH) as partial:
            partial.write_text(f'{{"stamp": {json.dumps(stamp())},\n"problems": [\n{rows}\n]}}\n', encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
    print("\n".join(table(recorded())))
