"""Forces on a rigid body in a step, contact apart: inertia, weight, pull line, guides of held and driven components.

Six unknowns: translation δc of the centre of mass and rotation δφ about the spatial axes, R <- exp(δφ~) R. Held and
driven components are no unknowns of the system: guides impose their rates, and the residual there is their reaction.
Mass and gravity load are assembled once, from condensed finite elements; in a step only R changes.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from hybrid.body import embedded_line, guides, motion
from hybrid.body.attitude import cayley, exp_so3
from hybrid.body.embedded_line import LineSoil, embedded_line_force
from hybrid.body.guides import Guide, PointLoad, StageControl
from hybrid.body.line import line_force
from hybrid.body.parts import SurfaceParts
from hybrid.body.surface import ContactSurface
from hybrid.body.symmetry import Mirror
from hybrid.state import BodyState

if TYPE_CHECKING:
    from hybrid.body.mass import MassProperties  # loads dolfinx

FREEDOMS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class Line:
    """Pull line: attachment (3,) [m] from the centre in the body frame, initial direction (3,) from there to its far
    end, velocity (3,) [m/s] of the far end, stiffness [N/m], unstretched length [m]; soil: that the line cuts through,
    None where it feels none."""

    attachment: np.ndarray
    direction: np.ndarray
    velocity: np.ndarray
    stiffness: float
    length: float
    tension_only: bool = True
    soil: LineSoil | None = None


@dataclass(frozen=True)
class RigidBody:
    """Constants of a body.

    free: (6,) bool, the unknowns; drive: (6,) [m/s, rad/s] spatial rates of the others, zero for held components
    guides, loads: tables of time that components follow, and forces on it, in the present stage; drive_rate: (6,) second
        rates of driven components in the present increment, None where no table acts
    stages: StageControl of each stage of the run, empty where none changes anything of the body
    parts: SurfaceParts whose contact forces are reported apart, None where the geometry names none
    mirrors: planes of symmetry that it lies in; unmirrored_cut: whether it has a cut face that lies in none
    places: where contact is evaluated on the domains of soil points (`hybrid.contact.places`)
    narrowest: width [m] of the narrowest face between sharp edges in cells as wide or wider; inf without one
    surface: in contact with soil; on soil that yields the outline with its sharp edges rounded off (`hybrid.body.rounded`)
    soft_edges: `hybrid.contact.soft_edges.SoftEdges` of a body on elastic soil, None without
    outline: ContactSurface of the geometry, as it is drawn; None: `surface`
    friction: μ, inf where adhesion alone limits the shear; interface: `hybrid.contact.interface.Interface`, None without
    penalty: p_f [1/m], or on held soil p_f E [N/m³]; contact_pressure: (n,) p_f E [N/m³] against each soil point, given
        by `with_stiffness`; ground: `hybrid.contact.on_ground.HeldGround` of a body with edges on level held
        ground, which takes the place of these
    below_capacity: whether the forces of all stages are far below the bearing capacity of cohesive soil, which hardly flows
    """

    name: str
    mass: "MassProperties"
    surface: ContactSurface
    free: np.ndarray
    drive: np.ndarray
    friction: float
    tangential: float
    penalty: float = 0.0
    below_capacity: bool = False
    places: object = None
    narrowest: float = np.inf
    contact_pressure: np.ndarray | None = None
    line: Line | None = None
    outline: ContactSurface | None = None
    guides: tuple[Guide, ...] = ()
    loads: tuple[PointLoad, ...] = ()
    drive_rate: np.ndarray | None = None
    stages: tuple[StageControl, ...] = ()
    interface: object = None
    soft_edges: object = None
    mirrors: tuple[Mirror, ...] = ()
    unmirrored_cut: bool = False
    parts: SurfaceParts | None = None
    ground: object = None

    def __post_init__(self):
        if self.outline is None:
            object.__setattr__(self, "outline", self.surface)

    @property
    def driven(self):
        """(6,) bool, components that guides drive in any stage."""
        return np.any([self.drive != 0.0, *(control.driven for control in self.stages)], axis=0)

    @property
    def guided(self):
        """(6,) bool, components that are not free, or that guides drive in a stage."""
        return ~self.free | self.driven

    @property
    def radius(self):
        """Radius [m] of a ball about the centre around the surface."""
        return self.surface.radius


def with_stiffness(body, young, held):
    """The body with its contact stiffness against points of Young's modulus `young` (n,) [Pa]; held: bool, soil that
    does not deform, whose modulus does not matter."""
    return replace(body, contact_pressure=np.full_like(young, body.penalty) if held else body.penalty * young)


def bounding_box(body, state):
    """Lower and upper corner (2, 3) [m] of the axis-parallel box about a body."""
    extent = body.outline.extent
    return state.position + np.array([[-extent(-axis) for axis in state.rotation],
                                      [extent(axis) for axis in state.rotation]])


@dataclass(frozen=True)
class BodyTrial:
    """Forces on a body at a trial pose, contact apart: residuals (6,) [N, N m], tangent (6, 6), tension [N], and
    own_moment [N m], |J Ẇ| + |W × J W| at the start of the step; load: of forces and moments of the stage."""

    inertia: np.ndarray
    weight: np.ndarray
    line: np.ndarray
    load: np.ndarray
    tangent: np.ndarray
    tension: float
    line_energy: float
    own_moment: float


def lay_out_line(body, state):
    """`state` with the far end of the body's pull line placed where the line is just taut, if that is not done yet."""
    if body.line is None or state.target is not None:
        return state
    shackle = state.position + state.rotation @ body.line.attachment
    return replace(state, target=shackle + body.line.length * body.line.direction)


