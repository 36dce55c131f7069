"""Motions and loads of a body in the stages of a scene, as the model has them."""

import numpy as np

from hybrid.body.guides import Guide, PointLoad, StageControl
from hybrid.body.point_guides import PointGuide
from hybrid.body.rigid import FREEDOMS
from hybrid.body.table import Table
from hybrid.runtime.errors import SceneError
from hybrid.scene.stage import table_rows
from hybrid.step.joint_terms import implied_guides


def stage_controls(stages, described, body_mesh, centre):
    """StageControl of each of the scene's `stages` for a body, empty where no stage changes anything of it.

    centre: (3,) [m] of its mass in the geometry. Raises SceneError for points that the geometry does not have.
    """
    def own(items):
        return [item for item in items if item.body in (None, described.name)]

    controls = [StageControl(
        released=np.isin(FREEDOMS, [name for motion in own(stage.motions) for name in motion.free]),
        held=np.isin(FREEDOMS, [name for motion in own(stage.motions) if motion.point is None for name in motion.held]),
        guides=tuple(_guide(motion) for motion in own(stage.motions) if motion.component and motion.point is None),
        points=tuple(guide for j, motion in enumerate(stage.motions) if motion in own(stage.motions)
                     for guide in _point_guides(motion, f"stage.{i}.motion.{j}.point", described, body_mesh, centre)),
        loads=tuple(_load(load, f"stage.{i}.load.point", described, body_mesh, centre) for load in own(stage.loads)))
        for i, stage in enumerate(stages)]
    changed = any(own(stage.motions) or own(stage.loads) for stage in stages)
    return tuple(controls) if changed else ()


def _guide(motion):
    component = FREEDOMS.index(motion.component)
    if motion.velocity is not None:
        return Guide(component, Table.of(table_rows(motion.velocity, 2, "velocity"), 0.0), True)
    degrees = np.pi / 180 if component > 2 else 1.0
    return Guide(component, Table.of(table_rows(motion.displacement, 2, "displacement"), 0.0, degrees), False)


def _point_guides(motion, key, described, body_mesh, centre):
    """PointGuides of a Motion, none where it is that of the centre of mass."""
    if motion.point is None:
        return []
    label = motion.point if isinstance(motion.point, str) else "_".join(f"{x:g}" for x in motion.point)
    point = point_of(motion.point, key, described, body_mesh) - centre
    still = Table.of(((0.0, 0.0),), 0.0)
    guides = [Guide(FREEDOMS.index(name), still, True) for name in motion.held]
    guides += [_guide(motion)] if motion.component else []
    return [PointGuide(label, point, guide) for guide in guides]


def refuse_implied(scene, model, state):
    """SceneError where the component of a point that a stage guides follows from what else holds the body."""
    for number, stage in enumerate(scene.stages):
        for guide in implied_guides(model.for_stage(stage.held, number=number), state.bodies):
            raise SceneError(f"stage {stage.name!r} guides {guide.name} of body {model.bodies[guide.bodies[0]].name!r}, "
                             "which components that are held or driven, joints or other points leave no freedom there; "
                             "remove this motion, or release one of them")


def _load(load, key, described, body_mesh, centre):
    tables = [None if given is None else Table.of(table_rows(given, 4, key), 0.0) for given in (load.force, load.moment)]
    point = np.zeros(3) if load.point is None else point_of(load.point, key, described, body_mesh) - centre
    return PointLoad(point, *tables)


def point_of(point, key, described, body_mesh):
    """(3,) [m] in the geometry of a point given by its name or by coordinates."""
    if not isinstance(point, str):
        return np.array(point, float)
    if point not in body_mesh.named_points:
        raise SceneError(f"{key} = {point!r} is not a physical point of {described.geometry.name}; "
                         f"it has {', '.join(body_mesh.named_points) or 'none'}")
    return body_mesh.named_points[point]
