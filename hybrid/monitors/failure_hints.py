"""Probable causes of a step that failed, and what to change in its scene, the most effective change first.

The limits are those at which runs of the failure study fail: modes cuts, domain_gap and round_off.
"""

import numpy as np

from hybrid.contact.interface import RAMP
from hybrid.laws.cone import ETA, ETA_BAR
from hybrid.monitors.initial_equilibrium import initial_imbalance
from hybrid.monitors.load_reached import lifted, overloads
from hybrid.runtime.comm import anywhere, largest, maximum, minimum, total
from hybrid.scene.defaults import GHOST, SLIDING
from hybrid.soil.domains import cells_wide
from hybrid.soil.model import Refusal

CUT = 1e-4          # mass of a node over that of a full one [-]: nodes below have stopped runs without inertia
DOMAIN_WIDTH = 0.9  # cells that a domain may be wide before soil separates next to it,
STRETCHED = 1.05    # if its F is larger than this (Frobenius norm of a column)
LOOSEST = 1e-3      # tolerance that is ever advised: errors of the column's stress grow by a seventh from here on
# Adhesion from which clay may yield beside a body where it slips along it, and the factor on body.penalty with which such
# a step has a solution: DESIGN, "Clay that slips and yields has no stiffness".
ROUGH, SOFTER = 0.7, 0.1
UNBALANCED = 0.1    # share of the weight of the soil at the start: with 1 sand on two held bodies has no first step
ALONG = 0.05        # share of a force that counts as along a surface; and normal to it, that does not
DILATES = 0.4       # of the friction, as φ = 35° and ψ = 13°: with less, strips beyond failure have stopped runs
LITTLE = 1e-3       # of γ H: cohesion that gives sand without stress a stiffness
DAMPING = "the default time.scheme, which damps"


def advice(step, outcome, settings):
    """Text about a failed `step`: probable causes, each with its remedy, then what else to try.

    outcome: of Newton's method (`reason`, `errors`, `evaluation` or None); settings: with its `tolerance`.
    """
    lost = _lost(step, outcome.evaluation)
    overload = overloads(step, outcome.reason, lost)
    changes = remedies(step.model, outcome.reason, outcome.errors, settings.tolerance)
    sudden = any(at_once for _, at_once in overload)
    stands = overload and not sudden        # what it carried is known
    at_rest = not (stands or step.model.scheme.inertia or outcome.evaluation is None)
    if at_rest and (free := _slides_freely(outcome.evaluation)):
        return ". ".join(free)
    if sudden:      # shorter increments of a load that is there at once change nothing
        changes = [change for change in changes if "a smaller time.step" not in change]
    causes = [*(text for text, _ in overload), *probable_causes(step, outcome.evaluation, sudden, bool(stands))]
    text = ". ".join([*causes, *_use(changes, bool(causes))])
    yields = step.soil is not None and step.model.soil.law.plastic and not step.model.scheme.inertia
    if not yields or overload or lost and any(lifted(step, body) for body in step.model.bodies):
        return text
    return text + ". Without inertia a step also fails where the load exceeds what the soil can carry"


def _use(changes, otherwise):
    return [f"{'Otherwise use' if otherwise else 'Use'} {either(changes)}"] if changes else []


def remedies(model, reason="", errors=(), tolerance=0.0):
    """Changes to the scene of `model`, as phrases, the most effective first.

    reason: why Newton's method stopped; errors: relative residuals of its iterations; tolerance: their limit.
    """
    dynamic = model.scheme.inertia
    shorter = "a smaller time.step" if dynamic else "a smaller time.step with more stage.steps"
    if "linear solver" in reason:
        fits = "does not fit" not in reason
        larger = [] if fits else ["larger cells (grid.x.size and the others), or a machine with more memory"]
        free = any(body.free.any() for body in model.bodies)
        held = (["body.held for components of bodies that nothing supports"] if free else
                ["more friction (body.friction) where the soil slides on bodies"]) if model.bodies else []
        support = [] if dynamic else [*held, "time.inertia = true"]
        singular = "direct factor finds the matrix singular" in reason     # a shorter step has the same stiffness
        return (*support, shorter) if singular else (*larger, shorter, *support)
    if "residual" not in reason:    # the increment is too long: rotation, search of contact, inverted soil
        return (shorter,)
    changes = [shorter]
    if errors and min(errors) < min(100 * tolerance, LOOSEST):
        changes.insert(0, "a looser solver.tolerance (the residual is close to it)")
    if not dynamic and _hardly_dilates(model.soil):
        changes.append("a dilation_angle nearer to the friction_angle, without which a step may have no solution near the "
                       "last one, or time.inertia = true")
    if model.bodies:
        changes.append("a lower body.penalty")
    if any((body.friction or body.interface) and body.tangential > SLIDING for body in model.bodies):
        changes.append(f"body.tangential = {SLIDING:g}, where contact sticks and slips in turn")
    if dynamic and not model.scheme.damps:
        changes.append(DAMPING)
    return tuple(changes)


