"""From a Scene to a model and its initial state: the only reader of scenes, apart from what observers print."""

from dataclasses import replace

import numpy as np

from hybrid.body import rigid
from hybrid.body.attitude import rotation_from_axis_angle
from hybrid.body.motion import free_spin_rate
from hybrid.body.rigid import FREEDOMS, Line, RigidBody
from hybrid.body.samples import surface_samples
from hybrid.body.surface import build_surface
from hybrid.contact.corners import overlap
from hybrid.grid.axes import FACES, graded_nodes, make_grid, uniform_nodes
from hybrid.grid.moving_axis import MovingAxis
from hybrid.runtime.errors import SceneError
from hybrid.scene.accuracy import apply_level
from hybrid.scene.file import validate
from hybrid.scheme import Scheme
from hybrid.setup.ground import build_ground
from hybrid.simulation import Simulation
from hybrid.soil.model import Soil
from hybrid.soil.points import at_rest, tile
from hybrid.state import BodyState, ContactHistory, State
from hybrid.step.loads import Loads
from hybrid.step.model import Model
from hybrid.step.moving_grid import Travel


def build(scene, *, body_force=None, law=None):
    """Simulation of a Scene, ready to run. Raises SceneError, GeometryError or LawError with what to change.

    body_force: function of the time [s] and the points' initial positions (n, 3) [m] that gives accelerations (n, 3)
    [m/s²] to act on them besides gravity. law: function that makes the law of a scene whose soil.material.law is "user"
    (`hybrid.laws.user`).
    """
    scene, level = apply_level(validate(scene))
    if level:
        scene = validate(scene)     # what was changed too
    gravity = np.array(scene.gravity, float)
    loads = Loads(gravity, body_force).during(0.0, 0.0, (scene.stages[0].gravity[0],) * 2)
    meshes = [mesh_of(described) for described in scene.bodies]
    placed = [build_body(*pair, loads.on_bodies(0.0)) for pair in zip(scene.bodies, meshes)]
    grid, travel, layouts = build_grid(scene, placed)
    soil, points = build_soil(scene, grid, loads, law)
    motions, contacts = [motion for _, motion in placed], [ContactHistory.empty() for _ in placed]
    bodies = [with_stiffness(described, body, soil) for described, (body, _) in zip(scene.bodies, placed)]
    for described, body, motion in zip(scene.bodies, bodies, motions):
        refuse_overlap(described, body, motion, points, soil.basis)
    model = Model(
        soil, tuple(bodies), build_scheme(scene.time), loads, scene.solver.linear, scene.solver.linear_tolerance)
    state = State(0.0, 0, points, motions, contacts)
    if travel is not None:
        travel.lay_out = lambda grid: lay_out(scene, grid, gravity)
        state.ground = travel.start(layouts, soil)
    return Simulation(scene, model, state, meshes, travel, level)


def build_scheme(time):
    """Time integration of the scene; its stages may replace it by a pair of Newmark's."""
    if not time.inertia:
        return Scheme(inertia=False)
    if time.scheme == "generalised-alpha":
        return Scheme.generalised_alpha(0.8 if time.spectral_radius is None else time.spectral_radius)
    return Scheme.energy_momentum() if time.scheme == "energy-momentum" else Scheme.newmark(time.beta, time.gamma)


def build_grid(scene, placed=()):
    """(Grid with its held faces, Travel or None, its layouts) for bodies `placed`, each a RigidBody and BodyState."""
    axes, extent, moving_axes = [], [], {}
    for number, axis in enumerate((scene.grid.x, scene.grid.y, scene.grid.z)):
        extent.append((axis.start, axis.end))
        if axis.travels:
            moving_axes[number] = build_moving_axis(axis, upwards=number == 2)
            axes.append(None)
        elif axis.collapsed:
            axes.append(np.array([0.5 * (axis.start + axis.end)]))
        elif axis.nodes is not None:
            axes.append(np.array(axis.nodes))
        elif axis.fine is not None:
            axes.append(graded_nodes(axis.start, axis.end, axis.size, axis.fine, axis.growth))
        else:
            axes.append(uniform_nodes(axis.start, axis.end, axis.size))
    faces = {face: getattr(scene.grid.faces, face) for face in FACES}
    if not moving_axes:
        return make_grid(axes, np.array(extent), faces, scene.soil.held), None, None
    names = [body.name for body, _ in placed]
    followed = names.index(scene.grid.follow) if scene.grid.follow else 0
    travel = Travel(followed, moving_axes, axes, np.array(extent), faces,
                    np.broadcast_to(scene.soil.points_per_axis, 3), scene.grid.behind == "freeze")
    layouts = travel.fit(rigid.bounding_box(*placed[followed]))
    return travel.grid(layouts), travel, layouts


