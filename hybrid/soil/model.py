"""The soil as one part of a step: begun from committed points, evaluated at trial displacements, accepted.

    begin     basis, slabs, lumped mass, projected velocity and acceleration       (once a step)
    evaluate  trial strain -> law -> internal force                                (every residual)
    stiffness consistent tangent added into the sparse soil block                  (every Newton iteration)
    accept    new Points from the converged increments                             (once a step)

At the apex of a cone the consistent tangent is zero, and loose sand at the surface flips between nothing and its full
stiffness from one Newton iteration to the next. Mixing a share s of the elastic tangent into the plastic one,
D + s (D_e - D), damps that; it changes the way to the solution, not the solution.

Soil whose displacements are all held is never evaluated: its points only lend their corners to contact.
"""

from dataclasses import dataclass

import numpy as np

from hybrid.grid.axes import Grid
from hybrid.grid.colouring import Slabs, make_slabs
from hybrid.laws import plastic_increment
from hybrid.runtime.comm import largest, total
from hybrid.soil import fbar, ghost, lost_points, transfer
from hybrid.soil.basis import Basis, evaluate_basis
from hybrid.soil.domains import updated_half
from hybrid.soil.forces import internal_force
from hybrid.soil.ghost import Ghost
from hybrid.soil.kinematics import Kinematics, TrialStrain, logarithmic, update_strains
from hybrid.soil.points import PointConstants
from hybrid.soil.principal import from_principal
from hybrid.soil.stiffness import KeptStiffness, add_stiffness
from hybrid.state import Points

SMALL_SUPPORT = 0.1     # of the mass that a node has in whole soil: how `hybrid.linalg.precond_pattern` uses it
NOTHING = 1e-3  # of Young's modulus, the largest diagonal entry of a tangent that is none


@dataclass(frozen=True)
class SoilTrial:
    """Soil at trial displacements: strains, law's response and internal force (N, 3) [N]."""

    strain: TrialStrain
    response: object
    stress: np.ndarray
    force: np.ndarray


@dataclass(frozen=True)
class SoilStep:
    """What is frozen during a step: basis, slabs, nodal mass (N,) [kg], velocity, acceleration (N, 3), weight (N, 3),
    the algorithmic acceleration (N, 3) where the points have one, the mean basis of F-bar, the faces with a penalty."""

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

    @property
    def history(self):
        """Velocity, acceleration and algorithmic acceleration, as `Scheme.advance` takes them."""
        return self.velocity, self.acceleration, self.algorithmic

    @property
    def active(self):
        """(N,) bool, nodes that carry mass."""
        return self.mass > 0