def line_ends(line, state):
    """(Pull [N], angle [-]) at the mudline and at the shackle of a Line that cuts through soil, in a BodyState with its
    far end."""
    return embedded_line.line_ends(state.position, state.rotation, line.attachment, state.target, line.length,
                                   line.stiffness, line.soil)


def moved_pose(pose, increment):
    """Pose (position, rotation) after an increment (6,) of translation and spatial rotation."""
    return pose[0] + increment[:3], exp_so3(increment[3:]) @ pose[1]


def turn_between(rotation, other):
    """Largest change [-] of a unit vector that turns from one rotation to the `other`: the 2-norm of their difference, whose
    singular values that are not zero are two equal ones."""
    return np.linalg.norm(other - rotation) / np.sqrt(2.0)


def evaluate(body, state, pose, target, gravity, scheme, dt, time=0.0):
    """BodyTrial at `pose`. target: (3,) [m] far end of the pull line, None if none acts; gravity: (3,) [m/s²]; time: [s]
    of the loads."""
    position, rotation = pose
    inertia, tangent, own = np.zeros(6), np.zeros((6, 6)), 0.0
    if scheme.inertia:
        own = motion.own_moment(body.mass.inertia, state)
        inertia, tangent = motion.inertia_residual(
            body.mass.mass, body.mass.inertia, state, position, rotation, dt, scheme)
    line, tension, energy = np.zeros(6), 0.0, 0.0
    if target is not None:
        tension, line, line_tangent, energy = pull_of(body.line, position, rotation, target)
        tangent = tangent + line_tangent
    load = np.zeros(6)
    if body.loads:
        load, by_rotation = guides.load_on(body.loads, rotation, time)
        tangent = tangent + by_rotation
    return BodyTrial(inertia, weight(body, rotation, gravity), line, load, tangent, tension, energy, own)


def pull_of(line, position, rotation, target):
    """(Tension [N], residual (6,) [N, N m], its tangent (6, 6), energy [J]) of a Line to a body at a pose."""
    ends = position, rotation, line.attachment, target, line.length, line.stiffness
    return line_force(*ends, line.tension_only) if line.soil is None else embedded_line_force(*ends, line.soil)


def weight(body, rotation, gravity):
    """Residual (6,) [N, N m] of the weight."""
    load = body.mass.gravity_load @ (rotation.T @ gravity)
    return -np.concatenate([rotation @ load[:3], rotation @ load[3:]])


