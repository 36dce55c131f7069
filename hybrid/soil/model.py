"""The soil as one part of a step: begun from committed points, evaluated at trial displacements, accepted.

    begin     basis, slabs, lumped mass, projected velocity and acceleration       (once a step)
    evaluate  trial strain -> law -> internal force                                (every residual)
    stiffness consistent tangent added into the sparse soil block                  (every Newton iteration)
    accept    new Points from the converged increments                             (once a step)

The model never changes in a run. An evaluation gives a SoilTrial, whose strains lie in buffers of the SoilWorkspace, or
a Refusal with the reason why there is none.

Soil whose displacements are all held is never evaluated: its points only provide faces for contact.
"""

from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property

import numpy as np

from hybrid.grid.axes import Grid
from hybrid.grid.colouring import Slabs, make_slabs
from hybrid.laws import Response, plastic_increment
from hybrid.laws.hencky import BULK
from hybrid.runtime.comm import count, largest, number, total
from hybrid.scene import Soil as SoilScene
from hybrid.soil import closing, fbar, ghost, lost_points, transfer
from hybrid.soil.basis import Basis, evaluate_basis
from hybrid.soil.domains import updated_half
from hybrid.soil.filled_cells import fill_cells
from hybrid.soil.forces import internal_force
from hybrid.soil.ghost import Ghost
from hybrid.soil.given_ground import GivenGround
from hybrid.soil.kinematics import TrialStrain, logarithmic, update_strains
from hybrid.soil.principal import from_principal
from hybrid.soil.stiffness import add_stiffness, copy_values
from hybrid.soil.workspace import SoilWorkspace
from hybrid.state import PointConstants, Points

SMALL_SUPPORT = 0.1     # mass of a node over its mass in unbroken soil; `hybrid.linalg.precond_pattern` uses it
NO_STIFFNESS = 1e-3     # largest diagonal entry of a tangent over Young's modulus, below which a point has lost it
INSIDE_OUT, NO_STRESS = "turns soil inside out at", "leaves the soil's law without a stress at"


@dataclass(frozen=True)
class Refusal:
    """Trial displacements that have no evaluation; reason: what they would do, as a clause; points: (k,) numbers in the run
    of the points that they do it to, in this process."""

    reason: str
    points: np.ndarray = ()


@dataclass(frozen=True)
class SoilTrial:
    """Soil at trial displacements: strain, the law's response, Kirchhoff stress (n, 3, 3) [Pa], internal force (N, 3) [N];
    volume strains by which it is open and has closed (n,), or None (`hybrid.soil.closing`). Its strain is valid until the
    next evaluation, unless that one keeps it."""

    strain: TrialStrain
    response: Response
    stress: np.ndarray
    force: np.ndarray
    opened: np.ndarray | None = None
    closed: np.ndarray | None = None


@dataclass(frozen=True)
class SoilStep:
    """The soil as it is frozen during a step.

    basis, mean   of the points, and the mean basis of F-bar
    slabs         points by slabs of cells, for assembly without conflicts
    mass          (N,) [kg]; velocity, acceleration (N, 3); weight (N, 3) [N], all loads on the points
    algorithmic   (N, 3) [m/s²] acceleration that generalised alpha carries, None for other schemes
    cuts          faces with a ghost penalty, None without
    """

    points: Points
    basis: Basis
    slabs: Slabs
    mass: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    weight: np.ndarray
    algorithmic: np.ndarray | None = None
    mean: Basis | None = None
    cuts: Ghost | None = None
    workspace: SoilWorkspace | None = field(default=None, repr=False)

    @property
    def history(self):
        """Velocity, acceleration and algorithmic acceleration, as `Scheme.advance` takes them."""
        return self.velocity, self.acceleration, self.algorithmic

    @property
    def active(self):
        """(N,) bool, nodes that carry mass."""
        return self.mass > 0