class Soil:
    """Model of the soil: grid, points' constants, law, and what a scene may choose.

    basis          "gimp" | "mpm"
    domain         update of the points' domains (`hybrid.soil.domains`)
    held           all displacements are zero
    elastic_share  of the elastic stiffness in the tangent of plastic points
    fbar           with the cure for locking (`hybrid.soil.fbar`)
    ghost_factor   on Young's modulus in the cure for small cuts (`hybrid.soil.ghost`), 0 without
    stray, adrift  what becomes of points that leave, and whether soil may be held by nothing (`hybrid.soil.lost_points`)
    tangent_tolerance  change of a point's tangent within an increment, relative to Young's modulus, that is left out
    transfer, blend  how points take up the motion of the nodes (`hybrid.soil.transfer`)
    """

    def __init__(self, grid: Grid, constants: PointConstants, law, basis="gimp", domain="moments", held=False,
                 elastic_share=0.0, fbar=False, ghost_factor=0.0, stray="stop", adrift=True,
                 transfer="affine", blend=0.05, tangent_tolerance=0.0):
        self.grid, self.constants, self.law = grid, constants, law
        self.basis, self.domain, self.held = basis, domain, held
        self.refusal = ""  # why the last `evaluate` gave None
        self.elastic_share = elastic_share
        self._share = 0.0 if held or not law.plastic else elastic_share
        n = len(constants)
        self._elastic = law.respond(np.zeros((n, 3)), np.zeros(n)).tangent if self._share else None
        self.fbar, self.ghost_factor = fbar, ghost_factor
        self.stray, self.adrift = stray, adrift
        self.transfer, self.blend = transfer, blend
        self._kinematics = Kinematics(0 if held else n, fbar)
        self.tangent_tolerance = tangent_tolerance
        keeps = tangent_tolerance > 0.0 and not held and not fbar     # the tangent of F-bar is not linear in Â
        self._kept = KeptStiffness(tangent_tolerance, law.young) if keeps else None

    @property
    def keeps_tangents(self):
        """Whether points keep their tangents within an increment (`hybrid.soil.stiffness`)."""
        return self._kept is not None

    def on(self, grid, constants, law):
        """The same model of other points on another grid."""
        return Soil(grid, constants, law, self.basis, self.domain, self.held, self.elastic_share, self.fbar,
                    self.ghost_factor, self.stray, self.adrift, self.transfer, self.blend, self.tangent_tolerance)

    def begin(self, points, load):
        """SoilStep for committed `points` under `load` [m/s²], (3,) or of each point (n, 3).

        Raises StepError when a point left the grid.
        """
        half = points.half_width if self.basis == "gimp" else np.zeros_like(points.half_width)
        basis = evaluate_basis(points.position, half, self.grid.axes)
        if not self.adrift:
            points = self._without_adrift(points, basis)
        slabs = make_slabs(basis.first, self.grid.shape)
        carried = [field for field in (points.velocity, points.acceleration, points.algorithmic) if field is not None]
        carried += [load] if load.ndim > 1 else []
        mass, *nodal = transfer.points_to_grid(basis, slabs, self.grid.axes, points.position,
                                        _of_those_in(points, self.constants.mass), *carried, affine=points.affine)
        if load.ndim > 1:
            load = nodal.pop()
        for field in nodal:
            field[self.grid.fixed] = 0.0
        velocity, acceleration, *algorithmic = nodal
        return SoilStep(
            points, basis, slabs, mass, velocity, acceleration, mass[:, None] * load, *algorithmic,
            mean=fbar.mean_basis(points.position, half, self.grid.axes, basis) if self.fbar else None,
            cuts=ghost.find_faces(basis, self.grid, self.ghost_factor * self.law.young) if self.ghost_factor else None)

    def small_support(self, step):
        """(N,) bool, nodes with less than LIGHT of the mass that the heaviest soil all around would give them."""
        densest = largest(self.constants.mass / self.constants.volume)
        return step.mass < SMALL_SUPPORT * densest * self.grid.volumes

    def evaluate(self, step, displacement):
        """SoilTrial at nodal increments (N, 3) [m], or None with the reason in `refusal`: a point would turn inside
        out, or the law has no stress for it."""
        out = step.points.inactive
        strain = self._kinematics(step.basis, self.grid.shape, displacement, step.points.b_elastic, step.mean, out)
        if len(strain.inverted):
            self.refusal = f"turns soil inside out at {lost_points.list_points(strain.inverted)}"
            return None
        response = self.law.respond(strain.strain, step.points.plastic_strain)
        failed = () if response.failed is None else np.flatnonzero(_of_those_in(step.points, response.failed))
        if len(failed):
            self.refusal = f"leaves the soil's law without a stress at {lost_points.list_points(failed)}"
            return None
        stress = from_principal(response.stress, strain.directions)
        volume = _of_those_in(step.points, self.constants.volume)
        force = internal_force(step.basis, step.slabs, self.grid.shape, strain, stress, volume)
        if self.fbar:
            fbar.add_force(step, self.grid.shape, self.grid.collapsed, strain, stress, volume, force)
        if step.cuts:
            ghost.add_force(step.cuts, self.grid, displacement, force)
        return SoilTrial(strain, response, stress, force)

    def fill_stiffness(self, step, trial, pattern, values, error=1.0):
        """Put the tangent of `trial` into the soil block. Changes within an increment that are too small to matter at
        a relative residual of `error` are left out: fewer the nearer the solution, so that it converges faster than
        linearly."""
        if self._kept is None:
            values[...] = 0.0
            self.add_stiffness(step, trial, pattern, values)
            return
        volume = _of_those_in(step.points, self.constants.volume)
        self._kept.update(step, self.grid.shape, trial.strain, trial.response.stress, self._tangent(trial), volume,
                          pattern, np.sqrt(min(error, 1.0)))
        values[...] = self._kept.values
        if step.cuts:
            ghost.add_stiffness(step.cuts, self.grid, pattern, values)

    def add_stiffness(self, step, trial, pattern, values):
        """Add the consistent tangent of `trial` to the soil block."""
        volume, tangent = _of_those_in(step.points, self.constants.volume), self._tangent(trial)
        if self.fbar:
            fbar.add_stiffness(step, self.grid.shape, self.grid.collapsed, trial.strain, trial.response.stress,
                               tangent, volume, pattern, values)
        else:
            add_stiffness(step.basis, step.slabs, self.grid.shape, trial.strain, trial.response.stress, tangent, volume,
                          pattern, values)
        if step.cuts:
            ghost.add_stiffness(step.cuts, self.grid, pattern, values)

    def _tangent(self, trial):
        """The law's D (n, 3, 3), with a share of the elastic one where it is not that."""
        tangent = trial.response.tangent
        return tangent + self._share * (self._elastic - tangent) if self._share else tangent

    def apex_fraction(self, trial):
        """Share of the points that flow at the apex of their cone: they carry nothing and have no tangent."""
        if not self.law.plastic:
            return 0.0
        x, y, z = (np.abs(trial.response.tangent[:, i, i]) for i in range(3))   # a maximum along short axes is slow
        nothing = np.maximum(np.maximum(x, y), z) < NOTHING * self.law.young
        return float(total(nothing) / total(np.ones(len(nothing))))

    def accept(self, step, trial, displacement, velocity_gain, acceleration, algorithmic=None):
        """New Points from nodal increments of displacement and velocity and from the new accelerations, all (N, 3)."""
        old = step.points
        position = old.position + transfer.interpolate(step.basis, self.grid.shape, displacement)
        left = lost_points.outside_grid(position, self.grid)
        left = left if old.inactive is None else left & ~old.inactive
        if self.stray == "stop":
            lost_points.refuse_outside_grid(left, position, self.grid)
        elastic = trial.response.elastic
        deformation, squares, stress = update_strains(trial.strain, elastic, trial.stress, old, ~self.grid.collapsed)
        history = acceleration, *([] if algorithmic is None else [algorithmic])
        (rate, *history), affine = self._grid_to_points(step, old, velocity_gain, history)
        new = Points(
            position=position,
            velocity=rate,
            acceleration=history[0],
            half_width=updated_half(self.domain, self.constants.half_width, deformation, position, self.grid.axes),
            deformation=deformation,
            b_elastic=squares,
            stress=stress,
            plastic_strain=old.plastic_strain + plastic_increment(trial.strain.strain, elastic),
            algorithmic=None if algorithmic is None else history[1],
            affine=affine,
        )
        return lost_points.deactivate(old, new, left)

    def _grid_to_points(self, step, old, gain, accelerations):
        """Velocities and accelerations (n, 3) and, with affine transfer, the gradients (n, k, 3, 3) of all of them,
        from the nodes' `gain` of velocity and accelerations (N, 3)."""
        if self.transfer == "affine":
            return transfer.grid_to_points(
                step.basis, self.grid.axes, old.position, [step.velocity + gain, *accelerations])
        gain_seen, *seen = (transfer.interpolate(step.basis, self.grid.shape, a) for a in (gain, *accelerations))
        velocity = old.velocity + gain_seen
        if self.transfer == "blended":
            all_of_it = transfer.interpolate(step.basis, self.grid.shape, step.velocity + gain)
            velocity = (1 - self.blend) * velocity + self.blend * all_of_it
        return (velocity, *seen), None

    def _without_adrift(self, points, basis):
        """`points` without those that nothing carries. Raises StepError if the run is to stop for them."""
        piece, held = lost_points.detached_pieces(basis, self.grid, None if points.inactive is None else ~points.inactive)
        loose = (piece > 0) & ~held[piece] if len(held) > 1 else np.zeros(len(points), bool)
        if self.stray == "stop":
            lost_points.refuse_detached(loose, points.position)
        return lost_points.deactivate(points, points, loose)

    def plastic_work(self, step, trial):
        """Work dissipated by plastic flow in the step [J]: Σ τ · Δε_p V0."""
        flow = trial.strain.strain - trial.response.elastic
        volume = _of_those_in(step.points, self.constants.volume)
        return float(total(np.sum(trial.response.stress * flow, axis=1) * volume))

    def stored_energy(self, points):
        """Elastic energy of committed points [J]."""
        strain = logarithmic(points.b_elastic)
        return float(total(self.law.energy(strain) * self.constants.volume))


def _of_those_in(points, values):
    """`values` (n,) of points, 0 where they take no part any more."""
    return values if points.inactive is None else np.where(points.inactive, 0.0, values)
