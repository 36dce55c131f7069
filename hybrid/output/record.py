"""The record of an accepted outer step, which observers get; the points they draw and the places of a body's surface.

`Record` and `BodyRecord` are public: the names of their fields stay.

| symbol | field                       | shape | unit  |
|--------|-----------------------------|-------|-------|
| t, Δt  | Record.time, Record.dt      | -     | s     |
| c      | BodyRecord.position         | (3,)  | m     |
| q      | BodyRecord.quaternion       | (4,)  | -     |
| ċ      | BodyRecord.velocity         | (3,)  | m/s   |
| W      | BodyRecord.spin, body frame | (3,)  | rad/s |
| F      | BodyRecord.contact_force    | (3,)  | N     |
| M      | BodyRecord.contact_moment   | (3,)  | N m   |
| T      | BodyRecord.line_tension     | -     | N     |
| δ      | BodyRecord.overlap, deepest | -     | m     |
"""

from dataclasses import dataclass, field

import numpy as np

from hybrid.body.symmetry import Mirror, whole_columns
from hybrid.soil.split_merge import concatenate
from hybrid.state import Points, Population


@dataclass
class BodyRecord:
    """One body at the end of a step: centre of mass, attitude (w, x, y, z), velocity, spin, and the forces on it.

    reaction and work are {component: force or moment of its guides, work done by them [J]} of components that are held or
    driven ("x" ... "rz", "tip x" of a point "tip"), with work["load"] of loads;
    load: (6,) [N, N m], None where none act; parts: {name of a part of the surface: force of the soil on it (3,) [N]},
    which add up to contact_force, empty where the geometry names none; line_ends: (pull [N], angle [-] above the
    horizontal) at the mudline and at the shackle of a line that cuts through soil, else None. Moments are about the
    centre of mass; force and moment are in the spatial frame, the spin is in
    the body frame, as in `hybrid.state.BodyState`. All values are those of what is modelled; mirrors: planes of symmetry
    that the body lies in.
    """

    name: str
    position: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    contact_force: np.ndarray
    contact_moment: np.ndarray
    line_tension: float = 0.0
    overlap: float = 0.0
    reaction: dict[str, float] = field(default_factory=dict)
    load: np.ndarray | None = None
    work: dict[str, float] = field(default_factory=dict)
    mirrors: tuple[Mirror, ...] = ()
    parts: dict[str, np.ndarray] = field(default_factory=dict)
    line_ends: tuple[float, float, float, float] | None = None

    def row(self):
        """Flat dict of this body's columns, each name ending in its unit; of a body in a plane of symmetry each force,
        moment and work with that of the whole body, such as tension_whole_N after tension_N."""
        columns = {}
        for axis, value in zip("xyz", self.position):
            columns[f"{axis}_m"] = value
        for axis, value in zip("wxyz", self.quaternion):
            columns[f"q{axis}"] = value
        for kind, vector, unit in (
            ("v", self.velocity, "m_per_s"),
            ("spin_", self.spin, "rad_per_s"),
            ("contact_f", self.contact_force, "N"),
            ("contact_m", self.contact_moment, "Nm"),
        ):
            for axis, value in zip("xyz", vector):
                columns[f"{kind}{axis}_{unit}"] = value
        for name, force in self.parts.items():
            columns.update(zip((f"contact_{column(name)}_f{axis}_N" for axis in "xyz"), force))
        columns["tension_N"], columns["overlap_m"] = self.line_tension, self.overlap
        if self.line_ends is not None:
            pull, angle, _, steep = self.line_ends
            columns.update(mudline_pull_N=pull, mudline_angle_deg=np.degrees(angle), shackle_angle_deg=np.degrees(steep))
        for name, value in self.reaction.items():
            point, _, name = name.rpartition(" ")
            columns[f"reaction_m{name[1]}_Nm" if name[0] == "r" else f"reaction_{point}{'_' * bool(point)}f{name}_N"] = value
        if self.load is not None:
            columns.update(zip((f"load_{kind}_{unit}" for kind, unit in zip(
                ("fx", "fy", "fz", "mx", "my", "mz"), ["N"] * 3 + ["Nm"] * 3)), self.load))
        columns.update({"load_J" if name == "load" else f"drive_{name.replace(' ', '_')}_J": value
                        for name, value in self.work.items()})
        return {f"{self.name}_{key}": float(value) for key, value in whole_columns(columns, self.mirrors).items()}


@dataclass
class JointRecord:
    """One joint at the end of a step: force [N] and moment about the joined point [N m] (6,) on its first body, along the
    axes of space, and the angle [deg] of a hinge, None of others; mirrors: planes of symmetry that the body lies in."""

    name: str
    force: np.ndarray
    angle: float | None = None
    mirrors: tuple[Mirror, ...] = ()

    def row(self):
        """Flat dict of this joint's columns, each name ending in its unit."""
        names = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")
        columns = whole_columns(dict(zip(names, self.force)), self.mirrors)
        columns = {f"{self.name}_{name}": float(value) for name, value in columns.items()}
        return columns if self.angle is None else columns | {f"{self.name}_angle_deg": self.angle}