def build_moving_axis(axis, upwards):
    """MovingAxis of a travelling axis; `upwards` its window leaves nothing out."""
    window = axis.window and (axis.window[0], np.inf if upwards else axis.window[1])
    cells, per = round((axis.end - axis.start) / axis.size), max(1, round(np.log(2) / np.log(axis.growth)))
    return MovingAxis(axis.start, axis.end, cells, axis.around, window, axis.doublings, per)


def lay_out(scene, grid, gravity, law=None):
    """(PointConstants, principal stress (n, 3) [Pa], law) of the scene's soil, as far as the grid reaches, at rest."""
    described = scene.soil
    lower, upper = grid.extent[:, 0].copy(), grid.extent[:, 1].copy()
    if described.lower is not None:
        lower = np.maximum(lower, described.lower)
    if described.upper is not None:
        upper = np.minimum(upper, described.upper)
    if described.top is not None:
        upper[2] = described.top
    per_axis = np.broadcast_to(described.points_per_axis, 3)
    return build_ground(described, tile(grid, lower, upper, per_axis, 1.0), upper[2], gravity, law)


def build_soil(scene, grid, loads, law=None):
    """Soil model and its points at rest, in geostatic equilibrium when asked for."""
    described = scene.soil
    constants, stress, law = lay_out(scene, grid, loads.gravity, law)
    points = at_rest(constants, stress, law.strain(stress))
    if scene.time.inertia and not stress.any():
        points.acceleration[:] = loads.on_points(0.0, constants.position)  # nothing holds it yet
    soil = Soil(grid, constants, law, described.basis, described.domain, described.held, scene.solver.elastic_share,
                described.fbar, described.ghost, described.stray, adrift=scene.time.inertia,
                transfer=described.transfer if scene.time.inertia else "increments",
                blend=0.05 if described.blend is None else described.blend,
                tangent_tolerance=scene.solver.tangent_tolerance)
    return soil, points


def mesh_of(described):
    """TetMesh of a body's geometry."""
    from hybrid.body.mesh import generate  # late, as in build_body: a scene without bodies needs no gmsh and dolfinx

    return generate(described.geometry, described.parameters)


def build_body(described, body_mesh, gravity):
    """RigidBody, of no soil yet, and its initial BodyState."""
    from hybrid.body.mass import condensed_mass

    properties = condensed_mass(body_mesh, described.density)
    surface = build_surface(body_mesh.points - properties.centre, body_mesh.contact)
    rotation = np.eye(3)
    if described.rotation:
        rotation = rotation_from_axis_angle(described.rotation[:3], np.radians(described.rotation[3]))
    position = np.array(described.position or (0.0, 0.0, 0.0)) + rotation @ properties.centre
    if described.rest_on is not None:
        position[2] = described.rest_on - (surface.vertices @ rotation.T)[:, 2].min()
    driven = np.isin(FREEDOMS, described.driven)
    free = ~(np.isin(FREEDOMS, described.held) | driven)
    rates = np.concatenate([described.velocity, rotation @ described.spin])
    body = RigidBody(
        name=described.name, mass=properties, surface=surface, free=free, drive=rates * driven,
        friction=described.friction, tangential=described.tangential, penalty=described.penalty,
        second_pass=described.second_pass, augmented=described.enforcement == "augmented",
        line=build_line(described, body_mesh, properties))
    falling = gravity * free[:3]  # nothing touches a body at the start, so it accelerates freely
    spin = np.array(described.spin, float)
    motion = BodyState(position, rotation, np.array(described.velocity, float), falling, spin,
                       free_spin_rate(properties.inertia, rotation, spin, free[3:]))
    return body, motion


def with_stiffness(described, body, soil):
    """The body with what it needs to meet `soil`."""
    body = rigid.with_stiffness(body, soil.law.young, soil.constants.volume)
    if not described.second_pass:
        return body
    return replace(body, samples=surface_samples(body.surface, 2 * soil.constants.half_width.min()))


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
    half = points.half_width if basis == "gimp" else np.zeros_like(points.half_width)
    depth, count = overlap(points.position, half, motion, body.surface)
    limit = 0.1 * points.half_width.min()
    if depth > limit:
        raise SceneError(f"body {described.name!r} starts inside the soil: {count} corners up to {depth:.3g} m deep, "
                         f"limit {limit:.3g} m; raise body.position or set body.rest_on to the soil's surface")
