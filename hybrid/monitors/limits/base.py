"""Bodies that are moved along the fixed base of the grid or a harder layer, or that press a thin layer on one.

The lowest row of cells hangs on nodes that do not move. A body that reaches down into it and is moved sideways ploughs
through clay that cannot give way: it is pressed against these nodes, or squeezed out under the rounded edge of the
foot, and the force grows with the distance moved. Of a wall in plane strain that is pushed 0.0135 H into clay of 20
cells h in its height, over the exact force 2 s_u H of a smooth wall, and that of one with half the clay's strength on
it; and on rock of 1 GPa, which does not yield, and clay of 10, 4, 2 times the strength instead of the base:

| foot above the base | -0.8 h | 0    | 0.2 h | 0.3 h | 0.4 h | 0.5 h | 0.6 h | h    |
|---------------------|--------|------|-------|-------|-------|-------|-------|------|
| smooth              |        | 1.47 | 1.08  |       | 1.02  | 1.00  | 1.01  | 1.00 |
| half the strength   | to 2.8 | 1.47 | 1.10  |       | 1.02  |       | 0.99  | 0.99 |
| rock                |        | 1.55 |       | 1.13  |       | 1.05  |       | 1.03 |
| 10, 4, 2 s_u        |        | 1.51, 1.28, 1.18 | | |    | 1.03, 1.02 |  |      |

In c-φ soil (25°, 8 kPa) on such rock 4.0, 1.7, 1.2, 1.1 times Rankine's force with the foot 0, 0.2, 0.5, 1 cells above it,
after 0.02 of its height. Into sand, φ = ψ = 25°, 8 cells, with the foot on the base, 1.4, 3.1, 6.1 times Coulomb's upright
and with backs at ±15° after 0.004 of the height, 2.4, 4.0, 9.5 after 0.016. A pipe of 8 cells on rock, pushed through clay:
5 times.

A strip that presses a thin layer of clay on a harder one squeezes it out sideways: rough, B/4 over clay of four times the
strength, 18, 8.5, 5 % over 6.43 s_u (Meyerhof & Chaplin 1953) with 2, 4, 8 cells in the layer, 1 + 0.36/n. Pressed by a
fifth of the layer, B/5 over clay of five times the strength, 57, 20, 14 % over that of what is left of it: 1 + (0.36 +
3 z/H)/n.

In soil with friction the pressure grows from the edges inwards as exp(tan φ x/(0.425 h)) in a layer of thickness h, and the
layer is as if it were 1.1 cells thinner. Load of a rough strip B on rock, ψ = 0, pressed by 0.04 h, 2, 4, 8 cells in the
layer, over the value that they tend to (φ = 20°: a value by hand), and the law, (1 - 1.1/n)^-s with s = 1.2 (m e^m/(e^m
- 1) - 1), m = (tan φ + μ) B/(1.7 h) and no friction μ of the body beyond tan φ:

| φ, B/h  | found            | law              |
|---------|------------------|------------------|
| 10°, 3  | 1.73, 1.19, 1.06 | 1.39, 1.14, 1.06 |
| 10°, 4  | 2.00, 1.23, 1.09 | 1.57, 1.20, 1.09 |
| 10°, 6  | 2.46, 1.40, 1.15 | 2.05, 1.33, 1.14 |
| 20°, 3  | 2.2, 1.4, 1.13   | 2.1, 1.35, 1.15  |
| 20°, 4  | 2.59, 1.62, 1.23 | 2.8, 1.52, 1.21  |
| μ = 0   | 1.6, 1.3, 1.1    | 1.6, 1.21, 1.09  |
"""

import numpy as np

from hybrid.body.guides import forces_of
from hybrid.body.paths import travel_along
from hybrid.monitors.limits.cell_size import EXCESS, smaller_cells
from hybrid.monitors.limits.loading import loadings
from hybrid.monitors.limits.materials import CLAY, SAND, material_at
from hybrid.monitors.limits.shape import narrowest
from hybrid.monitors.limits.start import initial_vertices
from hybrid.runtime.comm import anywhere
from hybrid.scene.soil import ends, span

