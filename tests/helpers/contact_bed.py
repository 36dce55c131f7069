"""Surfaces, bodies and a bed of soil points that tests of contact start from."""

from types import SimpleNamespace

import numpy as np

from hybrid.body.attitude import exp_so3
from hybrid.body.surface import build_surface
from hybrid.contact import places as rules
from hybrid.contact import soil_to_body
from hybrid.contact.contact_points import ContactPoints, SoilSurface, find_contact_points
from hybrid.contact.search import Domains, Reach
from hybrid.grid.axes import FACES, make_grid, uniform_nodes
from hybrid.state import ContactHistory

MU, RATIO, PRESSURE = 0.3, 0.5, 3.2e7     # p_f E [N/m³]: 2e4 N/m at a corner of the bed
PLACES = {"corners": rules.corners(), "faces": rules.faces(4)}
RIGHT_HAND = exp_so3(np.array([0.3, -1.1, 0.6]))


def box(cells=1, half=(1.0, 0.8, 0.5)):
    """ContactSurface of a box with `cells` x `cells` squares, two triangles each, on each side."""
    grid = np.linspace(-1.0, 1.0, cells + 1)
    index, triangles = {}, []
    for axis in range(3):
        for side in (-1.0, 1.0):
            for i in range(cells):
                for j in range(cells):
                    square = []
                    for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        corner = np.empty(3)
                        corner[axis] = side
                        corner[(axis + 1) % 3], corner[(axis + 2) % 3] = grid[i + u], grid[j + v]
                        square.append(index.setdefault(tuple(corner + 0.0), len(index)))
                    square = square if side > 0 else square[::-1]
                    triangles += [square[:3], [square[0], square[2], square[3]]]
    return build_surface(np.array(list(index)) * half, np.array(triangles))


def ball(radius=0.25, rings=24):
    """ContactSurface of a sphere with vertices on circles of latitude."""
    polar = np.linspace(0, np.pi, rings + 1)[1:-1]
    turn = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    points = [[0, 0, radius]]
    for a in polar:
        points += [[radius * np.sin(a) * c for c in (np.cos(b), np.sin(b), 1 / np.tan(a))] for b in turn]
    points.append([0, 0, -radius])
    n, triangles = len(turn), []
    for j in range(n):
        k = (j + 1) % n
        triangles.append([0, 1 + j, 1 + k])
        for i in range(len(polar) - 1):
            a, b = 1 + i * n, 1 + (i + 1) * n
            triangles += [[a + j, b + j, b + k], [a + j, b + k, a + k]]
        triangles.append([len(points) - 1, 1 + (len(polar) - 1) * n + k, 1 + (len(polar) - 1) * n + j])
    return build_surface(np.array(points, float), np.array(triangles))


def body_at(position=(0.0, 0.0, 0.0), rotation=np.eye(3)):
    position = np.array(position, float)
    return SimpleNamespace(position=position, rotation=rotation, pose=(position, rotation), velocity=np.zeros(3),
                           spin=np.zeros(3))


def corners_in(surface, y, anchor, pose=(np.zeros(3), np.eye(3)), touching=True):
    """Corners at places y (m, 3) of the body frame."""
    y = np.atleast_2d(np.array(y, float))
    m = len(y)
    return ContactPoints(
        np.arange(m), np.zeros(m, np.int64), pose[0] + y @ pose[1].T, y, np.zeros((m, 8), np.int64), np.full((m, 8), 0.125),
        np.full(m, 2e4), np.full(m, touching), np.array(np.broadcast_to(anchor, (m, 3)), float),
        np.zeros((m, 3)), np.zeros(m), np.zeros(m))


def contact_of(corners, surface, pose=(np.zeros(3), np.eye(3)), place=None, mu=MU):
    return soil_to_body.evaluate(
        corners, corners.position if place is None else place, *pose, surface, mu, RATIO)


def bed(cells=(8, 8, 2), size=0.1, per_axis=2):
    """Grid about z = 0, and positions and half-widths of the points that tile its lower half."""
    axes = [uniform_nodes(0.0, n * size, size) for n in cells[:2]]
    axes.append(uniform_nodes(-cells[2] * size / 2, cells[2] * size / 2, size))
    grid = make_grid(axes, np.array([(a[0], a[-1]) for a in axes]), dict.fromkeys(FACES, "free"))
    step = size / per_axis
    centres = [np.arange(a[0] + step / 2, end, step) for a, end in zip(axes, (axes[0][-1], axes[1][-1], 0.0))]
    position = np.stack([c.ravel() for c in np.meshgrid(*centres, indexing="ij")], axis=1)
    return grid, position, np.full_like(position, step / 2)


def found_in_bed(surface, body, history=None, active=None, reach=0.08, seed=1, pose=None, displacement=None,
                 included=True, scatter=0.01, places=rules.corners()):
    """Grid, and Corners of a bed near a body; scatter: [m] of the points."""
    grid, position, half = bed()
    position = position + scatter * np.random.default_rng(seed).standard_normal(position.shape)
    active = np.ones(grid.node_count, bool) if active is None else active
    begins, history = history is None, history or ContactHistory.empty()
    expected = displacement, pose or (body.position, body.rotation)
    rigid = SimpleNamespace(contact_pressure=np.full(len(position), PRESSURE), places=places, surface=surface,
                            soft_edges=None)
    return grid, find_contact_points(SoilSurface(domains_of(position, half, included), grid, active), rigid, body, history,
                                     Reach(reach, 0.0), expected, begins=begins)


def domains_of(position, half, included=True):
    """Domains of points that have not deformed."""
    return Domains(position, half, (2 * half).prod(axis=1), np.array(np.broadcast_to(included, len(position))))


def id_of(held):
    """One number (m,) for each contact point of Corners or of a ContactHistory."""
    return 1000 * held.point + held.place
