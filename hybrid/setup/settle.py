"""The start of soil that geostatic stress does not leave in equilibrium: around a body in place, under ground that is not
level.

Quasi-static steps under the loads of the start find the equilibrium before the first stage begins: the first one takes
nearly all, the others what is out of balance after the points have moved. Bodies are held, pull lines are slack; then
time, velocities and work are zero again, and stress, contact and the places of points stay.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body.rigid import FREEDOMS
from hybrid.monitors.initial_equilibrium import initial_imbalance
from hybrid.runtime.comm import anywhere, maximum
from hybrid.runtime.errors import SceneError, StepError
from hybrid.scheme import Scheme
from hybrid.step.equations import begin
from hybrid.step.increments import Control, outer_step
from hybrid.step.workspace import Workspace

SMALLEST = 1 / 64   # of a step: shortest increment that is tried
BALANCED = 1e-3     # of the weight: imbalance from which another step is taken,
MOST = 4            # of so many


@dataclass(frozen=True)
class Settled:
    """Result of settling: before, InitialImbalance; moved, largest displacement of a point [m]; plastic, largest growth of
    plastic strain [-]; held, {name: (3,) [N]} force that holds each body."""

    before: object
    moved: float
    plastic: float
    held: dict

    def __str__(self):
        held = "".join(f"; {name} held with ({', '.join(f'{x + 0.0:.4g}' for x in force)}) N"
                       for name, force in self.held.items())
        return (f"quasi-static, from {100 * self.before.share:.2g} % of the weight out of balance: points move by up to "
                f"{self.moved:.2g} m, plastic strain up to {self.plastic:.2g}{held}")


def settle(model, state, length):
    """(Model, State in equilibrium, Settled or None) from a State at rest; nothing is done where the soil carries no
    stress, or no weight. length: [s] of the step, of which nothing depends but a rate. Raises SceneError where there is
    no equilibrium.

    The model is the one given, but where points have gone to other processes."""
    if model.soil.held or not anywhere(state.points.stress):
        return model, state, None
    soil = replace(model.soil, transfer="increments", opens=False,
                   allow_detached=bool(model.bodies))     # as the content of a bucket, which that carries
    still = replace(model.with_soil(soil), scheme=Scheme(inertia=False), joints=()).for_stage(FREEDOMS)
    begun = replace(state, joints=None)     # joints of bodies that are held say nothing
    workspace = Workspace(still)
    try:
        before = _imbalance(still, begun, length, workspace)
        found = still.begin_stage(begun)
        for _ in range(MOST):
            found, report = outer_step(still, workspace, found, length, False, Control(length, SMALLEST * length))
            if report.soil is not still.soil:
                still, soil = still.with_soil(report.soil), report.soil
                model = model.with_soil(replace(model.soil, grid=soil.grid, constants=soil.constants, law=soil.law))
            if _imbalance(still, found, length, workspace).share < BALANCED:
                break
    except StepError as error:
        retained = (" Sand that a body holds back begins without pressure beside it, where it has no strength: give "
                    "it some cohesion. Beside walls of 2 to 2.5 m 2 kPa was enough, also without inertia."
                    ) if model.bodies else ""
        raise SceneError(
            "the soil finds no equilibrium at the start, with the bodies held. Ground too steep for its strength slides: "
            "flatten soil.ground or raise the strength; or set soil.geostatic = false and turn gravity on by "
            f"stage.gravity = [0.0, 1.0].{retained} Found in {str(error).partition(';')[0]}") from None
    finally:
        workspace.destroy()
    held = {body.name: -terms.contact.resultant[:3] - body.mass.mass * model.loads.on_bodies(0.0)
            for body, terms in zip(model.bodies, report.evaluation.bodies)}
    new = found.points      # of which other processes may have had some at the start
    settled = Settled(before, maximum(np.linalg.norm(new.position - model.soil.constants.position, axis=1)),
                      maximum(new.plastic_strain), held)
    points = replace(new, velocity=np.zeros_like(new.velocity), acceleration=np.zeros_like(new.acceleration),
                     algorithmic=None, affine=None)
    bodies = state.bodies
    if model.scheme.inertia:    # guides of the first stage release from their reaction what they do not hold
        bodies = [replace(body, acceleration=np.zeros(3), spin_rate=np.zeros(3), reaction=now.reaction)
                  for body, now in zip(state.bodies, found.bodies)]
    return model, replace(state, points=points, bodies=bodies, contacts=found.contacts, ground=found.ground), settled


def _imbalance(model, state, length, workspace):
    """InitialImbalance of a State at rest."""
    step = begin(model, state, length, False, workspace)
    return initial_imbalance(step, step.evaluate(step.at_rest()))
