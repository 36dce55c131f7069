"""The rigid bodies of a scene: mesh, mass, surface, initial motion, pull line, and contact with the soil."""

import numpy as np

from hybrid.body import rigid
from hybrid.body.attitude import initial_rotation
from hybrid.body.guides import forces_of
from hybrid.body.motion import free_spin_rate
from hybrid.body.rigid import FREEDOMS, Line, RigidBody
from hybrid.runtime.errors import SceneError
from hybrid.setup.stages import point_of, stage_controls
from hybrid.state import BodyState
from hybrid.step import flight


FLUSH = 1e-3    # of the size of a body


def mesh_of(described):
    """TetMesh of a body's geometry."""
    from hybrid.body.mesh import generate  # late, as in build_body: a scene without bodies needs no gmsh and dolfinx

    volumes = tuple(described.density) if isinstance(described.density, dict) else ()
    return generate(described.geometry, described.parameters, None, described.scale, described.symmetry, volumes)


def build_body(described, body_mesh, gravity, stages=()):
    """(RigidBody, its initial BodyState); its contact follows from the soil (`hybrid.setup.contact`). stages: those of the
    scene."""
    from hybrid.body.smooth_mass import mass_and_surface

    properties, surface = mass_and_surface(body_mesh, described.density)
    rotation = initial_rotation(described)
    position = np.array(described.position or (0.0, 0.0, 0.0)) + rotation @ properties.centre
    if described.rest_on not in (None, "ground"):
        position[2] = described.rest_on + surface.extent(-rotation[2])     # of its lowest point
    driven = np.isin(FREEDOMS, described.driven)
    free = ~(np.isin(FREEDOMS, described.held) | driven)
    rates = np.concatenate([described.velocity, rotation @ described.spin])
    body = RigidBody(
        name=described.name, mass=properties, surface=surface, free=free, drive=rates * driven,
        friction=described.friction or 0.0, tangential=described.tangential,
        line=build_line(described, body_mesh, properties),
        stages=stage_controls(stages, described, body_mesh, properties.centre))
    if body.stages:
        free = free | body.stages[0].released
    falling = gravity * free[:3]  # nothing touches a body at the start, so it accelerates freely
    spin = np.array(described.spin, float)
    motion = BodyState(position, rotation, np.array(described.velocity, float), falling, spin,
                       free_spin_rate(properties.inertia, rotation, spin, free[3:]), apart=flight.AFTER)
    return body, motion


def refuse_outside(scene, placed):
    """Raise SceneError where the only body of a scene is beside or below the grid, and nothing can bring it there; placed:
    (RigidBody, BodyState) of it."""
    if len(placed) != 1 or not any(scene.gravity) or scene.joints:
        return
    described, (body, motion) = scene.bodies[0], placed[0]
    for a, (name, axis) in enumerate(zip("xyz", scene.grid.axes)):
        low, high = rigid.bounding_box(body, motion)[:, a]
        slack = FLUSH * (high - low)        # one that touches the end of the grid may touch the soil
        beside = low > axis.end + slack and name != "z" or high < axis.start - slack
        if beside and not axis.collapsed and not _moved_along(scene, described, body, a):
            where = f"beside the grid, from {name} = {low:.4g} to {high:.4g} m" if name != "z" else (
                f"below the grid, up to z = {high:.4g} m (z points up)")
            raise SceneError(
                f"body.0.position: {body.name} lies {where}, where the grid goes from {axis.start:g} to {axis.end:g} m: no "
                "soil is there, and nothing moves it there. Give coordinates of the grid, in metres")


def _moved_along(scene, described, body, a):
    """Whether anything but its weight may move a body along the axis a, or its weight along one of the ground."""
    guided = any(control.points or control.driven[a] for control in body.stages or ())
    return bool(described.pull or described.velocity[a] or guided or any(force[:, a].any() for force in forces_of(body))
                or a < 2 and scene.gravity[a])


def build_line(described, body_mesh, properties):
    """Pull line, or None without a pull."""
    pull = described.pull
    if pull is None:
        return None
    point = point_of(pull.point, "body.pull.point", described, body_mesh)
    direction = np.array(pull.direction if pull.direction is not None else pull.velocity, float)
    return Line(point - properties.centre, direction / np.linalg.norm(direction), np.array(pull.velocity, float),
                pull.stiffness, pull.length, pull.tension_only)
