"""The committed state: everything that changes in time, as plain arrays.

| symbol | field                    | shape     | unit   |
|--------|--------------------------|-----------|--------|
| x_p    | Points.position          | (n, 3)    | m      |
| v_p    | Points.velocity          | (n, 3)    | m/s    |
| a_p    | Points.acceleration      | (n, 3)    | m/s²   |
| -      | Points.algorithmic       | (n, 3)    | m/s²   |
| l_p    | Points.half_width        | (n, 3)    | m      |
| F      | Points.deformation       | (n, 3, 3) | -      |
| b_e    | Points.b_elastic         | (n, 3, 3) | -      |
| σ      | Points.stress (Cauchy)   | (n, 3, 3) | Pa     |
| α      | Points.plastic_strain    | (n,)      | -      |
| o      | Points.opened            | (n,)      | -      |
| C      | Points.affine            | (n, k, 3, 3) | 1/s, 1/s² |
| -      | Points.inactive          | (n,) bool | -      |
| c      | BodyState.position       | (3,)      | m      |
| R      | BodyState.rotation       | (3, 3)    | -      |
| ċ, c̈  | velocity, acceleration   | (3,)      | m/s, m/s² |
| W, A   | spin, spin_rate (body frame) | (3,)  | rad/s, rad/s² |
| -      | algorithmic (space, body frame) | (6,) | m/s², rad/s² |

`affine`, the gradients C of velocity, acceleration and algorithmic acceleration, is None unless soil.transfer is
"affine". `inactive` marks points that have been deactivated (`hybrid.soil.lost_points`), None if there are none.
`opened`, the volume strain by which soil has opened (`hybrid.soil.closing`), is None where none has.
`algorithmic`, the acceleration a of `hybrid.scheme`, is None for schemes that do not carry it.

A step computes a new State and never writes into the committed one, so rejecting it costs nothing.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Points:
    """History of the material points. Shapes in the module's table."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    half_width: np.ndarray
    deformation: np.ndarray
    b_elastic: np.ndarray
    stress: np.ndarray
    plastic_strain: np.ndarray
    algorithmic: np.ndarray | None = None
    affine: np.ndarray | None = None
    inactive: np.ndarray | None = None
    opened: np.ndarray | None = None

    def __len__(self):
        return len(self.position)

    @property
    def active(self):
        """(n,) bool, points that take part."""
        return np.ones(len(self), bool) if self.inactive is None else ~self.inactive

    def of_active(self, values):
        """`values` (n,) of the points, 0 of inactive ones."""
        return values if self.inactive is None else np.where(self.inactive, 0.0, values)


@dataclass(frozen=True)
class PointConstants:
    """Constants of the material points, which change only where points are split or merged.

    position, half_width  (n, 3) [m] at the start
    volume                (n,) [m³] at the start
    mass                  (n,) [kg]
    geostatic_gradient    (n, 3) [Pa/m] of the principal stress at rest along z, None without geostatic stress
    number                (n,) increasing, of the point among those of all processes; None where one has them all
    """

    position: np.ndarray
    half_width: np.ndarray
    volume: np.ndarray
    mass: np.ndarray
    geostatic_gradient: np.ndarray | None = None
    number: np.ndarray | None = None

    def __len__(self):
        return len(self.mass)

    def named(self, ids):
        """Numbers in the run of the points `ids` (k,) of this process."""
        return ids if self.number is None else self.number[ids]


@dataclass(frozen=True)
class Population:
    """Material points with their history, their constants and their rows of the law's parameters."""

    points: Points
    constants: PointConstants
    rows: np.ndarray

    def __len__(self):
        return len(self.points)


@dataclass(frozen=True)
class Ground:
    """Soil data that cannot be rebuilt from the scene once the grid has moved.

    fine, window     (3, 2) numbers of the layout along each axis
    made             (a, b, c) bool, blocks whose soil has been laid out
    constants, rows  of the points in the grid
    behind           points that the window has left behind, None where they are removed
    """

    fine: np.ndarray
    window: np.ndarray
    made: np.ndarray
    constants: PointConstants
    rows: np.ndarray
    behind: Population | None = None


