"""Strength of the interface between clay and a body: adhesion, and tension until it breaks away.

    shear  |t| <= min(μ p, α s_u a)           s_u of the touching soil, softened as its law softens
    normal  p >= -σ_t a                        of a bonded contact point; p > 0 of any other one

| symbol | meaning                                                    | in the code                    | unit |
|--------|------------------------------------------------------------|--------------------------------|------|
| α      | adhesion factor                                            | Interface.adhesion             | -    |
| s_u    | undrained shear strength of clay, k/ξ                      | Cone.shear_strength            | Pa   |
| σ_t    | tension at which the interface opens, inf: never           | Interface.tension              | Pa   |
| a      | area of the contact point projected along N, ε_N/(p_f E)   | `place_limits`                 | m²   |

A contact point is bonded from the step in which it first touches, or from the start of the run if it begins within
`ATTACHED` of the surface; then its spring pulls too, about the gap g_0 that it had there. A point whose tension reaches
σ_t a carries that to the end of the step, which keeps the residual continuous, and is open from then on: it presses and
shears as soil without a bond does, and is followed wherever it goes, so that it does not bond again.

A point without a bond can have no shear where it has no pressure: there the limit is the smaller one of α s_u a and
RAMP p, so that the force does not jump where a point opens.

Equations: FORMULATION (40a).
"""

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from hybrid.body.closest import closest
from hybrid.body.facet_tree import NO_SIDE
from hybrid.body.surface import ContactSurface
from hybrid.contact.closest_points import nearest
from hybrid.contact.cover import Cover
from hybrid.contact.interface_shares import BEARERS, carried_by_each
from hybrid.contact.search import distances
from hybrid.runtime.jit import njit

ATTACHED = 0.1  # half-widths of a domain from the surface, within which a contact point is bonded at the start
ALONG = 0.9     # cosine between the way from the surface to a place before it and the normal there
RAMP = 10.0     # shear over pressure of points without a bond, up to which adhesion is mobilised
EVERYWHERE = np.array([[-np.inf, np.inf]] * 3)


@dataclass(frozen=True)
class Interface:
    """adhesion: α, None where friction alone limits the shear; elsewhere: [Pa] limit of the shear of soil that is no clay,
    inf or, without friction, 0; tension: σ_t [Pa], 0 without a bond, inf for ever; sharp: ContactSurface on whose area they
    act, None for the one in contact: edges that this has rounded off are clay's as well; cover: Cover of that area, None
    where contact points carry whatever they are given; frictional: whether friction limits the shear as well."""

    adhesion: float | None
    tension: float
    sharp: ContactSurface | None = None
    cover: Cover | None = None
    frictional: bool = False
    elsewhere: float = np.inf

    def of_points(self, law, plastic_strain):
        """PointLimits of soil points with a `law` and accumulated plastic strain (n,)."""
        shear = None
        if self.adhesion is not None:
            shear = np.where(law.undrained, self.adhesion * law.shear_strength(plastic_strain), self.elsewhere)
        return PointLimits(shear, self.tension, self.sharp, self.cover, self.frictional)


class PointLimits(NamedTuple):
    """Stresses [Pa] that the interface carries: shear (n,) α s_u of each point of clay, `elsewhere` of others,
    None without adhesion; tension; and the `sharp` surface of Interface, its `cover`, and whether it is `frictional`."""

    shear: np.ndarray | None
    tension: float
    sharp: ContactSurface | None = None
    cover: Cover | None = None
    frictional: bool = False


class PlaceLimits(NamedTuple):
    """Forces [N] that contact points carry, frozen in a step; empty arrays where there is no such limit.

    shear: (m,) α s_u a; tension: (m,) σ_t a of bonded points, 0 of others; opened: (m,) bool, broken away
    """

    shear: np.ndarray
    tension: np.ndarray
    opened: np.ndarray

    def select(self, index):
        return PlaceLimits(*(values[index] if len(values) else values for values in self))


NONE = PlaceLimits(np.zeros(0), np.zeros(0), np.zeros(0, bool))


