"""Motions and loads of bodies in a stage: guides that follow tables of time, forces and moments at points.

A component that is driven by a table has in an increment of Δt, with Δ its displacement there and s the change of its rate
over Δt (zero of a table of displacements, whose rate is constant between two times),

    rate at the start  Δ/Δt - s Δt/2      rate at the end  Δ/Δt + s Δt/2      second rate  s

so that the scheme's own rule gives Δ, and the inertia force is m s. Where the rate at the start differs from that at the
end of the last increment the guides strike the body; the work of that impulse is work of the drive.

A force F(t) at a point r of the body and a moment M(t), along the axes of space, with s = R r, and unknowns (δc, δφ):

    residual = -[ F ; s × F + M ]      tangent = [ 0, 0 ; 0, -F~ s~ ]

Equations: FORMULATION (52), (53).
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body.attitude import log_so3, skew
from hybrid.body.table import Table

FARTHEST = 3.0      # [rad] that Cayley's map turns in an increment: it cannot turn by π


@dataclass(frozen=True)
class Guide:
    """A component (0 to 5) that follows a Table of its rate [m/s, rad/s], or of its displacement [m, rad]."""

    component: int
    table: Table
    is_rate: bool

    def during(self, time, dt):
        """(mean rate, second rate) in the increment of `dt` from `time` [s]."""
        if self.is_rate:
            change = self.table.at(time + dt) - self.table.at(time)
            return float(self.table.integral(time, time + dt)[0]) / dt, float(change[0]) / dt
        return float((self.table.at(time + dt) - self.table.at(time))[0]) / dt, 0.0


@dataclass(frozen=True)
class PointLoad:
    """point: (3,) [m] from the centre in the body frame; force, moment: Table of (3,) [N], [N m], along the axes of
    space."""

    point: np.ndarray
    force: Table | None = None
    moment: Table | None = None

    def at(self, time):
        """(force, moment), each (3,)."""
        return [np.zeros(3) if table is None else table.at(time) for table in (self.force, self.moment)]


@dataclass(frozen=True)
class StageControl:
    """What a stage changes of a body: released and held components (6,) bool, guides, loads, and PointGuides."""

    released: np.ndarray
    held: np.ndarray
    guides: tuple[Guide, ...] = ()
    loads: tuple[PointLoad, ...] = ()
    points: tuple = ()

    @property
    def driven(self):
        """(6,) bool, components that guides drive."""
        return np.isin(np.arange(6), [guide.component for guide in self.guides])

    def apply(self, body, start):
        """The body in a stage that starts at a time [s], to which the tables are relative."""
        guided = self.held | self.driven
        guides = tuple(replace(guide, table=_from(guide.table, start)) for guide in self.guides)
        loads = tuple(replace(load, force=_from(load.force, start), moment=_from(load.moment, start))
                      for load in self.loads)
        body = replace(body, free=(body.free | self.released) & ~guided, drive=body.drive * ~(self.released | guided),
                       guides=guides, loads=loads)
        return at_start(body, start)


def _from(table, start):
    return table and replace(table, times=table.times + start)


def forces_of(body):
    """[(k, 3) values [N] of the sum of all forces, at the times of their tables], of each stage that puts some on a body."""
    tables = [[load.force for load in control.loads if load.force is not None] for control in body.stages or ()]
    return [sum(table.at(np.unique(np.concatenate([each.times for each in together]))) for table in together)
            for together in tables if together]


def at_start(body, time):
    """The body with the rates that its guides have at the start of a stage, at a `time` [s]."""
    if not body.guides:
        return body
    drive = body.drive.copy()
    for guide in body.guides:
        drive[guide.component] = guide.table.at(time)[0] if guide.is_rate else guide.during(time, _first(guide, time))[0]
    return replace(body, drive=drive)


def _first(guide, time):
    """Time [s] to the next one of a table, within which its displacement is linear."""
    later = guide.table.times[guide.table.times > time]
    return float(later[0] - time) if len(later) else 1.0


def during(body, time, dt, cayley=False):
    """The body in the increment of `dt` from `time` [s]: mean rates of its guides, and their second rates. cayley: whether
    a rotation in the increment is Cayley's map of them, which turns by less than its argument; it cannot turn by π, and
    what is to turn farther than FARTHEST turns by that, which no step accepts."""
    if not body.guides:
        return body
    drive, second = body.drive.copy(), np.zeros(6)
    for guide in body.guides:
        drive[guide.component], second[guide.component] = guide.during(time, dt)
    angle = dt * np.linalg.norm(drive[3:])
    if cayley and angle > 0.0:
        drive[3:] *= 2.0 * np.tan(0.5 * min(angle, FARTHEST)) / angle
    return replace(body, drive=drive, drive_rate=second)


def load_on(loads, rotation, time):
    """Residual (6,) [N, N m] and tangent (6, 6) of loads at a `time` [s] on a body with this rotation (3, 3)."""
    residual, tangent = np.zeros(6), np.zeros((6, 6))
    for load in loads:
        force, moment = load.at(time)
        arm = rotation @ load.point
        residual -= np.concatenate([force, np.cross(arm, force) + moment])
        tangent[3:, 3:] -= skew(force) @ skew(arm)
    return residual, tangent


def work_of_loads(loads, before, after, time, dt):
    """Work [J] of loads between the BodyStates at both ends of an increment of `dt` from `time` [s]; exact for constant
    forces."""
    work, angle = 0.0, log_so3(after.rotation @ before.rotation.T)
    for load in loads:
        force, moment = (0.5 * (a + b) for a, b in zip(load.at(time), load.at(time + dt)))
        way = after.position - before.position + (after.rotation - before.rotation) @ load.point
        work += float(force @ way + moment @ angle)
    return work
