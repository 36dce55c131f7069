"""The grid of a scene: keys that exclude, need or limit one another, as faults with value, limit and remedy."""

from math import floor

from hybrid.scene.grid import ROUNDED, cells_between
from hybrid.scene.table import need, shown


def grid_faults(scene):
    """Texts of what does not fit together in the grid of a Scene whose values have their declared types and ranges."""
    for name in "xyz":
        yield from _axis(f"grid.{name}", getattr(scene.grid, name))
    collapsed = [name for name in "xyz" if getattr(scene.grid, name).collapsed]
    yield from need(len(collapsed) < 3, "grid", ", ".join(collapsed) + " collapsed",
                    "one axis at least uncollapsed", "set collapsed = false where the soil deforms")
    yield from _moving_grid(scene)
    yield from _ends_of_soil(scene)


def _ends_of_soil(scene):
    """Faults of an interval `fine` in which no line lies at an end of the soil, because it is no whole number of cells."""
    soil = scene.soil
    ends = [("z", "soil.top", soil.top)]
    for corner in ("lower", "upper"):
        given = enumerate(zip("xyz", getattr(soil, corner) or ()))
        ends += [(name, f"soil.{corner}[{i}]", x) for i, (name, x) in given
                 if (name, corner) != ("z", "upper") or soil.top is None]     # soil.top takes its place
    for name, key, x in ends:
        axis = getattr(scene.grid, name)
        if axis.fine is None or x is None or axis.collapsed or None in (axis.start, axis.end, axis.size) or axis.size <= 0:
            continue
        low, high = axis.fine
        if not axis.start <= low < x < high <= axis.end:
            continue
        cells = cells_between(low, high, axis.size)
        place = (x - low) / (high - low) * cells
        below = min(cells_between(low, x, axis.size), floor((x - axis.start) / axis.size + ROUNDED))
        above = min(cells_between(x, high, axis.size), floor((axis.end - x) / axis.size + ROUNDED))
        fine = x - below * axis.size, x + above * axis.size
        yield from need(abs(place - round(place)) < ROUNDED, key, x,
                        f"on a line of the grid, because points fill whole cells, and grid.{name}.fine = {shown(axis.fine)} "
                        f"has {cells} cells of {(high - low) / cells:.4g} m without one there",
                        f"use grid.{name}.fine = {shown(tuple(round(end, 9) for end in fine))}")


def _axis(key, axis):
    kinds = [name for name, given in (("nodes", axis.nodes is not None), ("fine", axis.fine is not None),
                                      ("collapsed", axis.collapsed)) if given]
    if kinds or not axis.moves:
        kinds += [name for name in ("around", "window") if getattr(axis, name) is not None][:1]
    if len(kinds) > 1:
        yield f"{key}: {' and '.join(kinds)} exclude each other; keep one of them"
        return
    if axis.nodes is not None:
        yield from _nodes(key, axis)
        return
    absent = [name for name in ("start", "end", "size") if getattr(axis, name) is None]
    if axis.collapsed and "size" in absent:
        absent.remove("size")
    if absent:
        yield f"{key}: missing {', '.join(absent)}; give start, end and size [m], or nodes"
        return
    yield from need(axis.start < axis.end, f"{key}.end", axis.end, f"above start = {shown(axis.start)}",
                    "swap the two or widen the grid")
    if not axis.collapsed and axis.start < axis.end:
        yield from _cells(key, axis)


def _moving_grid(scene):
    """Faults of a grid that moves with a body."""
    grid, soil = scene.grid, scene.soil
    names = [body.name for body in scene.bodies]
    if not grid.moves:
        yield from need(grid.follow is None, "grid.follow", grid.follow, "left out",
                        "or give an axis `around` or `window` [m], which lets it move with a body")
        return
    yield from need(names and grid.follow in (None, *names), "grid.follow", grid.follow,
                    f"a body of the scene: {', '.join(names) or 'it has none'}",
                    "name one, or leave out the axes' `around` and `window`")
    yield from need(not soil.held, "soil.held", soil.held, "false where the grid moves with a body",
                    "held soil has no unknowns to save: leave `around` and `window` out")
    yield from need(soil.material.law != "user", "soil.material.law", soil.material.law,
                    "one of the package's own where the grid moves with a body, as points come and go",
                    "leave `around` and `window` out")
    for name in "xyz":
        axis, key = getattr(grid, name), f"grid.{name}"
        if not axis.moves or axis.start is None or axis.end is None or not (axis.size or 0) > 0:
            continue
        for margin, least, reason in (("around", axis.size, "the body would touch cells that are not the smallest"),
                                      ("window", 0.0, "they are measured outwards from the body's bounding box")):
            ends = getattr(axis, margin)
            yield from need(ends is None or min(ends) >= least, f"{key}.{margin}", ends,
                            f"two distances of at least {shown(least)}", reason)
        yield from need(axis.window is None or name != "z", f"{key}.window", axis.window, "left out",
                        "soil below a body carries it: give around, with which cells grow with the distance")
        yield from need(axis.window is None or soil.geostatic, f"{key}.window", axis.window,
                        "left out without geostatic stress, in which the soil that enters is at rest",
                        "or set soil.geostatic = true")
        if not 0 < axis.doublings < 9:     # out of its range: a fault of its own
            continue
        cells, block = (axis.end - axis.start) / axis.size, 2**axis.doublings
        fits = abs(cells / block - round(cells / block)) < ROUNDED
        near = int(cells // block), int(cells // block) + 1
        yield from need(fits, f"{key}.end", axis.end, f"start = {shown(axis.start)} plus a multiple of size times "
                        f"2^doublings = {shown(axis.size * block)}",
                        f"use {' or '.join(shown(axis.start + axis.size * block * n) for n in near if n)} m")


def _nodes(key, axis):
    rising = len(axis.nodes) >= 2 and all(a < b for a, b in zip(axis.nodes, axis.nodes[1:]))
    yield from need(rising, f"{key}.nodes", axis.nodes, "two or more increasing coordinates", "sort them")
    if rising:
        for name, node in (("start", axis.nodes[0]), ("end", axis.nodes[-1])):
            yield from need(getattr(axis, name) == node, f"{key}.{name}", getattr(axis, name),
                            f"that of nodes, {shown(node)}", "leave it out: nodes give the extent")


def _cells(key, axis):
    length = axis.end - axis.start
    yield from need(axis.size <= length * (1 + ROUNDED), f"{key}.size", axis.size,
                    f"at most end - start = {shown(length)} m", "choose a smaller cell size")
    if axis.fine is not None:
        low, high = axis.fine
        yield from need(axis.start <= low < high <= axis.end, f"{key}.fine", axis.fine,
                        f"(low, high) inside [start, end] = {shown((axis.start, axis.end))}",
                        "narrow it or widen the grid")
