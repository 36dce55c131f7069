"""Penalty stiffness of the contact of a body with the soil of a scene.

on elastic soil                           p_f = 500 / h, 2000 / h of a body of planes driven into it, 100 / h of one with
                                          friction that shears it in plane strain
on soil that yields                       p_f = 20 / h, 500 / h of a plane base that stages press with less than half of what
                                          the cohesion of the soil bears, 25 M/(E H), of 20 / h to 100 / h, where a layer
                                          under it is thinner than it is wide
on held soil                              p_f E = W / (π r δ²),  δ = 2 s²/r; more under a narrow foot (`hybrid.setup.foot`)
of a curved body that rests on elastic    the softer one of 500 / h and that on held soil,  s <= r/32
soil

with h the smallest cell, W the weight of the body, s the spacing of the places of contact and r the radius of curvature that
nine tenths of its surface exceed (a body of planes: its size), M the modulus of confined compression of a layer of height H.
On elastic soil the overlap is that of 1/500 of a cell under the same pressure. Soil that yields bears a hundredth of E at
most, so there 20/h leaves an overlap of 1/2000 of a cell; a pipe in clay takes 6 iterations a step with it, and 28 with
400/h. In sand E is small at the surface, but contact points move with the grid: the stiffer their springs, the fewer of them
carry a body. On held soil nothing but the penalty gives way: there δ is the overlap of a sphere under its weight, whose
contact patch, sqrt(2 r δ), has a radius of two spacings; a stiffer one would feel the places one by one. A curved body that
nothing but elastic soil carries would also roll on single places if the soil is stiff. There s shrinks with the cells, so
cells that resolve the patch of Hertz, a/4, make 500/h the softer one again.

A thin layer that keeps its volume is squeezed out from under a wide base, most stiffly in its middle, and springs that give
way there spread the load to the edges. Rough strips on clay, ν = 0.49, with 4 and 8 cells in the layer, under a tenth of
what they bear: settlement too large by

| layer / width | 20/h    | 60/h   | 25 M/(E H) | 50 M/(E H) |
|---------------|---------|--------|------------|------------|
| 1/4           | 17, 8 % | 6, 2 % | 3, 3 %     | 0, 1 %     |
| 1/2           | 20, 9 % |        | 5, 4 %     | 2, 2 %     |

in 1, 1.2 and 1.6 times the iterations; of strips that are driven in with 1, 1.4 and 1.8 times, loads then differ by 1 %. A
layer thicker than the base is wide gives way more than 20/h does by far.
"""

import numpy as np

from hybrid.body.symmetry import copies
from hybrid.laws.hencky import BULK, SHEAR
from hybrid.runtime.comm import largest, maximum
from hybrid.setup.foot import standing_stiffness
from hybrid.setup.interface import friction_of
from hybrid.soil.points import extent

STIFFNESS = {False: 500.0, True: 20.0}  # p_f h, by whether the soil yields
THIN = 25.0                         # p_f E H/M on a layer of height H thinner than a base is wide
STIFFEST = 100.0                    # p_f h there: of layers of two cells more costs three times the iterations
MUCH_STIFFER = 10.0                 # times the stiffness of the layer: what it lies on
PRESSED = 2000.0                    # the same of planes driven into elastic soil: their force is wanted, and cells follow
SHEARED = 100.0                     # of planes with friction that shear it in plane strain: all points in contact stick
PATCH = 2.0                         # spacings in the radius of a contact patch on held soil
PUBLISHED = 50.0                    # [1/m] p_f
REST_CURVATURE = 32                 # spacings in a radius of curvature of bodies that rest on soil of given shape


def penalty(described, body, motion, soil, spacing, radius, gravity):
    """p_f [1/m], or on held soil p_f E [N/m³]."""
    young, factor = largest(soil.law.young), largest(soil.law.young) if soil.held else 1.0
    if described.penalty is not None:
        return described.penalty * factor
    if described.contact == "corners":
        return PUBLISHED * factor
    stiff = _stiffness(described, body, soil, radius, gravity) / soil.grid.smallest_cell
    stays = described.tension is not None or body.driven[:2].any()      # on the soil, or goes along it
    if soil.law.plastic and np.isinf(radius) and not (soil.held or stays):
        stiff = max(stiff, min(_on_thin_layer(body, motion, soil), STIFFEST / soil.grid.smallest_cell))
    weight = copies(body.mirrors) * body.mass.mass * np.linalg.norm(gravity)
    resting = rests(body, soil, radius, gravity)
    if weight == 0.0 or not (soil.held or resting):
        return stiff * factor
    radius = min(radius, body.radius)
    overlap = 0.5 * (PATCH * min(spacing, radius / REST_CURVATURE)) ** 2 / radius
    thickness = np.prod(np.ptp(soil.grid.extent[soil.grid.collapsed], axis=1))
    stands = standing_stiffness(body.surface, motion.rotation, soil.grid.collapsed, weight, thickness) if soil.held else 0.0
    if soil.grid.collapsed.any():   # of a slice of two diameters, for any thickness
        weight *= 4.0 * radius / thickness
    felt = max(weight / (np.pi * radius * overlap**2), stands)
    return felt if soil.held else min(stiff, felt / young)


def _stiffness(described, body, soil, radius, gravity):
    """p_f h of a body on soil that deforms, which it shears where it is driven in two ways, or in one under a load."""
    if body.below_capacity:
        return STIFFNESS[False]
    if soil.law.plastic or np.isfinite(radius) or not body.driven.any():
        return STIFFNESS[soil.law.plastic]
    axes = np.count_nonzero(body.driven[:3]) + body.driven[3:].any() + any(control.loads for control in body.stages)
    if axes > 1 and friction_of(described) > 0.0 and soil.grid.collapsed.any():
        return SHEARED
    return STIFFNESS[False] if rests_on_elastic_soil(body, soil, gravity) else PRESSED


def _on_thin_layer(body, motion, soil):
    """p_f [1/m] of a body at its BodyState above a layer that is thinner than the body is wide, 0 on other soil."""
    if soil.law.parameters is None:
        return 0.0
    place = motion.position + body.outline.vertices @ motion.rotation.T
    width = np.ptp(place, axis=0)[:2][~soil.grid.collapsed[:2]].min(initial=np.inf)
    base, (low, top) = place[:, 2].min(), extent(soil.constants, 2)
    height, young = soil.constants.position[:, 2], soil.law.young
    row = (height < min(base, top)) & (height > min(base, top) - soil.grid.smallest_cell)
    stiff = (height < base) & (young > MUCH_STIFFER * largest(young[row]))
    thickness = base - max(low, maximum((height + soil.constants.half_width[:, 2])[stiff], -np.inf))
    if not 0.0 < thickness < width < np.inf:
        return 0.0
    confined = (soil.law.parameters[:, BULK] + 4.0 / 3.0 * soil.law.parameters[:, SHEAR]) / young
    return THIN * largest(confined[row]) / thickness


def rests(body, soil, radius, gravity):
    """Whether nothing but elastic soil carries the weight of a body with this `radius` of curvature [m]."""
    return np.isfinite(radius) and rests_on_elastic_soil(body, soil, gravity)


def rests_on_elastic_soil(body, soil, gravity):
    """Whether nothing but elastic soil carries the weight of a body, so that its force on the soil is known."""
    return not soil.law.plastic and gravity.any() and (body.free & ~body.driven)[:3][gravity != 0.0].all()