def place_limits(limits, found, area, domains, places, body, surface, extent=EVERYWHERE):
    """(PlaceLimits, function) of contact points `found` {name: (m, ...)}: position, normal, point, place, clearance,
    touching and opened as in ContactPoints and ContactHistory, and rest. limits: PointLimits, None for none; area: (m,)
    [m²]; domains: Domains of the soil's points; places: Places on them; body: BodyState; surface: that the points are in
    contact with; extent: (3, 2) [m] of the soil's grid.

    The function gives the limits of shear (m,) [N] where other points touch, (m,) bool, pressed by forces (m,); None where
    these do not depend on that."""
    if limits is None:
        return NONE, None
    shear, tension, opened = np.zeros(0), np.zeros(0), np.zeros(0, bool)
    found = found | {"pressed": area * np.maximum(found["rest"] - found["clearance"], 0.0)}
    before_body, own = np.ones(len(area), bool), area
    if not places.at_corners:
        found, own, before_body = _before_sharp(found, area, domains, places, body, limits.sharp or surface)
    bonds, layers = limits.tension > 0.0, None
    if limits.cover is not None:
        layers = partial(limits.cover.layers, pose=body.pose, extent=extent)
    found = found | {"area": own}
    carried = carried_by_each(found, before_body & (own > 0.0), domains, places, 1 if bonds else BEARERS, layers)
    if limits.shear is not None:
        shear = _sheared(carried, limits.shear[found["point"]], own)
    if limits.frictional:   # a point that closes takes load off others: it has friction before adhesion is shared anew
        shear = np.where(found["touching"], shear, _sheared(lambda alone: alone, limits.shear[found["point"]], area))
    if bonds:       # a bond holds whatever presses
        opened, bonded = found["opened"], found["touching"] & (own > 0.0)
        bonded[bonded] = on_faces(*(found[name][bonded] for name in ("position", "normal")), body, surface, limits.sharp)
        tension = np.where(bonded & ~opened, limits.tension, 0.0)
        if np.isfinite(limits.tension):
            tension *= carried(own)

    def shared(touching, pressed):
        areas = np.where(touching, area, own)
        now = found | {"touching": touching, "pressed": pressed, "area": areas}
        carried = carried_by_each(now, before_body & (areas > 0.0), domains, places, BEARERS, layers)
        return _sheared(carried, limits.shear[found["point"]], areas)

    return PlaceLimits(shear, tension, opened), None if bonds or places.at_corners or limits.shear is None else shared


def _sheared(carried, shear, area):
    """Limits of shear (m,) [N] by those of the soil's points, (m,) [Pa], which is inf where friction alone limits them: such
    points bear no clay's adhesion, and no other bears theirs."""
    free = np.isinf(shear)
    return np.where(free, np.inf, carried(np.where(free, 0.0, shear) * area))


def on_faces(position, normal, body, surface, sharp):
    """(m,) bool, whether places (m, 3) [m] with normals (m, 3) of the `surface` in contact are closest to what was a face of
    the `sharp` one, None if nothing of it was rounded off.

    Where its edges were (`hybrid.body.rounded`), normals point along the faces, so that a bond would hold soil along them
    too: a smooth strip drawn over elastic soil felt nearly all of what one feels that sticks to it."""
    if sharp is None:
        return np.ones(len(position), bool)
    triangle, *_ = nearest((position - body.position) @ body.rotation, normal @ body.rotation, surface)
    return triangle < len(sharp.triangles)


def _before_sharp(found, area, domains, places, body, sharp):
    """Contact points `found` and their areas with those that do not touch measured from the `sharp` surface of the body, and
    (m,) bool, whether they lie before it as in `lie_before`.

    From half a cell beside an edge on the surface in contact turns away from the soil: by more than TURN in the last
    fifth of a cell. Measured from it, a face that slides bears α s_u on its middle alone.
    """
    y, open_ = (found["position"] - body.position) @ body.rotation, ~found["touching"]
    distance, normal = distances(y, sharp)
    normal = np.where(open_[:, None], normal @ body.rotation.T, found["normal"])
    clearance = np.where(open_, distance, found["clearance"])
    point, place = found["point"], found["place"]
    share = domains.projected_share(places, point, place, normal)
    seen = places.area(place, domains.half[point], domains.volume[point]) * share
    before = lie_before(y, normal @ body.rotation, sharp.tree)
    return found | {"normal": normal, "clearance": clearance}, np.where(open_, seen, area), before


@njit(cache=True)
def shear_limit(p, slope, mu, n, shear, bonded):
    """Largest shear force [N] of contact point n under a pressure p [N], and its derivative by -g [N/m].

    slope: ∂p/∂(-g) [N/m]; mu: inf where friction sets no limit; shear: of PlaceLimits; bonded: whether it may pull.
    """
    limit, change = np.inf, 0.0
    if len(shear) > 0:
        limit = shear[n]
        if not bonded and not RAMP * p > limit:
            limit, change = RAMP * p, RAMP * slope
    if mu < np.inf and not mu * p > limit:
        limit, change = mu * p, mu * slope
    if limit < 0.0:
        return 0.0, 0.0
    return limit, change


@njit(cache=True)
def work_to_break(tension, p, eps_n):
    """Work [J] to a bond's `tension` T [N], and at T to the end of the step, where its spring would have p < -T."""
    return tension * (-p - 0.5 * tension) / eps_n


@njit(cache=True)
def lie_before(y, normal, tree):
    """(m,) bool, whether places y (m, 3) [m] are in a body or lie along the normal (m, 3) of the closest point of its
    surface, and not beside an edge; all in the body frame."""
    before = np.ones(len(y), np.bool_)
    for n in range(len(y)):
        _, _, closest_point, _, gap = closest((y[n, 0], y[n, 1], y[n, 2]), np.inf, tree, NO_SIDE)
        along = 0.0
        for i in range(3):
            along += (y[n, i] - closest_point[i]) * normal[n, i]
        before[n] = gap <= 0.0 or along >= ALONG * gap
    return before
