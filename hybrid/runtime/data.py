"""Files shipped with the package: geometries and demo scenes.

They lie at the top of the repository, where a user looks for them. The links in `hybrid/data` lead there in a
checkout; a wheel holds the files themselves in their place (`package-data` in `pyproject.toml`).
"""

import shutil
from pathlib import Path

from hybrid.runtime.errors import SceneError

DATA = Path(__file__).resolve().parents[1] / "data"
GEOMETRY = (DATA / "geometry").resolve()    # *.geo, *.step
DEMOS = (DATA / "demos").resolve()          # scenes *.toml and scripts *.py; they name geometries as ../geometry/*.geo


def demo_titles():
    """Dict of the title, its first comment line, of each shipped scene by name."""
    titles = {}
    for path in sorted(DEMOS.glob("*.toml")):
        with open(path, encoding="utf-8") as file:
            titles[path.stem] = file.readline().strip("# \n")
    return titles


def copy_demo(name, folder):
    """Copy a shipped scene and its table to folder/demos and the geometries to folder/geometry; returns the path of the
    scene.

    Geometries that are there already are kept. Raises SceneError for an unknown name, or if the scene is there already.
    """
    if name not in demo_titles():
        raise SceneError(f"demo {name!r}: no such shipped scene; there are {', '.join(demo_titles())}")
    scene = Path(folder) / "demos" / f"{name}.toml"
    if scene.exists():
        raise SceneError(f"{scene}: exists already; remove it, or choose another folder by --to")
    try:
        for source in (DEMOS / scene.name, *DEMOS.glob(f"{name}.csv"), *GEOMETRY.iterdir()):
            target = Path(folder) / source.parent.name / source.name
            target.parent.mkdir(parents=True, exist_ok=True)
            if not target.exists():
                shutil.copyfile(source, target)
    except OSError as error:
        raise SceneError(
            f"{error.filename}: cannot be written: {error.strerror}; choose another folder by --to") from None
    return scene


def shipped_geometry(name):
    """Path of the shipped geometry of this file name; None of others, and of paths with a folder."""
    path = GEOMETRY / name
    return path if len(Path(name).parts) == 1 and path.is_file() else None


def shipped_names():
    """File names of the shipped geometries."""
    return sorted(path.name for path in GEOMETRY.iterdir() if path.suffix in (".geo", ".step"))


def shipped_hint(path):
    """Advice where a scene file does not exist: how to get the shipped scene of this name; empty if there is none."""
    name = Path(path).stem
    return f"; it is a shipped scene: copy it here with `hybrid demos {name}`" if name in demo_titles() else ""