CLEAR = 0.5     # cells between a body and the fixed base: from there on the force is right to 2 %
HARDER = 4.0    # times the strength of the soil above, from which on a layer is nearly as good as fixed
SQUEEZED = 0.36  # over the cells in a layer of clay: excess of the load that presses it on a harder one
PRESSED, MOST = 3.0, 0.2    # the same for each layer that it is pressed by, up to a share of it
ON_IT = 0.1     # cells: a body nearer to a harder layer stands on it
SHEARED, STEEP, OF_SLOPE = 1.1, 0.85, 1.2   # the same with friction: cells that it is thinner by; of m and s above
LEFT, GROSS = 0.05, 2.0       # of the layer, at least; of a larger excess nothing more is said
THIN = 0.5      # widths of a body: of a thicker layer the shear along the harder one does not decide
AHEAD = 2.0     # cells from a body to the soil that it pushes


def body_on_base(scene, model):
    """Bodies that can move sideways with their foot in the lowest half of a row of cells of soil that yields, over a
    fixed base or a harder layer."""
    soil = model.soil
    if soil.held or not soil.law.plastic:
        return
    bases, cell = list(hard_bases(scene, model)), soil.grid.smallest_cell
    for described, body in zip(scene.bodies, model.bodies):
        place = initial_vertices(described, body)
        for height, name, least in bases:
            foot = place[:, 2].min() - height
            near = least * cell <= foot < CLEAR * cell * (1 - 1e-6)
            if near and _pushes(scene, described, body, place, soil, height):
                yield _text(body.name, name, foot, cell)
                break


def hard_bases(scene, model):
    """(height [m], name, cells above it from which on a foot counts) of the fixed base and of tops of harder layers."""
    grid, soil = model.soil.grid, scene.soil
    if scene.grid.faces.z_min == "fixed":
        yield grid.extent[2, 0], "fixed base of the grid", -float("inf")
    spans = {layer.name: span(layer, soil, scene.grid) for layer in soil.layers}
    for height in sorted({end for pair in spans.values() for end in pair}):
        below, above = (material_at(scene, model.soil, height + side * 1e-6 * grid.smallest_cell) for side in (-1, 1))
        tops = [ends(soil, scene.grid)[1], *(top for bottom, top in spans.values() if bottom <= height < top)]
        if _harder(below, above, min(tops) - height):
            name = next((name for name, (bottom, top) in spans.items() if bottom < height <= top), "soil")
            yield height, f"harder layer {name}", -CLEAR


def _harder(below, above, depth):
    """Whether one Material is nearly as good as fixed beside the other, whose top is a `depth` [m] above: it does not yield,
    or has HARDER times the strength without pressure at no less friction."""
    if "hencky" in (below.law, above.law):
        return above.law != "hencky"
    if (below.law == CLAY) != (above.law == CLAY):
        return False        # one of them has its strength by the pressure
    if below.law == CLAY:
        return below.strength >= HARDER * (above.strength + (above.strength_gradient or 0.0) * depth)
    stronger = bool(above.cohesion) and below.cohesion >= HARDER * above.cohesion
    return stronger and below.friction_angle >= above.friction_angle


def _text(body, base, foot, cell):
    where = f"{-foot:.2g} m below" if foot < -1e-6 * cell else f"{foot:.2g} m above" if foot > 1e-6 * cell else "on"
    fixed = base.startswith("fixed")
    remedy = f"End the body {cell:.2g} m above the {'base' if fixed else 'layer'}, one cell"
    if fixed:
        remedy += ', or set grid.faces = { z_min = "roller" } where the base is smooth'
    return (f"{body} can move sideways with its foot {where} the {base}, limit {CLEAR:g} cells, {CLEAR * cell:.2g} m, above "
            "it: nodes there hardly move, so that the soil of the lowest row cannot give way, and the force grows with the "
            "distance moved (a wall pushed into clay: 47 % too large with its foot on the base, after 0.014 of its "
            f"height; 3 % with the foot a cell above; into c-φ soil on rock 4 times, into sand 2 to 10 times). {remedy}")


