"""Which planes of symmetry pass through the bodies of a scene.

A body that lies across such planes counts with the share of its mass in the part that is modelled.

A face of the grid at the end of x or y is a plane of symmetry if it is a roller, the soil reaches it, gravity lies in it,
and a body either ends there, with the cut face of its geometry (the group `symmetry`) in the plane, or lies across it and
is symmetric about it. A body that reaches both ends of the axis, as a platen on all of the soil, has none, nor has one
that lies across the plane and is joined beside it. In the plane a body moves along it and turns about its normal only; its
other components are held.
"""

from dataclasses import replace

import numpy as np

from hybrid.body.attitude import initial_rotation
from hybrid.body.solid import moments
from hybrid.body.surface import build_surface
from hybrid.body.symmetry import AXES, UNLIKE, Mirror
from hybrid.contact.search import distances
from hybrid.runtime.errors import SceneError
from hybrid.scene.body import out_of_plane
from hybrid.scene.check_stage import moved
from hybrid.scene.defaults import Decision
from hybrid.setup.stages import point_of

IN_PLANE = 1e-6     # of the size of a body: cut faces nearer to the plane are in it
MIDDLE = 0.02       # the same of the middle of a body across the plane, whose facets need not be symmetric
# The same between its surface and its mirror image, 0.0017 of a box tilted by 0.1°; and more where facets are curved, of
# what they rise by between their corners: up to 0.0003 of round bodies of fine ones, 0.046 of a ball of 14 facets
ALIKE, OF_FACETS = 0.003, 0.15


def with_symmetry(scene, meshes):
    """(Scene in which bodies in planes of symmetry are held there, Decisions about it, Mirrors (tuple) of each body).

    Raises SceneError where a body that is cut would leave its plane.
    """
    bodies, decisions, found = [], [], []
    for i, (described, mirrors) in enumerate(zip(scene.bodies, _all_mirrors(scene, meshes))):
        needed = dict.fromkeys(name for mirror in mirrors for name in out_of_plane(mirror.axis))
        for mirror in mirrors:
            _refuse_motion(scene, f"body.{i}", described, mirror)
        if more := [name for name in needed if name not in described.held]:
            described = replace(described, held=(*described.held, *more))
            decisions.append(Decision(f"body.{i}.held", list(described.held), "the model is symmetric about "
                                      + " and ".join(map(str, mirrors))))
        bodies.append(described)
        found.append(mirrors)
    return replace(scene, bodies=tuple(bodies)), tuple(decisions), found


def mirrors_of(scene, described, mesh):
    """Yields the Mirrors of a body."""
    points, cap = _placed(described, mesh)
    size = np.ptp(points, axis=0).max()
    for name, a in AXES.items():
        axis = getattr(scene.grid, name)
        low, high = points[:, a].min(), points[:, a].max()
        covers = low < axis.start + IN_PLANE * size and high > axis.end - IN_PLANE * size
        for side, at in enumerate((axis.start, axis.end)):
            if axis.collapsed or scene.gravity[a] or scene.grid.faces.of(a, side) != "roller":
                continue
            cut = len(cap) > 0 and np.abs(cap[:, a] - at).max() < IN_PLANE * size
            across = (not len(cap) and not covers and low < at < high and abs(0.5 * (low + high) - at) < MIDDLE * size
                      and _mass_is_symmetric(points, mesh, described.density, a, at)
                      and _surface_is_symmetric(described, mesh, a, at, size))
            if (cut or across) and _soil_reaches(scene, a, at) and (cut or not moved(scene, described, out_of_plane(name))):
                yield Mirror(name, at, cut)


def _mass_is_symmetric(points, mesh, density, a, at):
    """Whether the moments of mass that are zero by symmetry about the plane at `at` [m] of coordinate `a` are at most UNLIKE
    beside those of the body's own size: a block turned about an axis in the plane has its middle there too. points: (n, 3)
    [m] of its TetMesh in space; density: [kg/m³], or that of each of its volumes."""
    of_tets = np.ones(len(mesh.tets))
    if isinstance(density, dict):
        of_tets = np.array([density[name] for name in mesh.regions], float)[mesh.region]

    def weighted(places):
        return sum(value * moments(places, mesh.tets[of_tets == value]) for value in np.unique(of_tets))

    whole = weighted(points)
    origin = whole[0, 1:] / whole[0, 0]
    origin[a] = at
    whole, side = weighted(points - origin), 1 + a
    size = np.sqrt(np.diag(whole) * whole[side, side])
    return (np.abs(np.delete(whole[side] / size, side)) < UNLIKE).all()


