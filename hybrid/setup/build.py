"""From a Scene to a model and its initial state."""

from dataclasses import replace

import numpy as np

from hybrid.body.parts import surface_parts
from hybrid.body.rigid import with_stiffness
from hybrid.runtime import ranks
from hybrid.runtime.errors import SceneError
from hybrid.scene.accuracy import apply_accuracy
from hybrid.scene.check_sense import sense_notes
from hybrid.scene.defaults import resolve
from hybrid.scene.file import validate
from hybrid.scheme import Scheme
from hybrid.setup import on_ground
from hybrid.setup.bearing import carried_by_each, falling_bodies, undisturbed
from hybrid.setup.bodies import build_body, mesh_of, refuse_outside
from hybrid.setup.body_contact import build_pairs, refuse_overlap_of_bodies
from hybrid.setup.contact import connect_to_soil
from hybrid.setup.grid import axis_nodes, build_carried_grid, build_grid
from hybrid.setup.ground import lower_to_ground
from hybrid.setup.in_place import flush_contacts, put_in_place, starts_inside
from hybrid.setup.joints import build_joints, refuse_velocities
from hybrid.setup.line_soil import line_through_soil
from hybrid.setup.rolling import with_soft_springs
from hybrid.setup.settle import settle
from hybrid.setup.size import refuse_cells, refuse_size
from hybrid.setup.soil import build_soil
from hybrid.setup.stages import refuse_implied
from hybrid.setup.symmetry import in_part, unmirrored_cut, with_symmetry
from hybrid.simulation import Simulation
from hybrid.state import ContactHistory, State
from hybrid.step import joint_rates, processes
from hybrid.step.loads import Loads
from hybrid.step.model import Model


def build(scene, *, body_force=None, law=None):
    """Simulation of a Scene, ready to run. Raises SceneError, GeometryError or LawError with what to change.

    body_force: function of the time [s] and the points' initial positions (n, 3) [m] that returns accelerations (n, 3)
    [m/s²], added to gravity. law: function that makes the law of a scene whose soil.material.law is "user"
    (`hybrid.laws.user`).
    """
    ranks.prepare()
    scene = validate(scene)
    changed, texts = apply_accuracy(scene)
    if not texts:
        return _assemble(scene, [], body_force, law)
    try:
        return _assemble(validate(changed), texts, body_force, law)
    except SceneError as error:     # its values are not those of the file
        given = scene.accuracy if isinstance(scene.accuracy, str) else scene.accuracy.like
        raise SceneError(f"{error}\n  These values are not those of the scene: accuracy = {given!r} changed them "
                         f"({'; '.join(texts)}). Choose values of the scene that also fit after this change, or leave "
                         "accuracy out") from None


def _assemble(scene, accuracy, body_force, law):
    """Simulation of a checked Scene without `accuracy`; accuracy: texts of what it changed, for the model sheet. Numbers
    that look wrong may be why a scene is refused: notes about them follow the error."""
    scene, decisions = resolve(scene)
    try:
        return _put_together(scene, decisions, accuracy, body_force, law)
    except SceneError as error:
        if notes := list(sense_notes(scene)):
            raise SceneError("\n  ".join([str(error), *notes])) from None
        raise


