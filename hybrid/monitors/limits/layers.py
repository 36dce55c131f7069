"""Layers that end between lines of the grid.

A point belongs to the layer of its centre, so that such a layer is thicker or thinner by up to half a point; and the cell
that it shares with its neighbour strains as one, with the mean of both stiffnesses where soil in series has the mean of
both compliances:

    1/M of a row of cells    exact Σ f_i/M_i, modelled 1/Σ w_i M_i      f: shares of its height, w: of its points

Likewise a cell is sheared as one, with the mean of both strengths, where soil fails along the weaker one. Slab of clay of
60 kPa and 2 m, gravity inclined by 20°, with a seam of 6 kPa that fills half a cell, or a whole one between two rows: stands
under all of gravity, where the seam gives way at 0.66 and 0.72 of it; in cells of half the size at 0.69 and 0.75. A
body that slides on such a layer at the surface meets its own strength (3.80 of 3.80 kN on half a cell of 2 kPa).

Oedometer of E = 40, 10, 1, 40 MPa with ends at -1.1 and -1.5 m, ν = 0.3, cells of 0.25 m: settles 3.21 of 4.03 mm; a seam
of 1 MPa from -1.1 to -1.3 m in 40 MPa 0.60 of 2.0 mm. On lines of the grid all are exact.
"""

import numpy as np

from hybrid.laws.hencky import BULK, SHEAR
from hybrid.runtime.comm import total
from hybrid.scene.defaults import STANDARD_GRAVITY
from hybrid.scene.soil import span
from hybrid.soil.points import extent

EXCESS = 0.1        # of the settlement of the whole soil, or of the thickness of a layer
ON_LINE = 1e-6      # of a cell
FRICTION, STRENGTH = 2, 4   # columns of a law's parameters, as in `hybrid.laws.cone`
LARGEST = 99.0      # ratio of strengths that is reported
TINY = 1e-3         # [Pa] of a strength that is one
FINEST = 8          # times as many cells as given, among which a size is looked for


def off_lines(scene, model):
    """Layers whose ends between lines of the grid make the soil too stiff or too soft, or them too strong, too thick or too
    thin, by EXCESS."""
    soil, layers = model.soil, scene.soil.layers
    if soil.held or not layers or soil.grid.collapsed[2] or soil.law.parameters is None:
        return
    lines, (floor, top) = soil.grid.lines[2], extent(soil.constants, 2)
    ends = [span(layer, scene.soil, scene.grid) for layer in layers]
    off = sorted({end for pair in ends for end in pair if _off(lines, end, top)}, reverse=True)
    if not off:
        return
    K, G = soil.law.parameters[:, BULK], soil.law.parameters[:, SHEAR]
    modulus, present = _means(soil, lines, ends, K + 4 * G / 3)
    exact, modelled = _compliance(lines, top, ends, modulus, present)
    messages = []
    if abs(modelled / exact - 1.0) > EXCESS:
        messages.append("cells take the mean stiffness of the layers that share them, and under a load the soil settles by "
                        f"{modelled / exact:.2g} times what it should, limit {EXCESS:.0%}")
    for layer, (_, upper), least in zip(layers, ends, _strengths(soil, lines, top, ends)):
        ratio = min(least, LARGEST)
        if ratio > 1.0 + EXCESS and upper < top - ON_LINE * np.diff(lines).min():
            messages.append(f"cells are sheared as one, and sliding along {layer.name} meets {ratio:.2g} times its "
                            f"strength, limit {EXCESS:.0%}")
    for layer, (bottom, upper), points in zip(layers, ends, present):
        thick = float(points / np.maximum(present.sum(axis=0), 1) @ np.diff(lines))
        given = min(upper, top) - max(bottom, floor)
        if abs(thick / given - 1.0) > EXCESS:
            messages.append(f"the points of {layer.name} are {thick:.3g} m thick, {given:.3g} m given, limit {EXCESS:.0%}")
    if messages:
        yield (f"soil.layer: ends at z = {' and '.join(f'{end:g}' for end in off)} m, between lines of the grid: "
               f"{'; '.join(messages)}. {_remedy(scene, ends, top)}")