def _hardly_dilates(soil):
    """Whether some of the soil flows with much less dilation than its friction angle."""
    law = soil.law
    if soil.held or not law.plastic or law.parameters is None or law.parameters.shape[1] <= ETA_BAR:
        return False
    return anywhere(law.parameters[:, ETA_BAR] < DILATES * law.parameters[:, ETA])


def accuracy_remedies(model):
    """The same for an increment whose error in time is too large at the shortest length allowed."""
    penalty = ("a lower body.penalty",) if model.bodies else ()
    damping = () if model.scheme.damps else (DAMPING,)
    return ("a larger time.accuracy", "a smaller time.smallest", *penalty, *damping)


def probable_causes(step, evaluation, sudden=False, stands=False):
    """Texts about a failed `step` and the last `evaluation` of its trial values, None where there is none; sudden:
    whether its load acts at once; stands: whether one that grows is likely to be more than the soil carries."""
    if step.soil is None:
        return ()
    model, causes = step.model, []
    quasi_static = not model.scheme.inertia
    lost = _lost(step, evaluation)
    residual = evaluation and evaluation.norms.get("soil [N]")
    limit = model.soil.roundoff_force(model.soil.grid.count_unknowns(step.pattern.free))
    if lost:
        causes += _without_contact(step, sudden)
    elif residual and residual < limit:
        causes.append(f"The residual of the soil, {residual:.2g} N, is round-off of its stiffness, limit {limit:.2g} "
                      "N, as the loads are too small beside the modulus: set a looser solver.tolerance, or a lower "
                      "modulus")
    if quasi_static and evaluation is not None and not stands:
        causes += _slips_at_its_strength(evaluation)
    if quasi_static:
        mass = step.soil.mass[step.pattern.free.any(axis=1)]
        least = minimum(mass, 1.0) / maximum(mass, 1.0)
        if least < CUT and not model.soil.ghost_factor:
            causes.append(f"A node of a nearly empty cell carries {least:.1g} of the mass of a full one, limit {CUT:g} "
                          f"without inertia: leave soil.ghost out, or set soil.ghost = {GHOST:g}")
    return tuple(causes or (*_unbalanced(step), *_without_stiffness(step)))


def _unbalanced(step):
    """Text, if any, about soil that may yield and of which a good part of the weight is not balanced at the start of the
    run. The last evaluation is not valid after it."""
    if step.state.time > 0.0 or not step.model.soil.law.plastic:
        return
    at_rest = step.evaluate(step.at_rest())
    imbalance = None if isinstance(at_rest, Refusal) else initial_imbalance(step, at_rest)
    if imbalance is not None and imbalance.share > UNBALANCED:
        geostatic = "set soil.geostatic = false and " if imbalance.stressed else ""
        yield (f"{imbalance}, is not balanced at the start, limit {UNBALANCED:.0%}: {geostatic}turn gravity on in a first "
               "stage, stage.gravity = [0.0, 1.0]")


def _without_stiffness(step):
    """Text, if any, about sand without cohesion that begins without stress, in a step without inertia: a column of it beside
    a rough wall had no first step, and was right to a per cent with 200 Pa."""
    model = step.model
    if step.state.time > 0.0 or model.scheme.inertia or anywhere(step.state.points.stress) or not model.gravity.any():
        return
    law = model.soil.law
    if not law.plastic or law.parameters is None:      # a law of the user
        return
    if anywhere(~law.undrained & (law.cohesion(0.0) <= 0.0)):
        constants = model.soil.constants
        height = maximum(constants.position[:, 2]) - minimum(constants.position[:, 2])
        density = total(constants.mass) / total(constants.volume)
        little = float(f"{LITTLE * density * np.linalg.norm(model.gravity) * height:.1g}")
        yield ("Sand without cohesion has no stiffness as long as nothing presses it, and begins without stress: set "
               f"soil.material.cohesion = {little:g} Pa, a thousandth of the stress under it, or soil.geostatic = true")


