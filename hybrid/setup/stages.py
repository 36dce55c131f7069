"""Motions and loads of a body in the stages of a scene, as the model has them."""

import numpy as np

from hybrid.body.guides import Guide, PointLoad, StageControl
from hybrid.body.rigid import FREEDOMS
from hybrid.body.table import Table
from hybrid.runtime.errors import SceneError
from hybrid.scene.stage import table_rows


def stage_controls(stages, described, body_mesh, centre):
    """StageControl of each of the scene's `stages` for a body, empty where no stage changes anything of it.

    centre: (3,) [m] of its mass in the geometry. Raises SceneError for points that the geometry does not have.
    """
    def own(items):
        return [item for item in items if item.body in (None, described.name)]

    controls = [StageControl(
        released=np.isin(FREEDOMS, [name for motion in own(stage.motions) for name in motion.free]),
        held=np.isin(FREEDOMS, [name for motion in own(stage.motions) for name in motion.held]),
        guides=tuple(_guide(motion) for motion in own(stage.motions) if motion.component),
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