def _off(lines, end, top):
    """Whether an end [m] inside the soil is between lines of the grid."""
    cell = np.diff(lines).min()
    return lines[0] < end < top - ON_LINE * cell and np.abs(lines - end).min() > ON_LINE * cell


def _strengths(soil, lines, top, ends):
    """[-] of each layer, the least strength of a row of cells that it is in over its own there, under the weight of as
    much of its own soil as there is above; 0 of a layer without points."""
    parameters, points = soil.law.parameters, soil.constants
    if parameters.shape[1] <= STRENGTH:     # an elastic law
        return [0.0] * len(ends)
    weight = STANDARD_GRAVITY * points.mass / points.volume * (top - points.position[:, 2])
    strength, present = _means(soil, lines, ends, parameters[:, STRENGTH] + parameters[:, FRICTION] * weight)
    row = np.einsum("lr,lr->r", strength, present) / np.maximum(present.sum(axis=0), 1)
    return [float(np.min((row / np.maximum(own, TINY))[there > 0], initial=np.inf)) if there.any() else 0.0
            for own, there in zip(strength[:-1], present[:-1])]


def _means(soil, lines, ends, values):
    """(Mean of `values` (n,), number of points) of each layer, and last of soil in none, in each row of cells: two arrays (L
    + 1, rows)."""
    height = soil.constants.position[:, 2]
    owner = np.full(len(height), len(ends))
    for i, (bottom, upper) in reversed(list(enumerate(ends))):
        owner[(height >= bottom) & (height < upper)] = i
    row, shape = np.clip(np.searchsorted(lines, height) - 1, 0, len(lines) - 2), (len(ends) + 1, len(lines) - 1)
    flat = owner * shape[1] + row
    present, summed = (total(np.bincount(flat, weights, shape[0] * shape[1]).reshape(1, *shape))
                       for weights in (None, values))
    return summed / np.maximum(present, 1), present


def _compliance(lines, top, ends, modulus, present):
    """(Exact, modelled) settlement [m/Pa] of the soil under a vertical stress."""
    exact = modelled = 0.0
    for r in np.flatnonzero(present.sum(axis=0) > 0):
        low, high = lines[r], min(lines[r + 1], top)
        modelled += (high - low) * present[:, r].sum() / (present[:, r] @ modulus[:, r])
        left = high - low
        for i, (bottom, upper) in enumerate(ends):
            part = max(0.0, min(high, upper) - max(low, bottom))
            exact, left = exact + part / _nearest(modulus[i], present[i], r) if part else exact, left - part
        exact += max(left, 0.0) / _nearest(modulus[-1], present[-1], r) if left > ON_LINE * (high - low) else 0.0
    return exact, modelled


def _nearest(modulus, present, row):
    """Modulus of a layer in the row nearest to `row` that has points of it."""
    rows = np.flatnonzero(present)
    return modulus[rows[np.argmin(np.abs(rows - row))]] if len(rows) else np.inf


def _remedy(scene, ends, top):
    axis = scene.grid.z
    inside = [end for pair in ends for end in pair if axis.start < end < top]
    if axis.nodes is None and axis.fine is None and not axis.moves:
        first = round((axis.end - axis.start) / axis.size)
        for n in range(first, FINEST * first + 1):
            size = (axis.end - axis.start) / n
            if all(abs((end - axis.start) / size - round((end - axis.start) / size)) < 1e-4 for end in [*inside, top]):
                return f"Set grid.z.size = {size:.4g}, or end the layers on lines"
    return "End the layers on lines of the grid, or choose lines that lie there (grid.z.nodes, grid.z.size)"


LIMITS = (off_lines,)
