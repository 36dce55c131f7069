"""Bodies that are moved along the fixed base of the grid.

The lowest row of cells hangs on nodes that do not move. A body that reaches down into it and is moved sideways ploughs
through clay that cannot give way: it is pressed against the fixed nodes, or squeezed out under the rounded edge of the
foot, and the force grows with the way. Of a wall in plane strain that is pushed 0.0135 H into clay of 20 cells h in its
height, over the exact force 2 s_u H of a smooth wall, and that of one with half the clay's strength on it:

| foot above the base | -0.8 h | 0    | 0.2 h | 0.4 h | 0.6 h | h    |
|---------------------|--------|------|-------|-------|-------|------|
| smooth              |        | 1.47 | 1.08  | 1.02  | 1.01  | 1.00 |
| half the strength   | to 2.8 | 1.47 | 1.10  | 1.02  | 0.99  | 0.99 |
"""

from hybrid.monitors.limits.contact import initial_vertices, way_along

CLEAR = 0.5     # cells between a body and the fixed base: from there on the force is right to 2 %


def body_on_fixed_base(scene, model):
    """Bodies that can move sideways with their foot in the lowest half of a row of cells of soil that yields, over a
    fixed base."""
    grid, soil = model.soil.grid, model.soil
    if soil.held or not soil.law.plastic or scene.grid.faces.z_min != "fixed":
        return
    base, cell = grid.extent[2, 0], grid.smallest_cell
    for described, body in zip(scene.bodies, model.bodies):
        foot = initial_vertices(described, body)[:, 2].min() - base
        if foot >= CLEAR * cell * (1 - 1e-6) or not _sideways(scene, described, body, grid):
            continue
        where = f"{-foot:.2g} m below" if foot < -1e-6 * cell else f"{foot:.2g} m above" if foot > 1e-6 * cell else "on"
        yield (f"{body.name} can move sideways with its foot {where} the fixed base of the grid, limit {CLEAR:g} cells, "
               f"{CLEAR * cell:.2g} m, above it: nodes there do not move, so that the soil of the lowest row cannot "
               "give way, and the force grows with the way (a wall pushed into clay: 47 % too large with its foot on the "
               f"base, after 0.014 of its height; 1 % with the foot a cell above). End the body {cell:.2g} m above the "
               'base, one cell, or set grid.faces = { z_min = "roller" } where the base is smooth')


def _sideways(scene, described, body, grid):
    """Whether a body is driven along x or y, or free to follow forces there."""
    return any(not grid.collapsed[axis] and (body.free[axis] or way_along(scene, described, name) != 0.0)
               for axis, name in enumerate("xy"))


LIMITS = (body_on_fixed_base,)