@dataclass
class PairRecord:
    """Contact of two bodies with one another at the end of a step: force (3,) [N] of the `second` one on the `first`,
    along the axes of space; deepest overlap [m]; number of places in contact; mirrors: planes of symmetry that they lie
    in."""

    first: str
    second: str
    force: np.ndarray
    overlap: float
    places: int
    mirrors: tuple[Mirror, ...] = ()

    def row(self):
        """Flat dict of this pair's columns, each name ending in its unit."""
        columns = whole_columns(dict(zip(("fx_N", "fy_N", "fz_N"), self.force)), self.mirrors)
        columns["overlap_m"] = self.overlap
        return {f"{self.second}_on_{self.first}_{name}": float(value) for name, value in columns.items()}


@dataclass
class Record:
    """One accepted outer step.

    step            from 1 over all stages; stage_step: from 1 in its stage
    time, dt        [s] end of the step, smallest increment used
    increments      their number; rejections: number of increments rejected; judged: number of those accepted with a
                    residual a hair above the tolerance, or within round-off of the soil's stiffness, or with a contact point
                    between two facets of a body
    iterations      of Newton's method in all increments; krylov: of the linear solver in them
    residual        [-] last relative residual
    contacts        number of points and samples in contact
    seconds         {phase: wall time [s]}, columns of history.csv
    energies        {name: [J]} of the balance, columns of history.csv
    bodies          [BodyRecord]; joints: [JointRecord]; pairs: [PairRecord] of bodies that may touch one another
    notes           warnings, each given once in a run, such as that a body leaves the grid
    copies          how many times what is modelled the whole is: 2 of half a model, 4 of a quarter
    time_error      [m] estimated error of positions that time integration adds in the step, None without time.accuracy
    """

    step: int
    stage: str
    stage_step: int
    time: float
    dt: float
    increments: int
    iterations: int
    rejections: int
    residual: float
    contacts: int
    seconds: dict[str, float] = field(default_factory=dict)
    energies: dict[str, float] = field(default_factory=dict)
    bodies: list[BodyRecord] = field(default_factory=list)
    notes: tuple[str, ...] = ()
    time_error: float | None = None
    krylov: int = 0
    judged: int = 0
    joints: list[JointRecord] = field(default_factory=list)
    pairs: list[PairRecord] = field(default_factory=list)
    copies: int = 1

    def row(self):
        """Flat dict for one line of history.csv, each name ending in its unit where it has one."""
        row = {
            "step": int(self.step),
            "stage": self.stage,
            "stage_step": int(self.stage_step),
            "time_s": float(self.time),
            "dt_s": float(self.dt),
            "increments": int(self.increments),
            "iterations": int(self.iterations),
            "krylov": int(self.krylov),
            "rejections": int(self.rejections),
            "judged": int(self.judged),
            "residual": float(self.residual),
            "contacts": int(self.contacts),
        }
        if self.time_error is not None:
            row["time_error_m"] = float(self.time_error)
        for body in self.bodies:
            row.update(body.row())
        for part in (*self.joints, *self.pairs):
            row.update(part.row())
        for name, value in self.energies.items():
            row[f"energy_{column(name)}_J"] = float(value)
            if self.copies > 1:
                row[f"energy_{column(name)}_whole_J"] = self.copies * float(value)
        row.update({f"seconds_{column(phase)}": float(value) for phase, value in self.seconds.items()})
        return row


def column(name):
    """Name of a phase or energy as part of a column's name: without spaces."""
    return name.replace(" ", "_")


def placed(vertices, body):
    """Vertices (V, 3) [m] of the body frame at the pose of `body` (a BodyState): x = c + R r, (V, 3) [m]."""
    return body.position + vertices @ body.rotation.T


def drawn(simulation):
    """Points to draw and their initial positions (n, 3) [m], with those outside the window of a moving grid; without
    inactive points if the scene removes them."""
    points, initial = simulation.state.points, simulation.initial_position
    if (whole := _with_behind(simulation)) is not None:
        points, initial = whole.points, whole.constants.position
    if points.inactive is None or simulation.scene.soil.stray != "remove":
        return points, initial
    kept = {name: None if value is None else value[~points.inactive] for name, value in vars(points).items()}
    return Points(**kept), initial[~points.inactive]


def numbers_drawn(simulation):
    """Numbers (n,) in the run of the points that are `drawn` by one of several processes."""
    inactive, number = simulation.state.points.inactive, simulation.model.soil.constants.number
    if (whole := _with_behind(simulation)) is not None:
        inactive, number = whole.points.inactive, whole.constants.number
    return number if inactive is None or simulation.scene.soil.stray != "remove" else number[~inactive]


def _with_behind(simulation):
    """Population of all points, with those outside the window of a moving grid; None where there are none of these."""
    ground = simulation.state.ground
    if ground is None or ground.behind is None or not len(ground.behind):
        return None
    return concatenate(Population(simulation.state.points, ground.constants, ground.rows), ground.behind)
