"""Soil that has opened closes before it carries pressure again: FORMULATION (17a), (17b).

The return to the apex of a cone makes tensile volume strain plastic. Without a memory of it, a point that is pressed
again resists at the volume that it has then, and sand that falls, splashes or is shaken stays swollen. So a point keeps
the volume strain o by which it has opened, and a trial strain ε meets the law as

    ε + o/3 1      where that carries pressure: closed, o <- 0
    ε + c/3 1      else, c = min(o, <-tr ε>), without dilation: o <- o - c + (volume strain returned to the apex)

Soil that is sheared while it is open does not dilate. The tangent C becomes C (I - 1⊗1/3) where tr ε <= 0. A cohesive
point unloads from its tensile strength before it closes, so that a crack gains no energy. After Tampubolon et al., ACM
Trans. Graph. 36 (2017) 105.

The grid gives all points in a cell about the same volume strain: the first one to close stops them, and the others
would stay without stress. So they share what is open in the cell in the time in which soil falls by its height,
√(2 h/g). In longer steps, in which no fall is resolved, they do not, nor in cells in which soil touches a body: what is
open behind it would take the pressure before it.

Only with inertia: without it nothing resists soil that closes, and its displacement is not determined.
"""

from dataclasses import replace

import numpy as np

from hybrid.grid.axes import cell_numbers


def respond(law, strain, points, opens=True):
    """(Response of a law, volume strain (n,) by which points are open after it, that by which they have closed); None for
    the last two where no point is open or was.

    strain: (n, 3) trial principal strains, changed in place where points close; points: Points at the start of the step;
    opens: whether soil remembers that it opens, as it does with inertia.
    """
    plastic_strain, opened = points.plastic_strain, points.opened
    if opened is None or not opens:
        response = law.respond(strain, plastic_strain)
        return response, _any(response.opened) if opens else opened, None
    trial, trace, closed = strain.copy(), strain[:, 0] + strain[:, 1] + strain[:, 2], opened.copy()
    strain += opened[:, None] / 3
    response = law.respond(strain, plastic_strain)
    some = np.flatnonzero(opened)
    some = some[response.stress[some].sum(axis=1) >= 0.0]
    if len(some):
        closed[some] = np.minimum(np.maximum(-trace[some], 0.0), opened[some])
        strain[some] = trial[some] + closed[some, None] / 3
        still = law.without_dilation(some).respond(strain[some], plastic_strain[some])
        flat = trace[some] <= 0.0
        still.tangent[flat] -= still.tangent[flat].mean(axis=2, keepdims=True)
        for name in ("stress", "elastic", "tangent", "opened"):
            getattr(response, name)[some] = getattr(still, name)
    return response, _any(opened - closed + response.opened), closed


def shared(points, soil, gravity, dt, touching):
    """Points of a Soil that share what is open in their cell, as far as they do in a time `dt` [s]; gravity: its magnitude
    [m/s²]; touching: indices of points that touch bodies, whose cells do not share.

    The volume strain v of a point is o where it is open, else that of b_e where it is pressed and has an apex to open at;
    v goes to its mean over the cell, where a cell has points of both kinds. So the volume is kept, and a pressed point
    gives up pressure.
    """
    volume, share = soil.constants.volume, dt * np.sqrt(gravity / (2 * soil.grid.smallest_cell))
    if points.opened is None or share > 1.0:
        return points
    is_open, elastic = points.opened > 0.0, 0.5 * np.log(np.linalg.det(points.b_elastic))
    is_open, pressed = points.active & is_open, points.active & ~is_open & (elastic < 0.0) & soil.law.opens
    cell, shape = cell_numbers(points.position, soil.grid)
    number = int(np.prod(shape))
    found = np.where(is_open, points.opened, np.where(pressed, elastic, 0.0))
    whole, total, one, other = (np.bincount(cell, values, number) for values in (
        volume * (is_open | pressed), volume * found, is_open, pressed))
    apart = np.zeros(number, bool)
    apart[cell[touching]] = True
    both = ((one > 0.0) & (other > 0.0) & ~apart)[cell] & (is_open | pressed)
    mean = np.divide(total, whole, out=np.zeros(number), where=whole > 0.0)[cell]
    new = np.where(both, found + share * (mean - found), found)
    gain = np.where(both, np.minimum(new, 0.0) - np.minimum(found, 0.0), 0.0)
    return replace(points, b_elastic=points.b_elastic * np.exp(2 / 3 * gain)[:, None, None],
                   opened=np.where(both, np.maximum(new, 0.0), points.opened))


def _any(opened):
    return opened if opened is not None and opened.any() else None