@dataclass
class ContactHistory:
    """Contact points close to one body, which are followed as material points from step to step.

    point, place  (m,) increasing: soil point, and number of the place on its domain (`hybrid.contact.places`); or -1 and the
                  number of a place on the body, which then touches held ground (`hybrid.contact.on_ground`)
    position  (m, 3) [m] of the contact point, which moves with the grid
    touching  (m,) bool, in contact at the last accepted step
    anchor    (m, 3) [m] reference point of the tangential spring, body frame, in space of places on the body; defined while
              touching
    rest      (m,) [m] gap at which its spring has no force, positive of bonded points only
    side      (m, 3) body frame, outward normal of the body where the point touches, else 0
    opened    (m,) bool, whether its bond has broken (`hybrid.contact.interface`); left out: none
    """

    point: np.ndarray
    place: np.ndarray
    position: np.ndarray
    touching: np.ndarray
    anchor: np.ndarray
    side: np.ndarray
    rest: np.ndarray
    opened: np.ndarray | None = None

    def __post_init__(self):
        if self.opened is None:
            self.opened = np.zeros(len(self.point), bool)

    @classmethod
    def empty(cls):
        return cls(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0, bool),
                   np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


@dataclass
class BodyState:
    """Motion of one rigid body.

    position     (3,) [m] centre of mass; rotation: (3, 3) from the body frame to space
    velocity, acceleration  (3,) [m/s, m/s²] of the centre of mass
    spin, spin_rate         (3,) [rad/s, rad/s²] in the body frame
    target       (3,) [m] far end of its pull line, None before the line is laid out
    reaction     (6,) [N, N m about the centre] of the guides of held and driven components, zero for free ones
    load         (6,) [N, N m about the centre] of the loads of its stage, None where none act
    algorithmic  (6,) acceleration and spin rate that generalised-alpha carries, None for other schemes
    apart        number of increments in a row in which it has been near nothing (`hybrid.step.flight`)
    """

    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    spin: np.ndarray
    spin_rate: np.ndarray
    target: np.ndarray | None = None
    reaction: np.ndarray | None = None
    algorithmic: np.ndarray | None = None
    load: np.ndarray | None = None
    apart: int = 0

    @property
    def pose(self):
        """(position, rotation)."""
        return self.position, self.rotation

    @property
    def spatial_rates(self):
        """(6,) [m/s, rad/s] velocity and angular velocity along the axes of space."""
        return np.concatenate([self.velocity, self.rotation @ self.spin])


@dataclass
class JointState:
    """Joints of a model, row by row.

    multipliers  (n,) [N, N m]
    active       (n,) bool, rows that are zero: joints, stops that touch, taut lines, sticking friction
    missed       (n,) [m, rad] values of the rows; None where no point of a body is guided
    """

    multipliers: np.ndarray
    active: np.ndarray
    missed: np.ndarray | None = None


@dataclass
class PairHistory:
    """Contact of two bodies: of each side (0: places on the first body, 1: on the second one) that touch, m of them,

    number  (m,) of the place (`hybrid.contact.samples`)
    anchor  (m, 3) [m] in the frame of the other body, reference point of the tangential spring
    rest    (m,) [m] gap, not positive, at which its spring has no force
    factor  (1,) by which the contact is stiffer than under weight alone, for the speed at which it began
    """

    number_0: np.ndarray
    anchor_0: np.ndarray
    rest_0: np.ndarray
    number_1: np.ndarray
    anchor_1: np.ndarray
    rest_1: np.ndarray
    factor: np.ndarray

    @classmethod
    def empty(cls):
        none = np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)
        return cls(*none, *none, np.ones(1))

    def side(self, i):
        """(number, anchor, rest) of a side."""
        return ((self.number_0, self.anchor_0, self.rest_0), (self.number_1, self.anchor_1, self.rest_1))[i]


@dataclass
class State:
    """Everything that a run needs to continue.

    time      [s]; step: number of the last outer step
    points    Points; bodies: a BodyState for each body; contacts: a ContactHistory for each body
    work      [J] done since the start, {name: value} (`hybrid.step.energy`)
    ground    Ground, None where the grid does not move
    joints    JointState, None without joints
    pairs     PairHistory of each pair of bodies that may touch one another
    increment [s] of the increment that led to it, 0 before the first one; `algorithmic` goes with it
    """

    time: float
    step: int
    points: Points
    bodies: list[BodyState]
    contacts: list[ContactHistory]
    work: dict[str, float] = field(default_factory=dict)
    ground: Ground | None = None
    joints: JointState | None = None
    pairs: list[PairHistory] = field(default_factory=list)
    increment: float = 0.0
