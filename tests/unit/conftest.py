import pytest
from small_scene import SCENE

from hybrid.scene.file import load_scene


@pytest.fixture
def path(tmp_path):
    (tmp_path / "ball.geo").write_text("// only has to exist")
    file = tmp_path / "small.toml"
    file.write_text(SCENE)
    return file


@pytest.fixture
def scene(path):
    return load_scene(path)