def _put_together(scene, decisions, accuracy, body_force, law):
    """Simulation of a Scene all of whose keys are decided."""
    refuse_cells(scene)
    gravity = np.array(scene.gravity, float)
    loads = Loads(gravity, body_force).during(0.0, 0.0, (scene.stages[0].gravity[0],) * 2)
    if not scene.grid.moves:
        refuse_size(scene, [axis_nodes(axis) for axis in scene.grid.axes])
    meshes = [mesh_of(described) for described in scene.bodies]
    scene, held, mirrors = with_symmetry(scene, meshes)
    placed = [build_body(*pair, loads.on_bodies(0.0), scene.stages) for pair in zip(scene.bodies, meshes)]
    scene, placed = lower_to_ground(scene, placed)
    refuse_outside(scene, placed)
    placed = [(line_through_soil(scene, described, body, motion, planes), motion)
              for described, (body, motion), planes in zip(scene.bodies, placed, mirrors)]
    joints = build_joints(scene, placed, meshes)
    refuse_overlap_of_bodies(placed, [joint.bodies for joint in joints],
                             [axis.collapsed for axis in scene.grid.axes])
    grid, moving_grid, layouts = build_grid(scene, placed)
    soil, points = build_soil(scene, grid, loads, law)
    motions, contacts = [motion for _, motion in placed], [ContactHistory.empty() for _ in placed]
    parts = [(in_part(body, planes), motion) for (body, motion), planes in zip(placed, mirrors)]
    carried, falling = carried_by_each(parts, joints, soil), falling_bodies(placed, joints, soil)
    heaviest = gravity * max([1.0, *(share for stage in scene.stages for share in stage.gravity)])
    bodies = [_connected(*one, soil, heaviest, alone=undisturbed(i, placed, falling, one[4]))
              for i, one in enumerate(zip(scene.bodies, meshes, mirrors, placed, carried))]
    inside = [starts_inside(body, motion, points, soil) for body, motion in zip(bodies, motions)]
    removed_soil = []
    if any(inside):
        soil, points, contacts, removed_soil = put_in_place(
            soil, points, *([one if there else None for one, there in zip(items, inside)] for items in (bodies, motions)))
        bodies = [with_stiffness(body, soil.law.young, soil.held) for body in bodies]
    contacts = flush_contacts(soil, points, bodies, motions, contacts)
    pairs, touching = build_pairs(scene, bodies, motions, joints, grid, gravity)
    scene, bodies, decisions = with_soft_springs(scene, bodies, motions, decisions)
    model = Model(soil, tuple(bodies), Scheme.of(scene.time), loads, scene.solver, joints, pairs)
    state = State(0.0, 0, points, motions, contacts, joints=joint_rates.start(model), pairs=touching)
    refuse_velocities(model, state)
    refuse_implied(scene, model, state)
    if moving_grid is not None:
        state.ground = moving_grid.first_ground(layouts, soil)
    settled = None
    if removed_soil:
        model, state = processes.balanced(model, state)
    if removed_soil or scene.soil.ground is not None:
        model, state, settled = settle(model, state, scene.step_of(scene.stages[0]))
    carried_grid = build_carried_grid(scene, grid, placed, moving_grid)
    return Simulation(scene, model, state, meshes, moving_grid, carried_grid, accuracy, (*decisions, *held),
                      _start(removed_soil, settled, bodies, carried_grid))


def _connected(described, mesh, mirrors, placed, carried, soil, gravity, alone):
    """RigidBody with its contact, its planes of symmetry and the parts of its surface; placed: (RigidBody, BodyState);
    gravity: the largest [m/s²] of all stages; carried, alone: as in `connect_to_soil`."""
    body, motion = replace(in_part(placed[0], mirrors), mirrors=mirrors), placed[1]
    connected = connect_to_soil(described, body, motion, soil, gravity, alone, carried)
    parts = surface_parts(mesh, body.outline, connected.surface, motion.rotation[soil.grid.collapsed],
                          connected.mass.mass / body.mass.mass)
    connected = replace(connected, unmirrored_cut=unmirrored_cut(mesh, mirrors), parts=parts)
    if on_ground.is_made_for(described, connected, motion, soil):
        connected = replace(connected, ground=on_ground.ground_of(connected, motion, soil, gravity))
    return connected


def _start(removed_soil, settled, bodies, carried_grid):
    """Rows {label: value} of the model sheet about bodies that are in place, soil that has settled, lines in it and a grid
    that goes along with bodies."""
    rows = {"in place from the start": [str(one) for one in removed_soil]} if removed_soil else {}
    lines = [f"{body.name}: {body.line.soil}" for body in bodies if body.line and body.line.soil]
    rows |= {"pull lines in soil": lines} if lines else {}
    rows |= {"settled at the start": str(settled)} if settled else {}
    names = carried_grid.names if carried_grid else []
    return rows | ({"grid goes along with bodies": f"along {', '.join(names)}, by half a cell at most"} if names else {})
