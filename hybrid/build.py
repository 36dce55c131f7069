"""From a Scene to a model and its initial state: the only reader of scenes, apart from what observers print."""

import numpy as np

from hybrid.body import mass, mesh
from hybrid.body.attitude import rotation_from_axis_angle
from hybrid.body.motion import free_spin_rate
from hybrid.body.rigid import FREEDOMS, Line, RigidBody
from hybrid.body.samples import surface_samples
from hybrid.body.surface import build_surface
from hybrid.contact.corners import overlap
from hybrid.errors import SceneError
from hybrid.ground import build_ground
from hybrid.scene_file import validate
from hybrid.scheme import Scheme
from hybrid.simulation import Simulation
from hybrid.soil.grid import FACES, graded_nodes, make_grid, uniform_nodes
from hybrid.soil.model import Soil
from hybrid.soil.points import at_rest, tile
from hybrid.state import BodyState, ContactHistory, State
from hybrid.system.loads import Loads
from hybrid.system.model import Model


def build(scene, *, body_force=None, law=None):
    """Simulation of a Scene, ready to run. Raises SceneError, GeometryError or LawError with what to change.

    body_force: function of the time [s] and the points' initial positions (n, 3) [m] that gives accelerations (n, 3)
    [m/s²] to act on them besides gravity. law: function that makes the law of a scene whose soil.material.law is "user"
    (`hybrid.laws.user`).
    """
    scene = validate(scene)
    gravity = np.array(scene.gravity, float)
    grid = build_grid(scene)
    loads = Loads(gravity, body_force).during(0.0, 0.0, (scene.stages[0].gravity[0],) * 2)
    soil, points = build_soil(scene, grid, loads, law)
    meshes, bodies, motions, contacts = [], [], [], []
    for described in scene.bodies:
        body_mesh = mesh.generate(described.geometry, described.parameters)
        body, motion = build_body(described, body_mesh, soil, loads.on_bodies(0.0))
        refuse_overlap(described, body, motion, points, soil.basis)
        meshes.append(body_mesh)
        bodies.append(body)
        motions.append(motion)
        contacts.append(ContactHistory.empty())
    model = Model(
        soil, tuple(bodies), build_scheme(scene.time), loads, scene.solver.linear, scene.solver.linear_tolerance)
    return Simulation(scene, model, State(0.0, 0, points, motions, contacts), meshes)


def build_scheme(time):
    """Time integration of the scene; its stages may replace it by a pair of Newmark's."""
    if not time.inertia:
        return Scheme(inertia=False)
    if time.scheme == "generalised-alpha":
        return Scheme.generalised_alpha(0.8 if time.spectral_radius is None else time.spectral_radius)
    return Scheme.energy_momentum() if time.scheme == "energy-momentum" else Scheme.newmark(time.beta, time.gamma)


def build_grid(scene):
    """Background grid with its held faces."""
    axes, extent = [], []
    for axis in (scene.grid.x, scene.grid.y, scene.grid.z):
        extent.append((axis.start, axis.end))
        if axis.collapsed:
            axes.append(np.array([0.5 * (axis.start + axis.end)]))
        elif axis.nodes is not None:
            axes.append(np.array(axis.nodes))
        elif axis.fine is not None:
            axes.append(graded_nodes(axis.start, axis.end, axis.size, axis.fine, axis.growth))
        else:
            axes.append(uniform_nodes(axis.start, axis.end, axis.size))
    faces = {face: getattr(scene.grid.faces, face) for face in FACES}
    return make_grid(axes, np.array(extent), faces, scene.soil.held)


def build_soil(scene, grid, loads, law=None):
    """Soil model and its points at rest, in geostatic equilibrium when asked for."""
    described, gravity = scene.soil, loads.gravity
    lower = np.array(described.lower if described.lower is not None else grid.extent[:, 0])
    upper = np.array(described.upper if described.upper is not None else grid.extent[:, 1])
    if described.top is not None:
        upper[2] = described.top
    per_axis = np.broadcast_to(described.points_per_axis, 3)
    constants, stress, law = build_ground(described, tile(grid, lower, upper, per_axis, 1.0), upper[2], gravity, law)
    points = at_rest(constants, stress, law.strain(stress))
    if scene.time.inertia and not stress.any():
        points.acceleration[:] = loads.on_points(0.0, constants.position)  # nothing holds it yet
    soil = Soil(grid, constants, law, described.basis, described.domain, described.held, scene.solver.elastic_share,
                described.fbar, described.ghost, described.stray, adrift=scene.time.inertia,
                transfer=described.transfer if scene.time.inertia else "increments",
                blend=0.05 if described.blend is None else described.blend,
                tangent_tolerance=scene.solver.tangent_tolerance)
    return soil, points


def build_body(described, body_mesh, soil, gravity):
    """RigidBody and its initial BodyState."""
    properties = mass.condensed_mass(body_mesh, described.density)
    surface = build_surface(body_mesh.points - properties.centre, body_mesh.contact)
    rotation = np.eye(3)
    if described.rotation:
        rotation = rotation_from_axis_angle(described.rotation[:3], np.radians(described.rotation[3]))
    position = np.array(described.position or (0.0, 0.0, 0.0)) + rotation @ properties.centre
    if described.rest_on is not None:
        position[2] = described.rest_on - (surface.vertices @ rotation.T)[:, 2].min()
    pressure = described.penalty * soil.law.young
    samples = None
    if described.second_pass:
        samples = surface_samples(surface, 2 * soil.constants.half.min())
    driven = np.isin(FREEDOMS, described.driven)
    free = ~(np.isin(FREEDOMS, described.held) | driven)
    rates = np.concatenate([described.velocity, rotation @ described.spin])
    body = RigidBody(
        name=described.name, mass=properties, surface=surface, free=free, drive=rates * driven,
        friction=described.friction, tangential=described.tangential, contact_pressure=pressure,
        contact_stiffness=pressure * soil.constants.volume ** (2 / 3), samples=samples,
        second_pass=described.second_pass, augmented=described.enforcement == "augmented",
        line=build_line(described, body_mesh, properties))
    falling = gravity * free[:3]  # nothing touches a body at the start, so it accelerates freely
    spin = np.array(described.spin, float)
    motion = BodyState(position, rotation, np.array(described.velocity, float), falling, spin,
                       free_spin_rate(properties.inertia, rotation, spin, free[3:]))
    return body, motion


def build_line(described, body_mesh, properties):
    """Pull line, or None without a pull."""
    pull = described.pull
    if pull is None:
        return None
    if isinstance(pull.point, str):
        if pull.point not in body_mesh.named_points:
            raise SceneError(f"body.pull.point = {pull.point!r} is not a physical point of {described.geometry.name}; "
                             f"it has {', '.join(body_mesh.named_points) or 'none'}")
        point = body_mesh.named_points[pull.point]
    else:
        point = np.array(pull.point, float)
    direction = np.array(pull.direction if pull.direction is not None else pull.velocity, float)
    return Line(point - properties.centre, direction / np.linalg.norm(direction), np.array(pull.velocity, float),
                pull.stiffness, pull.length, pull.tension_only)


def refuse_overlap(described, body, motion, points, basis):
    """SceneError when the body starts inside the soil: the penalty would throw it out."""
    half = points.half if basis == "gimp" else np.zeros_like(points.half)
    depth, count = overlap(points.position, half, motion, body.surface)
    limit = 0.1 * points.half.min()
    if depth > limit:
        raise SceneError(f"body {described.name!r} starts inside the soil: {count} corners up to {depth:.3g} m deep, "
                         f"limit {limit:.3g} m; raise body.position or set body.rest_on to the soil's surface")
