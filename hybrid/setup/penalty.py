"""Penalty stiffness of the contact of a body with the soil of a scene.

on elastic soil                           p_f = 500 / h, 2000 / h of a body of planes driven into it, 100 / h of one with
                                          friction that shears it in plane strain
on soil that yields                       p_f = 20 / h, 500 / h of a plane base that stages press with less than half of what
                                          the cohesion of the soil bears, and up to that 50 M/(E H) where a layer under it
                                          is thinner than it is wide
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
way there spread the load to the edges. Rough strip on clay a quarter as thick, ν = 0.49, with 4 and 8 cells in it, under a
tenth of what it bears: settlement 17 and 10 % too large with 20/h, 6 and 4 % with 60/h, 0 and 2 % with 200/h, -1 and 1 %
with 500/h, in as many iterations. A layer thicker than the base is wide gives way more than 20/h does by far.
"""

import numpy as np

from hybrid.body.symmetry import copies
from hybrid.laws.hencky import BULK, SHEAR
from hybrid.runtime.comm import largest
from hybrid.setup.foot import standing_stiffness
from hybrid.setup.interface import friction_of
from hybrid.soil.points import extent

STIFFNESS = {False: 500.0, True: 20.0}  # p_f h, by whether the soil yields
THIN = 50.0                         # p_f E H/M on a layer of height H thinner than a base is wide
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
    if soil.law.plastic and np.isinf(radius) and not (soil.held or body.driven[:2].any()):
        stiff = max(stiff, min(_on_thin_layer(body, motion, soil), STIFFNESS[False] / soil.grid.smallest_cell))
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
    place = motion.position + body.outline.vertices @ motion.rotation.T
    height = place[:, 2].min() - extent(soil.constants, 2)[0]
    width = np.ptp(place, axis=0)[:2][~soil.grid.collapsed[:2]].min(initial=np.inf)
    if soil.law.parameters is None or not 0.0 < height < width < np.inf:
        return 0.0
    confined = largest(soil.law.parameters[:, BULK] + 4.0 / 3.0 * soil.law.parameters[:, SHEAR])
    return THIN * confined / (largest(soil.law.young) * height)


def rests(body, soil, radius, gravity):
    """Whether nothing but elastic soil carries the weight of a body with this `radius` of curvature [m]."""
    return np.isfinite(radius) and rests_on_elastic_soil(body, soil, gravity)


def rests_on_elastic_soil(body, soil, gravity):
    """Whether nothing but elastic soil carries the weight of a body, so that its force on the soil is known."""
    return not soil.law.plastic and gravity.any() and (body.free & ~body.driven)[:3][gravity != 0.0].all()
