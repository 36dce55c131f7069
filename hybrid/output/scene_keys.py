"""Keys of a scene as text, to tell whether a run may be continued with it: those of the physics, and settings, which may
differ.
"""

import dataclasses
import hashlib
from pathlib import Path

from hybrid.body.geometry_text import files_of
from hybrid.runtime.errors import GeometryError
from hybrid.scene import Scene
from hybrid.scene.defaults import resolve


def fingerprint(scene):
    """Keys of a scene that determine the physics of its run: {"soil.material.young": text}; geometry by content, keys
    left out as they are decided."""
    return {key: value for key, value in _keys(scene).items() if not key.startswith(_setting_keys(scene))}


def settings(scene):
    """The other keys of a scene, with which a run may be continued differently: {"output.every": text}."""
    return {key: value for key, value in _keys(scene).items() if key.startswith(_setting_keys(scene))}


def differences(saved, wanted, name):
    """Lines that list the keys in which two dicts of texts differ; `name`: what the first one belongs to."""
    keys = [key for key in sorted(saved.keys() | wanted.keys()) if saved.get(key) != wanted.get(key)]
    shown = [f"  {k}: {name} {saved.get(k, 'none')}, scene {wanted.get(k, 'none')}" for k in keys[:8]]
    return "\n".join(shown + ([f"  ... and {len(keys) - 8} more"] if len(keys) > 8 else []))


def _keys(scene):
    if isinstance(scene, Scene):
        scene, _ = resolve(scene)
    flat = {}
    _flatten("", _plain(scene), flat)
    return dict(sorted(flat.items()))


def _setting_keys(scene):
    """What the keys of settings begin with. The number of steps of the last stage is one, unless its gravity changes, over
    the whole of it."""
    stages = getattr(scene, "stages", ())
    ramps = stages and len(set(getattr(stages[-1], "gravity", ()))) > 1
    return "output.", "solver.", "soil.stray", *(() if ramps else (f"stages.{len(stages) - 1}.steps",))


def _plain(item):
    if dataclasses.is_dataclass(item):
        return {f.name: getattr(item, f.name) for f in dataclasses.fields(item)}
    return vars(item) if hasattr(item, "__dict__") and not isinstance(item, Path) else item


def _flatten(prefix, item, flat):
    item = _plain(item)
    if isinstance(item, dict):
        item = item.items()
    elif isinstance(item, (list, tuple)):
        item = enumerate(item)
    else:
        flat[prefix] = _content(item) if isinstance(item, Path) else repr(item)
        return
    for key, value in item:
        _flatten(f"{prefix}.{key}" if prefix else str(key), value, flat)


def _content(path):
    """Name and digest of a file; of a geometry with the files that it reads, as gmsh gets them."""
    path = Path(path)
    if not path.is_file():
        return path.name
    try:
        files = files_of(path) if path.suffix == ".geo" else {path.name: path.read_bytes()}
    except GeometryError:       # of a file that was never meshed
        files = {path.name: path.read_bytes()}
    return f"{path.name} (sha256 {hashlib.sha256(b'|'.join(files.values())).hexdigest()[:12]})"
