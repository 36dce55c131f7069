"""A run without a solver: the state of each step is given in closed form, and observers are called as by a run."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from hybrid.output.record import BodyRecord, Record
from hybrid.state import BodyState, ContactHistory, Points, State

DT = 0.04


@dataclass(frozen=True)
class Stage:
    name: str
    steps: int


@dataclass(frozen=True)
class Output:
    every: int = 2
    pictures: tuple = (2,)
    checkpoint: int = 2


@dataclass(frozen=True)
class Soil:
    young: float = 2e7
    held: bool = False


@dataclass(frozen=True)
class FakeScene:
    name: str = "fake"
    soil: Soil = Soil()
    stages: tuple = (Stage("settle", 2), Stage("drag", 4))
    output: Output = Output()


def turn(angle):
    """Rotation by `angle` about y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def open_box(size):
    """Half box without its face in the symmetry plane y = 0: vertices (8, 3), outward triangles (10, 3)."""
    lower, upper = np.array([-0.5, 0, -0.5]) * size, np.array([0.5, 0.5, 0.5]) * size
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (2, 3, 7, 6), (0, 4, 5, 1)[::-1], (1, 5, 7, 3)]
    quads[3] = (0, 2, 6, 4)
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return SimpleNamespace(vertices=lower + corners * (upper - lower), triangles=np.array(triangles))


class FakeSimulation:
    """A lattice of points and a half box that is dragged through it along a path given in closed form."""

    mirrors = notes = ()
    increment = backtrack = solver_memory = remembered = None

    def __init__(self, scene=FakeScene(), shape=(10, 4, 5), spacing=0.1):
        self.scene, self.total_steps = scene, sum(stage.steps for stage in scene.stages)
        lattice = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
        self.initial_position = (lattice + 0.5) * spacing - [0, 0, shape[2] * spacing]
        self.initial_half = np.full_like(self.initial_position, spacing / 2)
        self.surfaces, self.body_names = [open_box(np.array([0.3, 0.3, 0.2]))], ["anchor"]
        self.model = SimpleNamespace(bodies=(), soil=SimpleNamespace(grid=SimpleNamespace(smallest_cell=0.1)))
        self.start, self.later_notes = {}, {}
        self.random = np.random.default_rng(1)
        self.state = self.state_at(0)
        self.initial_bodies = self.state.bodies

    def state_at(self, step):
        x, n = self.initial_position, len(self.initial_position)
        centre = np.array([0.3 + 0.02 * step, 0.0, -0.004 * step])
        rise = 0.01 * step * (x[:, 0] - centre[0]) * np.exp(-10 * np.sum((x - centre) ** 2, axis=1)) * 3
        stress = self.random.normal(size=(n, 3, 3))
        points = Points(
            position=x + rise[:, None] * [0, 0, 1], velocity=rise[:, None] * [0, 0, 1.0],
            acceleration=np.zeros((n, 3)), half_width=self.initial_half * 0.98,
            deformation=np.tile(np.eye(3), (n, 1, 1)),
            b_elastic=np.tile(np.eye(3), (n, 1, 1)), stress=1e3 * (stress + stress.transpose(0, 2, 1)),
            plastic_strain=np.abs(rise),
        )
        body = BodyState(
            position=centre, rotation=turn(0.02 * step),
            velocity=np.array([0.5, 0.0, -0.1]), acceleration=np.zeros(3),
            spin=np.array([0, 0.5, 0]), spin_rate=np.zeros(3), target=np.array([5.0, 0, 0]) if step else None,
        )
        point = np.arange(n)
        position, anchor, side = self.random.random((3, n, 3))
        contact = ContactHistory(point, point % 6, position, self.random.random(n) < 0.1, anchor, side,
                                 np.zeros(n))
        return State(step * DT, step, points, [body], [contact], {"pull": 1 / 3 * step})

    def contact_forces(self, b):
        return np.outer(np.arange(8), [1.0, 2.0, 3.0])

    def sheet(self):
        return {"points": np.int64(len(self.initial_position)), "unknowns": 1234}

    def run(self, observers, until=None, outcome="completed"):
        """Go on from the present state, as the time loop would; with `until`, stop there."""
        for observer in observers:
            observer.start(self)
        for step in range(self.state.step + 1, (until or self.total_steps) + 1):
            self.state = self.state_at(step)
            record = self.record()
            for observer in observers:
                observer.accepted(record, self)
        for observer in observers:
            observer.finish({"outcome": outcome, "reason": ""}, self)

    def record(self):
        step, body = self.state.step, self.state.bodies[0]
        stage = 0 if step <= self.scene.stages[0].steps else 1
        half_turn = 0.01 * step
        mine = BodyRecord(
            "anchor", body.position, np.array([np.cos(half_turn), 0, np.sin(half_turn), 0]),
            body.velocity, body.spin, np.array([-1.0, 0, 2.0]) * step, np.zeros(3), 1000.0 * step * stage,
        )
        return Record(
            step, self.scene.stages[stage].name, step - 2 * stage, self.state.time, DT, 1, 3, 0, 1e-7, 17,
            seconds={"contact search": 0.1, "solve": 0.3}, energies={"kinetic": 1 / 7}, bodies=[mine],
        )