def _surface_is_symmetric(described, mesh, a, at, size):
    """Whether the mirror images of the corners of a body's surface, about the plane at `at` [m] of coordinate `a`, are on
    it, to a share of its size [m]: a cube tilted by any angle has the moments of one that is not."""
    surface, turn = build_surface(mesh.points, mesh.contact, mesh.normals), initial_rotation(described)
    place = np.array(described.position or (0.0, 0.0, 0.0))
    image = place + surface.vertices @ turn.T
    image[:, a] = 2.0 * at - image[:, a]
    corners = surface.vertices[surface.triangles[surface.curved]]
    length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    cosine = np.einsum("tki,ti->tk", surface.corner_normals, surface.normals)[surface.curved].min(axis=1)
    rises = (length * np.sqrt(np.clip(1.0 - cosine**2, 0.0, 1.0))).max(initial=0.0)
    return np.abs(distances((image - place) @ turn, surface)[0]).max() < ALIKE * size + OF_FACETS * rises


def _all_mirrors(scene, meshes):
    """Mirrors (tuple) of each body; of one that lies across a plane only if its joints, and the bodies that they join it to,
    are in that plane too."""
    found = [tuple(mirrors_of(scene, *pair)) for pair in zip(scene.bodies, meshes)]
    while True:     # a chain may leave the plane at its far end
        planes = {body.name: {(mirror.axis, mirror.at) for mirror in mirrors} for body, mirrors in zip(scene.bodies, found)}
        kept = [tuple(mirror for mirror in mirrors if mirror.cut or not _joined_beside(scene, body, mirror, meshes, planes))
                for body, mirrors in zip(scene.bodies, found)]
        if kept == found:
            return found
        found = kept


def _joined_beside(scene, described, mirror, meshes, planes):
    """Whether a joint of a body, or what it joins the body to, is beside a plane that the body lies across, so that the
    mirror image is another joint. planes: {name: {(axis, at)}} of all bodies."""
    a = AXES[mirror.axis]
    for i, joint in enumerate(scene.joints):
        if described.name not in joint.bodies:
            continue
        if any((mirror.axis, mirror.at) not in planes[name] for name in joint.bodies):
            return True
        ends = [("point", joint.point, joint.bodies[0])]
        if joint.end is not None:
            ends.append(("end", joint.end, joint.bodies[1] if len(joint.bodies) == 2 else None))
        for key, point, name in ends:
            if abs(_in_space(scene, point, f"joint.{i}.{key}", name, meshes)[a] - mirror.at) > _slack(scene, joint, meshes):
                return True
        along = abs(joint.axis[a]) / np.linalg.norm(joint.axis) if joint.kind == "hinge" and joint.axis else 0.0
        if MIDDLE < along < 1.0 - MIDDLE:
            return True
    return False


def _slack(scene, joint, meshes):
    """[m] by which a joint in a plane of symmetry may be beside it."""
    names = [body.name for body in scene.bodies]
    return MIDDLE * max(np.ptp(meshes[names.index(name)].points, axis=0).max() for name in joint.bodies)


def _in_space(scene, point, key, name, meshes):
    """(3,) [m] place of a point of the body of this name, or of space if None; heights without body.rest_on."""
    if name is None:
        return np.array(point, float)
    number = [body.name for body in scene.bodies].index(name)
    described, mesh = scene.bodies[number], meshes[number]
    point = point_of(point, key, described, mesh)
    return np.array(described.position or (0.0, 0.0, 0.0)) + initial_rotation(described) @ point


def in_part(body, mirrors):
    """The RigidBody with the share of its mass in the part that is modelled: half of it for each plane that it lies
    across."""
    return replace(body, mass=body.mass.times(0.5 ** sum(not mirror.cut for mirror in mirrors)))


def unmirrored_cut(mesh, mirrors):
    """Whether the cut face of a body lies in no plane of symmetry of the model."""
    return len(mesh.symmetry) > 0 and not any(mirror.cut for mirror in mirrors)


def _placed(described, mesh):
    """Nodes (n, 3) of a body and of its cut face (m, 3) [m] at the start; heights without body.rest_on."""
    points = np.array(described.position or (0.0, 0.0, 0.0)) + mesh.points @ initial_rotation(described).T
    return points, points[np.unique(mesh.symmetry)] if len(mesh.symmetry) else np.zeros((0, 3))


def _soil_reaches(scene, a, at):
    soil = scene.soil
    low, high = (None if corner is None else corner[a] for corner in (soil.lower, soil.upper))
    return (low is None or low <= at) and (high is None or high >= at)


def _refuse_motion(scene, key, described, mirror):
    leaving = moved(scene, described, out_of_plane(mirror.axis))
    if leaving:
        raise SceneError(f"{key} ({described.name}) is cut by {mirror}, a plane of symmetry of the grid, but moves in "
                         f"{', '.join(leaving)}: its mirror image would move against it. Model the whole body, or leave "
                         "these components out")