def predicted_pose(body, state, scheme, dt):
    """Pose after a step with constant rates; in a quasi-static scene only driven components move.

    The rotation is the scheme's own map, so that a driven spin is constant to round-off and needs no moment.
    """
    rate = state.spatial_rates * body.free * scheme.inertia
    increment = dt * (rate + body.drive)
    rotation = cayley if scheme.rotation == "cayley" else exp_so3
    return state.position + increment[:3], rotation(increment[3:]) @ state.rotation


def rotation_angle(body, state, pose, scheme, dt):
    """Angle [rad] of the step to `pose`, or dt times the spin at its end if that is larger."""
    return motion.rotation_angle(body.mass.inertia, state, *pose, dt, scheme)


def accept(body, state, pose, target, reaction, scheme, dt, load=None):
    """New BodyState at the converged pose. target: (3,) [m] far end of the pull line or None; reaction: (6,) [N, N m]
    of the guides; load: (6,) [N, N m] of the loads of the stage."""
    if scheme.inertia:
        new = motion.updated(body.mass.inertia, state, *pose, dt, scheme)
    else:
        new = BodyState(*pose, (pose[0] - state.position) / dt, np.zeros(3), np.zeros(3), np.zeros(3))
    if not body.free.all():
        new = impose_guide_rates(body, new, 0.5 * dt)
    return replace(new, target=target, reaction=reaction, load=load)


def begin_increment(body, state, scheme, dt):
    """`state` with the rates that guides with tables impose at the start of an increment `dt` [s]. The reaction there
    takes the inertia force that they need from then on."""
    if body.drive_rate is None:
        return state
    new = impose_guide_rates(body, state, -0.5 * dt)
    if state.reaction is None or not scheme.inertia:
        return new
    jump = np.concatenate([body.mass.mass * (new.acceleration - state.acceleration),
                           state.rotation @ body.mass.inertia @ (new.spin_rate - state.spin_rate)])
    return replace(new, reaction=np.where(body.free, 0.0, state.reaction + jump))


def impulse_work(body, old, new):
    """Work (6,) [J], by spatial component, of the impulse that changes the rates of BodyState `old` to those of `new`; its
    sum is the gain of kinetic energy."""
    turn, inertia = old.rotation, body.mass.inertia
    work = 0.5 * body.mass.mass * (new.velocity - old.velocity) * (new.velocity + old.velocity)
    moment = turn @ inertia @ (new.spin - old.spin)
    return np.concatenate([work, 0.5 * moment * (turn @ (new.spin + old.spin))])


def impose_guide_rates(body, state, after=0.0):
    """`state` with the rates that guides impose: by the scheme alone the rate of a component that is stopped would
    oscillate about zero. after: [s] from the middle of the present increment."""
    rotation, algorithmic = state.rotation, state.algorithmic
    drive, second_drive = body.drive, 0.0
    if body.drive_rate is not None:
        drive, second_drive = body.drive + after * body.drive_rate, body.drive_rate

    def imposed(rates, guide):  # rates (6,): translation in space, rotation in the body frame; guide: both in space
        rates = np.where(body.free, np.concatenate([rates[:3], rotation @ rates[3:]]), guide)
        return np.concatenate([rates[:3], rotation.T @ rates[3:]])

    first = imposed(np.concatenate([state.velocity, state.spin]), drive)
    second = imposed(np.concatenate([state.acceleration, state.spin_rate]), second_drive)
    return replace(state, velocity=first[:3], spin=first[3:], acceleration=second[:3], spin_rate=second[3:],
                   algorithmic=None if algorithmic is None else imposed(algorithmic, second_drive))


def reduced_mass(bodies):
    """1/Σ(1/m) [kg] of the RigidBodies that are free to move, inf of none."""
    inverse = sum(1.0 / body.mass.mass for body in bodies if body.free[:3].any())
    return 1.0 / inverse if inverse else np.inf


def kinetic_energy(body, state):
    """½ m v² + ½ W·J W [J]."""
    return 0.5 * body.mass.mass * state.velocity @ state.velocity + 0.5 * state.spin @ body.mass.inertia @ state.spin
