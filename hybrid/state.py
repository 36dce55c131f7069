"""What changes in time, as plain arrays, and the one function that turns a trial into history.

| symbol | field                    | shape     | unit   |
|--------|--------------------------|-----------|--------|
| x_p    | Points.position          | (n, 3)    | m      |
| v_p    | Points.velocity          | (n, 3)    | m/s    |
| a_p    | Points.acceleration      | (n, 3)    | m/s²   |
| -      | Points.algorithmic       | (n, 3)    | m/s²   |
| l_p    | Points.half_width              | (n, 3)    | m      |
| F      | Points.deformation       | (n, 3, 3) | -      |
| b_e    | Points.b_elastic           | (n, 3, 3) | -      |
| σ      | Points.stress (Cauchy)   | (n, 3, 3) | Pa     |
| α      | Points.plastic_strain    | (n,)      | -      |
| C      | Points.affine            | (n, k, 3, 3) | 1/s, 1/s² |
| -      | Points.inactive               | (n,) bool | -      |
| c      | BodyState.position       | (3,)      | m      |
| R      | BodyState.rotation       | (3, 3)    | -      |
| ċ, c̈  | velocity, acceleration   | (3,)      | m/s, m/s² |
| W, A   | spin, spin_rate (body frame) | (3,)  | rad/s, rad/s² |
| -      | algorithmic (space, body frame) | (6,) | m/s², rad/s² |

C, the gradients of v, a and the algorithmic acceleration, is there with affine transfer only. Inactive points have
gone astray and take no part any more; None where none has. The algorithmic acceleration a of `hybrid.scheme` is None
where it is no history of its own.

A step computes a *new* State and never writes into the committed one, so a rejected step costs nothing to undo.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Points:
    """Material points: history that a step carries forward. Shapes in the module's table."""

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

    def __len__(self):
        return len(self.position)


@dataclass(frozen=True)
class PointConstants:
    """What a point keeps for as long as it is neither split nor merged.

    position: (n, 3) [m] and half_width: (n, 3) [m] at the start; volume: (n,) [m³]; mass: (n,) [kg]; geostatic_gradient: (n, 3) [Pa/m],
    growth with height of the principal stress at rest, None without geostatic stress.
    """

    position: np.ndarray
    half_width: np.ndarray
    volume: np.ndarray
    mass: np.ndarray
    geostatic_gradient: np.ndarray | None = None

    def __len__(self):
        return len(self.mass)


@dataclass(frozen=True)
class Population:
    """Material points with all that belongs to them: history, constants, and a row of the law's values for each."""

    points: Points
    constants: PointConstants
    rows: np.ndarray

    def __len__(self):
        return len(self.points)


@dataclass(frozen=True)
class Ground:
    """What a scene cannot tell of its soil any more once the grid travels.

    fine, window: (3, 2) lattice numbers of the layout; made: (a, b, c) bool, blocks whose soil has been laid out;
    constants, rows: of the points that are solved; behind: all of those that the window has left, None if none is kept.
    """

    fine: np.ndarray
    window: np.ndarray
    made: np.ndarray
    constants: PointConstants
    rows: np.ndarray
    behind: Population | None = None


@dataclass
class ContactHistory:
    """Corners near one body that are followed as material points from step to step.

    id        (m,) increasing, 8 p + corner of point p's domain
    position  (m, 3) [m] where the grid has carried the corner
    touching  (m,) bool, in contact at the last accepted step
    anchor    (m, 3) [m] body frame, where friction would be zero; meaningful while touching
    side      (m, 3) body frame, outward normal of the body where the corner touches, else 0
    pressure  (m,) [N] multiplier of the augmented Lagrangian, 0 under plain penalty

    and of the body's samples that touch in the second pass: sample (k,) their numbers, sample_anchor (k, 3) [m] in
    space, sample_pressure (k,) [N]
    """

    id: np.ndarray
    position: np.ndarray
    touching: np.ndarray
    anchor: np.ndarray
    side: np.ndarray
    pressure: np.ndarray
    sample: np.ndarray
    sample_anchor: np.ndarray
    sample_pressure: np.ndarray

    @classmethod
    def empty(cls):
        return cls(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0, bool), np.zeros((0, 3)), np.zeros((0, 3)),
                   np.zeros(0), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0))


@dataclass
class BodyState:
    """Motion of one rigid body.

    target    far end of its pull line (3,) [m]
    reaction  (6,) [N, N m about the centre] of the guides of held and driven components, zero for free ones
    algorithmic  (6,) acceleration and spin rate that generalised-alpha carries, None for other schemes
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


@dataclass
class State:
    """Everything a run needs to go on: time [s], outer step number, points, bodies, work done so far [J], and the
    ground where the grid travels."""

    time: float
    step: int
    points: Points
    bodies: list[BodyState]
    contacts: list[ContactHistory]
    work: dict[str, float] = field(default_factory=dict)
    ground: Ground | None = None
