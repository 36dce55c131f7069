from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def geometry():
    """Folder of the .geo files."""
    return Path(__file__).parents[1] / "geometry"
