"""Ways that the scene drives a body, stage by stage."""

from hybrid.body.table import Table
from hybrid.scene.check_stage import components
from hybrid.scene.stage import table_rows


def travel_along(scene, described, name):
    """Farthest displacement [m] from its start to which a body is driven, or its line pulled, along an axis."""
    return max([0.0, *(place for stage in path_along(scene, described, name) for place in stage)], key=abs)


def path_along(scene, described, name):
    """[m] displacements from its start of that body in each stage: a list of those at rows of the table that drives it and
    at the end, the same as before where nothing does."""
    path, travel, axis = [], 0.0, "xyz".index(name)
    for stage in scene.stages:
        length, moved = stage.steps * scene.step_of(stage), [0.0]
        own = [motion for motion in stage.motions if motion.body in (None, described.name) and name in components(motion)]
        pulled = described.pull and stage.pull
        if own and name not in own[0].free:
            moved = driven_by(own[0], length) or moved
        elif own and pulled or not own and pulled and name not in {*stage.held, *described.held, *described.driven}:
            moved = [described.pull.velocity[axis] * length]
        elif not own and name in described.driven and name not in stage.held:
            moved = [described.velocity[axis] * length]
        path.append([travel + each for each in moved])
        travel = path[-1][-1]
    return path


def driven_by(motion, length):
    """[m] displacements by which a Motion drives its component in a stage of `length` [s], at rows of its table and at the
    end; none of one that holds."""
    if motion.component is None:
        return []
    rate = motion.velocity is not None
    table = Table.of(table_rows(motion.velocity if rate else motion.displacement, 2, "motion"), 0.0)
    times = [*table.times[(table.times > 0.0) & (table.times < length)], length]
    return [float((table.integral(0.0, time) if rate else table.at(time) - table.at(0.0))[0]) for time in times]
