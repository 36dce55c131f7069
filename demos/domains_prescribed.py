"""Domains of points under prescribed motions, by each rule of demos/domains.py, and their picture.

A block of 16 x 16 cells of 0.1 m, 4 points a cell, moves homogeneously through the grid, at 5 places of it:

    volume         sum of the domains over the volume of the soil, less 1
    gap, overlap   share of the soil that no domain covers, and that more than one covers
    force          of a uniform pressure on the nodes inside, where it should vanish; root mean square over pressure x face
"""

from types import SimpleNamespace

import numpy as np

from hybrid.grid.axes import FACES, make_grid
from hybrid.grid.colouring import make_slabs
from hybrid.setup.lattice import Lattice
from hybrid.soil.basis import evaluate_basis
from hybrid.soil.domains import updated_half
from hybrid.soil.forces import internal_force
from hybrid.soil.points import lines_of_points

RULES = ("moments", "none", "mpm")
SIZE, CELLS = 0.1, 16


def stretched(factor):
    return np.diag([factor, 1.0, 1.0])


def sheared(gamma):
    F = np.eye(3)
    F[0, 2] = gamma
    return F


def turned(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


MOTIONS = {  # deformation gradient at a share s of the way
    "stretched to 1.5": lambda s: stretched(1 + 0.5 * s),
    "squeezed to 0.5": lambda s: stretched(1 - 0.5 * s),
    "sheared to 1": lambda s: sheared(s),
    "squeezed to 0.8, sheared to 1": lambda s: sheared(s) @ stretched(0.8),
    "turned to 90 deg": lambda s: turned(90 * s),
    "stretched to 1.25, turned to 90 deg": lambda s: turned(90 * s) @ stretched(1.25),
    "turned to 90 deg, stretched to 1.5": lambda s: stretched(1 + 0.5 * s) @ turned(90),
    "turned to 360 deg": lambda s: turned(360 * s)}
WAY = np.linspace(0.1, 1.0, 10)


def block():
    """Grid of 40 x 40 cells and the points of the block in its middle."""
    nodes = np.linspace(-20 * SIZE, 20 * SIZE, 41)
    ends = (nodes[0], nodes[-1])
    grid = make_grid((nodes, [0.0], nodes), np.array([ends, (-0.5, 0.5), ends]), dict.fromkeys(FACES, "free"))
    edge = CELLS / 2 * SIZE
    lattice = Lattice(*lines_of_points(grid, (-edge, -0.5, -edge), (edge, 0.5, edge), (2, 1, 2)))
    return grid, lattice.points(lattice.chosen(None))


def places(count=5):
    """Where the middle of the block is put, in cells: (count, 3)."""
    shifts = [(0.0, 0.0, 0.0), (0.13, 0.0, 0.37), (0.41, 0.0, 0.22), (0.5, 0.0, 0.5), (0.29, 0.0, 0.81)]
    return SIZE * np.array(shifts[:count])


def moved(rule, F, centre, grid, constants):
    """Positions and half-widths (n, 3) [m] of the block after F about `centre`."""
    position = centre + constants.position @ F.T
    if rule == "mpm":
        return position, np.zeros_like(position)
    return position, updated_half(rule, constants.half_width, np.tile(F, (len(constants), 1, 1)), position, grid.axes)


def inside(place, F, centre, margin):
    """(n,) bool, places (n, 3) of the deformed block at least `margin` [m] from its faces."""
    back = np.linalg.inv(F)
    start, width = (place - centre) @ back.T, np.linalg.norm(back, axis=1)
    return np.all(np.abs(start[:, [0, 2]]) <= CELLS / 2 * SIZE - margin * width[[0, 2]], axis=1)


def covered(position, half, F, centre, per_edge=60):
    """Shares of the soil, a cell from its faces, that no domain covers and that more than one covers."""
    a = (np.arange(per_edge) + 0.5) / per_edge * CELLS * SIZE - CELLS / 2 * SIZE
    start = np.stack([*(g.ravel() for g in np.meshgrid(a, [0.0], a, indexing="ij"))], axis=1)
    place = centre + start @ F.T
    place = place[inside(place, F, centre, SIZE)]
    count = np.zeros(len(place), int)
    for p, l in zip(position, half):
        count += (np.abs(place[:, 0] - p[0]) < l[0]) & (np.abs(place[:, 2] - p[2]) < l[2])
    return np.mean(count == 0), np.mean(count > 1)


def force_error(position, half, F, centre, grid, constants):
    """Forces (m, 3) of a uniform unit pressure on the nodes that only the inside of the block reaches, over pressure
    times the face of a cell."""
    basis = evaluate_basis(position, half, grid.axes)
    one = np.tile(np.eye(3), (len(constants), 1, 1))
    force = internal_force(basis, make_slabs(basis.first, grid.shape), grid.shape, SimpleNamespace(inverse=one), one,
                           np.linalg.det(F) * constants.volume)
    nodes = np.stack([g.ravel() for g in np.meshgrid(*grid.axes, indexing="ij")], axis=1)
    return force[inside(nodes, F, centre, 2 * SIZE)] / SIZE


def prescribed(rule, motion, way=WAY, count=5):
    """Worst on the `way` of a motion: volume of the domains over that of the soil less 1, gap, overlap, and the root
    mean square over nodes and `count` places of the force's error."""
    grid, constants = block()
    worst = np.zeros(4)
    for share in way:
        F, squares = motion(share), []
        for centre in places(count):
            position, half = moved(rule, F, centre, grid, constants)
            squares.append(np.sum(force_error(position, half, F, centre, grid, constants) ** 2, axis=1))
        area = np.prod(2 * half[:, [0, 2]], axis=1).sum() / (constants.volume.sum() * np.linalg.det(F))
        found = area - 1, *covered(position, half, F, centre), np.sqrt(np.concatenate(squares).mean())
        worst = np.where(np.abs(found) > np.abs(worst), found, worst)
    return worst


def draw(folder):
    """Domains after four motions (rows: moments, none) and the errors of the force on the way, into `folder`/domains.png."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import PatchCollection
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

    grid, constants = block()
    motions = tuple(list(MOTIONS)[i] for i in (0, 3, 4, 6))
    figure = Figure(figsize=(12, 9), layout="constrained")
    FigureCanvasAgg(figure)
    plots = figure.subplots(3, 4)
    for row, rule in zip(plots, RULES[:2]):
        for plot, name in zip(row, motions):
            share = 0.4 if name == "turned to 90 deg" else 1.0
            position, half = moved(rule, MOTIONS[name](share), places()[1], grid, constants)
            near = np.all(np.abs(position[:, [0, 2]]) < 3 * SIZE, axis=1)
            plot.add_collection(PatchCollection(
                [Rectangle((p - l)[[0, 2]], *(2 * l[[0, 2]])) for p, l in zip(position[near], half[near])],
                facecolor="tab:blue", edgecolor="black", alpha=0.35))
            plot.plot(*position[near][:, [0, 2]].T, "k.", markersize=3)
            plot.set(xlim=(-0.2, 0.2), ylim=(-0.2, 0.2), aspect="equal")
            plot.set_title(f"{rule}: {name if share == 1.0 else 'turned to 36 deg'}", fontsize=8)
            plot.set_xticks(np.arange(-0.2, 0.21, SIZE), [])
            plot.set_yticks(np.arange(-0.2, 0.21, SIZE), [])
            plot.grid(True)
    for plot, name in zip(plots[2], motions):
        for rule in RULES:
            errors = [prescribed(rule, MOTIONS[name], [share], 3)[3] for share in WAY]
            plot.semilogy(WAY, np.maximum(errors, 1e-5), "o-", markersize=3, label=rule)
        plot.set_title(f"error of the force\n{name}", fontsize=8)
    plots[2, 0].legend(fontsize=7)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "domains.png", dpi=100)
