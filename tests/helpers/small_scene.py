"""A small valid scene file, and the messages of SceneError for variants of it with a fault."""

import pytest

from hybrid.runtime.errors import SceneError
from hybrid.scene.file import load_scene

SCENE = """
[grid.x]
start = 0
end = 4
size = 0.5
fine = [1, 2]
[grid.y]
nodes = [0, 1, 2.5]
[grid.z]
start = -2.0
end = 1.0
size = 0.5
[grid.faces]
z_min = "fixed"
[soil]
top = 0.0
[soil.material]
relative_density = 38
[[body]]
name = "ball"
geometry = "ball.geo"
density = 7850
held = ["y", "rx", "rz"]
[body.parameters]
radius = 1
[body.pull]
point = "eye"
velocity = [0.5, 0, 0]
stiffness = 1e6
length = 10
[time]
step = 0.04
[[stage]]
name = "settle"
steps = 5
pull = false
[[stage]]
name = "drag"
steps = 10
"""


def refused(path, *overrides):
    """Message of the SceneError that the overrides cause, without the file name it must start with."""
    with pytest.raises(SceneError) as error:
        load_scene(path, overrides)
    head, _, message = str(error.value).partition(": ")
    assert head == str(path)
    return message