@dataclass(frozen=True, eq=False)
class Soil:
    """Model of the soil: grid, constants of its points, law, and options whose defaults are those of a scene.

    basis          "gimp" | "mpm"
    domain         update of the points' domains (`hybrid.soil.domains`)
    held           all displacements are zero
    fbar           with the cure for locking (`hybrid.soil.fbar`)
    ghost_factor   [-] on Young's modulus in the cure for small cuts (`hybrid.soil.ghost`), 0 without
    stray          policy for points that leave the grid or are detached: "stop" | "freeze" | "remove"
    allow_detached whether soil may be detached from all held nodes, as with inertia
    opens          whether soil remembers that it opened, as with inertia (`hybrid.soil.closing`)
    transfer       of the nodes' motion to the points (`hybrid.soil.transfer`)
    heights        (`hybrid.scene.ground.heights` of the ground, top [m]) where they are given
    """

    grid: Grid
    constants: PointConstants
    law: object
    _: KW_ONLY
    basis: str = SoilScene.basis
    domain: str = SoilScene.domain
    held: bool = SoilScene.held
    fbar: bool = False
    ghost_factor: float = 0.0
    stray: str = SoilScene.stray
    allow_detached: bool = True
    opens: bool = True
    transfer: str = SoilScene.transfer
    heights: tuple | None = None

    @cached_property
    def ground(self):
        """GivenGround that contact follows, None where no heights are given."""
        return self.heights and GivenGround.of(*self.heights, self.constants.position, self.constants.half_width)

    def begin(self, points, load, workspace=None):
        """SoilStep for committed `points` under `load` [m/s²], (3,) or of each point (n, 3). workspace: a
        SoilWorkspace of this soil; None: one of its own.

        Raises StepError when a point left the grid, or is detached and the run is to stop for it.
        """
        half = points.half_width if self.basis == "gimp" else np.zeros_like(points.half_width)
        basis = evaluate_basis(points.position, half, self.grid.axes)
        points = points if self.allow_detached else self._without_detached(points, basis)
        slabs = make_slabs(basis.first, self.grid.shape)
        carried = [values for values in (points.velocity, points.acceleration, points.algorithmic)
                   if values is not None]
        carried += [load] if load.ndim > 1 else []
        mass, *nodal = transfer.points_to_grid(basis, slabs, self.grid.axes, points.position,
                                               points.of_active(self.constants.mass), *carried,
                                               affine=points.affine, summed=self.grid.nodes and self.grid.summed)
        if load.ndim > 1:
            load = nodal.pop()
        for values in nodal:
            values[self.grid.fixed] = 0.0
        velocity, acceleration, *algorithmic = nodal
        if self.fbar or self.ghost_factor:
            cells = fill_cells(basis, points.position, half, points.of_active(self.constants.volume), self.law.young,
                               self.grid)
        return SoilStep(
            points, basis, slabs, mass, velocity, acceleration, mass[:, None] * load, *algorithmic,
            mean=fbar.mean_basis(basis, cells, self.law.opens) if self.fbar else None,
            cuts=ghost.find_faces(cells, self.grid, self.ghost_factor) if self.ghost_factor else None,
            workspace=workspace or SoilWorkspace(self))

    def small_support(self, step):
        """(N,) bool, nodes with less than SMALL_SUPPORT of the mass that the densest soil around them would give."""
        densest = largest(self.constants.mass / self.constants.volume)
        return step.mass < SMALL_SUPPORT * densest * self.grid.volumes

    def evaluate(self, step, displacement, keep=None):
        """SoilTrial of the points of this process at nodal increments (N, 3) [m], or a Refusal: one would turn inside out,
        or the law has no stress for it. keep: an earlier SoilTrial that stays valid."""
        points = step.points
        strain = step.workspace.trial_strain(step.basis, self.grid.shape, displacement, points.b_elastic, step.mean,
                                             points.inactive, keep and keep.strain)
        if len(strain.inverted):
            return Refusal(INSIDE_OUT, self.constants.named(strain.inverted))
        response, *volume_strains = closing.respond(self.law, strain.strain, points, self.opens)
        failed = () if response.failed is None else np.flatnonzero(points.of_active(response.failed))
        if len(failed):
            return Refusal(NO_STRESS, self.constants.named(failed))
        stress = from_principal(response.stress, strain.directions)
        volume = points.of_active(self.constants.volume)
        force = internal_force(step.basis, step.slabs, self.grid.shape, strain, stress, volume,
                               fbar.mean_dilatation(step.mean, self.grid.collapsed, strain))
        if step.cuts:
            ghost.add_force(step.cuts, self.grid, displacement, force)
        return SoilTrial(strain, response, stress, force, *volume_strains)

    def fill_stiffness(self, step, trial, pattern, values, error=1.0, elastic=0.0):
        """Put the tangent of `trial` into the soil block (entries `values`), with a share of the `elastic` one.

        Where tangents are kept within an increment, changes are left out that are too small to matter at a relative
        residual of `error`: fewer as it falls, so that Newton's method converges faster than linearly.
        """
        kept = step.workspace.kept
        if kept is None:
            values[...] = 0.0
            self.add_stiffness(step, trial, pattern, values, elastic)
            return
        volume, tangent = step.points.of_active(self.constants.volume), trial.response.tangent
        kept.update(step, self.grid, trial.strain, trial.response.stress, step.workspace.law_tangent(tangent, elastic),
                    volume, pattern, np.sqrt(min(error, 1.0)))
        copy_values(kept.values, values)

    def add_stiffness(self, step, trial, pattern, values, elastic=0.0):
        """Add the tangent of `trial` at all points to the soil block (entries `values`)."""
        volume = step.points.of_active(self.constants.volume)
        tangent = step.workspace.law_tangent(trial.response.tangent, elastic)
        add_stiffness(step, self.grid, trial.strain, trial.response.stress, tangent, volume, pattern, values)
        if step.cuts:
            ghost.add_stiffness(step.cuts, self.grid, pattern, values)

    def apex_fraction(self, trial):
        """Share [-] of the points at the apex of their cone, where the tangent is zero."""
        if not self.law.plastic:
            return 0.0
        x, y, z = (np.abs(trial.response.tangent[:, i, i]) for i in range(3))   # a maximum along short axes is slow
        lost = np.maximum(np.maximum(x, y), z) < NO_STIFFNESS * self.law.young
        return count(lost) / number(lost)

    def accept(self, step, trial, displacement, velocity_gain, acceleration, algorithmic=None):
        """New Points from nodal increments of displacement and velocity and from the new accelerations, all (N, 3)."""
        old = step.points
        position = old.position + transfer.interpolate(step.basis, self.grid.shape, displacement)
        left = lost_points.outside_grid(position, self.grid)
        left = left & old.active
        if self.stray == "stop":
            lost_points.refuse_outside_grid(left, position, self.grid, self.constants)
        elastic = trial.response.elastic
        deformation, b_elastic, stress = update_strains(trial.strain, elastic, trial.stress, old, ~self.grid.collapsed)
        history = acceleration, *([] if algorithmic is None else [algorithmic])
        (rate, *history), affine = self._grid_to_points(step, old, velocity_gain, history)
        new = Points(
            position=position,
            velocity=rate,
            acceleration=history[0],
            half_width=updated_half(self.domain, self.constants.half_width, deformation, position, self.grid.lines),
            deformation=deformation,
            b_elastic=b_elastic,
            stress=stress,
            plastic_strain=old.plastic_strain + plastic_increment(trial.strain.strain, elastic),
            algorithmic=None if algorithmic is None else history[1],
            affine=affine,
            opened=trial.opened,
        )
        return lost_points.deactivate(old, new, left)

    def _grid_to_points(self, step, old, gain, accelerations):
        """Velocities and accelerations (n, 3) and, with affine transfer, the gradients (n, k, 3, 3) of all of them,
        from the nodes' `gain` of velocity and accelerations (N, 3)."""
        if self.transfer == "affine":
            return transfer.grid_to_points(
                step.basis, self.grid.axes, old.position, [step.velocity + gain, *accelerations])
        gain_at_points, *rest = (transfer.interpolate(step.basis, self.grid.shape, a) for a in (gain, *accelerations))
        return (old.velocity + gain_at_points, *rest), None

    def _without_detached(self, points, basis):
        """`points` with detached ones inactive. Raises StepError where the run is to stop for them."""
        piece, held = lost_points.detached_pieces(basis, self.grid, points.active)
        loose = (piece > 0) & ~held[piece] if len(held) > 1 else np.zeros(len(points), bool)
        if self.stray == "stop":
            lost_points.refuse_detached(loose, points.position, self.constants)
        return lost_points.deactivate(points, points, loose)

    def roundoff_force(self, unknowns):
        """Norm [N] of the forces on so many unknowns that come from strains of a few times the machine precision."""
        return 10 * np.finfo(float).eps * self._stiffest_force * np.sqrt(unknowns)

    @cached_property
    def _stiffest_force(self):
        """Largest modulus of a point times the area of its domain [N]."""
        young, parameters = self.law.young, self.law.parameters
        modulus = young if parameters is None else np.maximum(young, parameters[:, BULK])
        return largest(modulus * self.constants.volume ** (2 / 3))

    def plastic_work(self, step, trial):
        """Work dissipated by plastic flow in the step [J]: Σ τ · Δε_p V0."""
        plastic = trial.strain.strain - trial.response.elastic - (0.0 if trial.closed is None else trial.closed[:, None] / 3)
        volume = step.points.of_active(self.constants.volume)
        return float(total(np.sum(trial.response.stress * plastic, axis=1) * volume))

    def ghost_work(self, step, displacement):
        """Work of the ghost penalty [J] on nodal increments (N, 3) [m], which is dissipated."""
        if not step.cuts:
            return 0.0
        force = np.zeros_like(displacement)
        ghost.add_force(step.cuts, self.grid, displacement, force)
        return float(total(force * displacement, axis=None))

    def stored_energy(self, points):
        """Elastic energy of committed points [J], but for inactive ones."""
        # soil that the next step refuses as inside out
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            energy = self.law.energy(logarithmic(points.b_elastic))
        return float(total(points.of_active(energy * self.constants.volume)))
