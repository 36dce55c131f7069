"""Triangles on curved surfaces with the exact normals at their corners: vertices (n, 3), triangles (t, 3), normals
(t, 3, 3), each with the exact gap and normal around it."""

import numpy as np

AXES = np.array([1.0, 1.3, 0.8])   # of the ellipsoid
TORUS = 1.0, 0.4                   # radii of its circle and of its tube


def octasphere(levels):
    """Unit sphere of 8·4^levels triangles."""
    corners = [np.eye(3)[[0, 1, 2]] * s for s in np.array(np.meshgrid((1, -1), (1, -1), (1, -1))).reshape(3, -1).T]
    corners = np.array([c if np.linalg.det(c) > 0 else c[::-1] for c in corners])
    for _ in range(levels):
        a, b, c = np.moveaxis(corners, 1, 0)
        ab, bc, ca = (p + q for p, q in ((a, b), (b, c), (c, a)))
        corners = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        corners /= np.linalg.norm(corners, axis=2, keepdims=True)
    return merged(corners)


def merged(corners):
    """Vertices and triangles of corners (t, 3, 3), coinciding ones merged."""
    _, first, number = np.unique(np.round(corners.reshape(-1, 3), 9) + 0.0, axis=0, return_index=True,
                                 return_inverse=True)
    return corners.reshape(-1, 3)[first], number.reshape(-1, 3)


def ellipsoid(levels):
    vertices, triangles = octasphere(levels)
    normals = vertices / AXES
    return vertices * AXES, triangles, (normals / np.linalg.norm(normals, axis=1)[:, None])[triangles]


def sphere(levels):
    vertices, triangles = octasphere(levels)
    return vertices, triangles, vertices[triangles]


def torus(levels):
    n = 10 * 2**levels
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    around, tube = 2 * np.pi * (i + 0.5 * j) / n, 2 * np.pi * j / n
    out = np.stack((np.cos(around), np.sin(around), 0.0 * around), -1).reshape(-1, 3)
    up, tube = np.array([0.0, 0.0, 1.0]), tube.reshape(-1, 1)
    normals = np.cos(tube) * out + np.sin(tube) * up

    def number(a, b):       # one turn of the tube is half a turn of the index around
        turns = b // n
        return ((a + (turns * n) // 2) % n) * n + b % n

    quad = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]
    triangles = np.stack([np.stack([quad[0], quad[1], quad[3]], -1), np.stack([quad[1], quad[2], quad[3]], -1)])
    triangles = triangles.reshape(-1, 3)
    return TORUS[0] * out + TORUS[1] * normals, triangles, normals[triangles]


def around(shape, count, depth, seed=0):
    """Places (count, 3), their exact gaps up to ±depth and normals, about a shape given by its name."""
    rng = np.random.default_rng(seed)
    unit = rng.normal(size=(count, 3))
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    if shape == "torus":
        a, b = rng.uniform(0, 2 * np.pi, (2, count, 1))
        out = np.hstack((np.cos(a), np.sin(a), 0 * a))
        normal = np.cos(b) * out + np.sin(b) * np.array([0.0, 0.0, 1.0])
        place = TORUS[0] * out + TORUS[1] * normal
    else:
        axes = AXES if shape == "ellipsoid" else np.ones(3)
        place, normal = axes * unit, unit / axes
        normal /= np.linalg.norm(normal, axis=1)[:, None]
    gap = rng.uniform(-depth, depth, count)
    return place + gap[:, None] * normal, gap, normal


def revolved(profile, n):
    """Body of revolution about z of a profile (k, 2) of (r, z), from axis to axis, counter-clockwise; n sectors."""
    profile = np.asarray(profile, float)
    angle = 2 * np.pi * np.arange(n) / n
    corners, normals = [], []

    def ring(r, z, a):
        return np.array([r * np.cos(a), r * np.sin(a), z])

    for (r, z), (R, Z) in zip(profile[:-1], profile[1:]):
        along = np.hypot(R - r, Z - z)
        cuts = max(1, round(along / (2 * np.pi * max(r, R) / n)))
        for s in range(cuts):
            (r0, z0), (r1, z1) = ((r + f * (R - r), z + f * (Z - z)) for f in (s / cuts, (s + 1) / cuts))
            for a, b in zip(angle, angle + 2 * np.pi / n):
                for part in ([(r0, z0, a), (r0, z0, b), (r1, z1, b)], [(r0, z0, a), (r1, z1, b), (r1, z1, a)]):
                    place = [ring(*p) for p in part]
                    if np.linalg.norm(np.cross(place[1] - place[0], place[2] - place[0])) > 1e-9:
                        corners.append(place)
                        normals.append([ring((Z - z) / along, (r - R) / along, p[2]) for p in part])
    return *merged(np.array(corners)), np.array(normals)