def _lost(step, evaluation):
    """Whether a failed `step` without inertia has bodies and none of them has contact in its last `evaluation`."""
    model = step.model
    return bool(step.soil is not None and evaluation is not None and not model.scheme.inertia and model.bodies
                and not anywhere([len(contact) for contact in evaluation.contacts]))


def _without_contact(step, sudden):
    """Texts about bodies that no point of the soil touches: pulled off, held beside soil that leans on them, or moving
    freely."""
    bodies, cell = step.model.bodies, step.model.soil.grid.smallest_cell
    if texts := [text for body in bodies if (text := lifted(step, body))]:
        return texts
    names = ", ".join(body.name for body in bodies)
    if not any(body.free.any() for body in bodies):
        return [f"No point of the soil touches {names}, held or driven, so that soil that leans on it has no support "
                "and without inertia nothing balances its stress: let the body reach into the soil by a hundredth of a "
                f"cell, {0.01 * cell:.2g} m (body.position), or set time.inertia = true"]
    shorter = "" if sudden else "use shorter increments (a smaller time.step with more stage.steps), "
    return [f"No point of the soil touches {names} any more, so that without inertia no force balances the "
            f"load: start the body in contact with the soil (body.rest_on), {shorter}or set time.inertia = true"]


def _slips_at_its_strength(evaluation):
    """Texts about bodies along which clay slips at almost its own strength."""
    texts = []
    for terms in evaluation.bodies:
        body, contact = terms.step.body, terms.contact
        if not body.interface or (body.interface.adhesion or 0.0) < ROUGH:
            continue
        limit = terms.step.pair.points.limits.shear[contact.active]     # 0 of soil that is no clay, on a smooth body
        if anywhere(contact.slip & (limit > 0.0) & (limit < min(RAMP, body.friction) * contact.pressure)):
            texts.append(f"Clay slips along {body.name} at almost its own strength (body.adhesion) and yields there as "
                         f"well, which leaves it without stiffness: set body.penalty = {SOFTER * body.penalty:.3g} /m, a "
                         "tenth of what it is, or larger cells; shorter steps do not help")
    return texts


def _slides_freely(evaluation):
    """Texts about bodies without friction that forces push along the soil which they rest on."""
    texts = []
    for terms in evaluation.bodies:
        body, force, normal = terms.step.body, np.where(terms.step.free, terms.total, 0.0)[:3], terms.contact.normal
        mean = total(normal)
        if body.friction or body.interface or not mean.any():
            continue
        along = force - force @ mean / (mean @ mean) * mean
        size = np.linalg.norm(along)
        if size > ALONG * np.linalg.norm(force) and largest(np.abs(normal @ along)) < ALONG * size:
            texts.append(f"Nothing resists {body.name} along the soil, as it has no friction: give body.friction, or "
                         "hold or drive that component (body.held, body.driven)")
    return texts


def overstretched_domains(model, points):
    """Texts (none or one) about `points` stretched so far that soil may separate between them; only without inertia."""
    soil = model.soil
    if model.scheme.inertia or soil.held:
        return ()
    widths = cells_wide(soil.constants.half_width, points.deformation, points.position, soil.grid.axes)
    widest = largest(np.where(np.linalg.norm(points.deformation, axis=2) > STRETCHED, widths, 0.0))
    if widest < DOMAIN_WIDTH:
        return ()
    return (f"Soil is stretched so far that the domain of a point would be {widest:.2g} cells wide, limit "
            f"{DOMAIN_WIDTH:g}, and may separate there: set a larger soil.points_per_axis",)


def either(changes):
    """List of phrases joined by commas and "or"."""
    *first, last = changes
    return f"{', '.join(first)}, or {last}" if len(first) > 1 else " or ".join([*first, last])