def _pushes(scene, described, body, place, soil, base):
    """Whether a body with vertices at `place` (V, 3) [m] is driven, or free to follow forces, along x or y against soil in
    the row of cells above a `base` [m]: a free one without loads that way only where there is soil on both sides."""
    at, cell = soil.constants.position, soil.grid.smallest_cell
    row = (at[:, 2] > base) & (at[:, 2] < base + cell)
    low, high = place.min(axis=0) - AHEAD * cell, place.max(axis=0) + AHEAD * cell
    near = row & ((at > low) & (at < high))[:, :2].all(axis=1)
    for axis in np.flatnonzero(~soil.grid.collapsed[:2]):
        travel, middle = travel_along(scene, described, "xy"[axis]), 0.5 * (low + high)[axis]
        if not travel and not body.free[axis]:
            continue
        ahead = [anywhere(near & (sign * (at[:, axis] - middle) > 0.0)) for sign in (-1.0, 1.0)]
        loads = any(force[:, axis].any() for force in forces_of(body))
        if ahead[travel > 0.0] if travel else any(ahead) if loads else all(ahead):
            return True
    return False


def squeezed_layer(scene, model):
    """Bodies that press a thin layer on a harder one, with so few cells in it that their load is too high by EXCESS."""
    soil = model.soil
    if soil.held or not soil.law.plastic or soil.grid.collapsed.sum() != 1:
        return
    cell, bases = soil.grid.smallest_cell, {height: name for height, name, _ in hard_bases(scene, model)}
    for body, travel, place, plane, by_force, *_ in loadings(scene, model):
        bottom = place[:, 2].min()
        top = max((height for height in bases if height < bottom - ON_IT * cell), default=None)
        if top is None or not plane or travel[2] >= 0.0:
            continue
        thick, width = bottom - top, narrowest(soil.grid, place, travel)
        material = material_at(scene, soil, bottom - 0.5 * cell)
        if material.law not in (CLAY, *SAND):
            continue
        if material.friction_angle:
            kind, (excess, size) = "soil with friction", _with_friction(material, body.friction, thick, width, cell)
        else:
            kind, number = "clay", SQUEEZED + PRESSED * min((0.0 if by_force else -travel[2]) / thick, MOST)
            excess, size = number * cell / thick, EXCESS / number * thick
        if thick < THIN * width and excess > EXCESS:
            under = f"{'the' if bases[top].startswith('fixed') else 'a'} {bases[top]}"
            more = "more than" if excess > GROSS else "about"
            yield (f"{body.name} presses {thick:.3g} m of {kind}, {thick / cell:.2g} cells of {cell:.3g} m, on {under}: the "
                   f"load that squeezes it out is {more} {min(excess, GROSS):.0%} too high, limit {EXCESS:.0%}. "
                   f"{smaller_cells(size, ' under it')}")


def _with_friction(material, friction, thick, width, cell):
    """(Excess of the load [-], size [m] of cells with EXCESS) of a layer `thick` [m] under a body of a `width` [m]."""
    slope = np.tan(np.radians(material.friction_angle))
    m = 0.5 * (slope + min(friction, slope)) * width / (STEEP * thick)
    power = OF_SLOPE * (m / -np.expm1(-m) - 1.0)
    left = max(1.0 - SHEARED * cell / thick, LEFT)
    return left**-power - 1.0, (1.0 - (1.0 + EXCESS) ** (-1.0 / power)) * thick / SHEARED


LIMITS = (body_on_base, squeezed_layer)
