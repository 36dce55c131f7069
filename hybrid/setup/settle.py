"""The start of soil that geostatic stress does not leave in equilibrium: around a body in place, under ground that is not
level.

Quasi-static steps under the loads of the start find the equilibrium before the first stage begins: the first one takes
nearly all, the others what is out of balance after the points have moved. Where Newton's method fails near the geostatic
stress, as on some stable slopes of sand with ψ < φ, gravity grows from none instead. Bodies are held, pull lines are
slack; then time, velocities and work are zero again, and stress, contact and the places of points stay.
"""

import logging
from dataclasses import dataclass, replace

import numpy as np

from hybrid.body.rigid import FREEDOMS
from hybrid.monitors.initial_equilibrium import initial_imbalance
from hybrid.runtime.comm import anywhere, maximum
from hybrid.runtime.errors import SceneError, StepError
from hybrid.scheme import Scheme
from hybrid.soil.points import at_rest
from hybrid.step.equations import begin
from hybrid.step.increments import Control, outer_step
from hybrid.step.workspace import Workspace

log = logging.getLogger("hybrid")

SMALLEST = 1 / 64   # of a step: shortest increment that is tried
# The same near the geostatic stress: what is out of balance there acts in any increment, and only backtracking is new
FIRST = 1 / 4
GROWS, SLIDES = 20, 0.05    # increments in which gravity grows; plastic strain of soil that slides as it does
BALANCED = 1e-3     # of the weight: imbalance from which another step is taken,
MOST = 4            # of so many


@dataclass(frozen=True)
class Settled:
    """Result of settling: before, InitialImbalance; in_steps, whether gravity grew from none; moved, largest displacement
    of a point [m]; plastic, largest growth of plastic strain [-]; held, {name: (3,) [N]} force that holds each body."""

    before: object
    in_steps: bool
    moved: float
    plastic: float
    held: dict

    def __str__(self):
        held = "".join(f"; {name} held with ({', '.join(f'{x + 0.0:.4g}' for x in force)}) N"
                       for name, force in self.held.items())
        how = (f"from {100 * self.before.share:.2g} % of the weight out of balance" if not self.in_steps else
               "under gravity that grows from none, as no equilibrium was found near the geostatic stress")
        return (f"quasi-static, {how}: points move by up to {self.moved:.2g} m, plastic strain up to "
                f"{self.plastic:.2g}{held}")


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
        found, report, still, model, in_steps = _equilibrium(still, model, begun, length, workspace)
    except StepError as error:
        retained = (" Sand that a body holds back begins without pressure beside it, where it has no strength: give "
                    "it some cohesion. Beside walls of 2 to 2.5 m 2 kPa was enough, also without inertia."
                    ) if model.bodies else ""
        raise SceneError(
            "the soil finds no equilibrium at the start, with the bodies held. Ground too steep for its strength slides, "
            "and soil over an opening falls: flatten soil.ground or raise the strength, close the opening by a body; or set "
            "soil.geostatic = false and turn gravity on by "
            f"stage.gravity = [0.0, 1.0].{retained} Found in {str(error).partition(';')[0]}") from None
    finally:
        workspace.destroy()
    held = {body.name: -terms.contact.resultant[:3] - body.mass.mass * model.loads.on_bodies(0.0)
            for body, terms in zip(model.bodies, report.evaluation.bodies)}
    new = found.points      # of which other processes may have had some at the start
    settled = Settled(before, in_steps, maximum(np.linalg.norm(new.position - model.soil.constants.position, axis=1)),
                      maximum(new.plastic_strain), held)
    points = replace(new, velocity=np.zeros_like(new.velocity), acceleration=np.zeros_like(new.acceleration),
                     algorithmic=None, affine=None)
    bodies = state.bodies
    if model.scheme.inertia:    # guides of the first stage release from their reaction what they do not hold
        bodies = [replace(body, acceleration=np.zeros(3), spin_rate=np.zeros(3), reaction=now.reaction)
                  for body, now in zip(state.bodies, found.bodies)]
    return model, replace(state, points=points, bodies=bodies, contacts=found.contacts, ground=found.ground), settled


def _equilibrium(still, model, begun, length, workspace):
    """(State in equilibrium, Report, both models with the soil that they then have, whether gravity grew from none): from
    the geostatic stress, and where Newton's method fails there from none, by which soil may find another equilibrium, as
    its stress at rest then is that of its law. Raises StepError."""
    try:
        return *_settled(still, model, still.begin_stage(begun), length, length, FIRST, workspace), False
    except StepError as error:
        if still.soil.law.parameters is None:
            raise
        log.info("the soil finds no equilibrium near the geostatic stress; now gravity grows from none, in about %d steps",
                 GROWS)
        stress = np.zeros((len(begun.points.position), 3))
        bare = at_rest(still.soil.constants, stress, still.soil.law.strain(stress))
        growing = replace(still, loads=still.loads.during(0.0, length, (0.0, 1.0)))
        try:
            found = growing.begin_stage(replace(begun, points=bare))
            found, _, growing, model = _settled(growing, model, found, length, length / GROWS, SMALLEST, workspace, 1)
            still = replace(still, soil=growing.soil)
            found, report, still, model = _settled(still, model, found, length, length, SMALLEST, workspace)
        except StepError:
            raise error from None
        if maximum(found.points.plastic_strain) > SLIDES:
            raise error
        return found, report, still, model, True


def _settled(still, model, found, length, dt, smallest, workspace, most=MOST):
    """(State after up to `most` steps of a `length` [s] in increments of `dt` [s], at least its share `smallest`, Report,
    both models)."""
    for _ in range(most):
        found, report = outer_step(still, workspace, found, length, False, Control(dt, smallest * dt))
        if report.soil is not still.soil:
            soil = report.soil
            still = still.with_soil(soil)
            model = model.with_soil(replace(model.soil, grid=soil.grid, constants=soil.constants, law=soil.law))
        if most > 1 and _imbalance(still, found, length, workspace).share < BALANCED:
            break
    return found, report, still, model


def _imbalance(model, state, length, workspace):
    """InitialImbalance of a State at rest."""
    step = begin(model, state, length, False, workspace)
    return initial_imbalance(step, step.evaluate(step.at_rest()))
