"""From a file of gmsh or CAD to the tetrahedra and the contact surface of a rigid body.

A geometry declares its parameters with DefineConstant under the name "Parameters/..." (lengths in metres), a
physical volume "body", a physical surface "contact", and where a body is cut by a symmetry plane a physical
surface "symmetry". Physical points are named places, such as the point where a body is pulled. Physical surfaces of
other names are parts whose contact forces are reported apart (`hybrid.body.parts`), physical volumes of other names may
have densities of their own. Other files (.step, .iges, .brep, .stl, .msh) need no groups: these are made
(`hybrid.body.bare_files`). A `scale` makes metres of the coordinates of any file, and a body that is drawn as a whole is
cut in half, by gmsh if it is a solid and by `hybrid.body.half` if it is a mesh.

A geometry file is a program. Its text is checked (`hybrid.body.geometry_text`), and gmsh reads it in a process of its
own (`hybrid.body.mesh_worker`) that is confined to copies of the checked files (`hybrid.runtime.sandbox`), within
limits of time, memory and size. The mesh comes back as arrays; `hybrid.body.solid` checks it.
"""

import dataclasses
import functools
import json
import logging
import math
import os
import signal
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from hybrid.body import geometry_text
from hybrid.body.half import half_of
from hybrid.body.solid import TetMesh, boundary_faces, oriented, smoothed, validate
from hybrid.body.symmetry import AXES
from hybrid.runtime.errors import GeometryError
from hybrid.runtime.sandbox import offered, shortcoming

log = logging.getLogger("hybrid")
SECONDS, MEMORY, TETRAHEDRA = 60, 4 << 30, 500_000  # limits: processor time [s], address space [bytes], mesh
WAITING = 5                                         # limit of time that passes, in those of processor time
FACTOR = "HYBRID_MESH_LIMIT"                        # variable of the environment: these limits times a number
REMEDY = (f"make the elements larger (parameter size, Mesh.MeshSizeMin) or the shape simpler; {FACTOR}=10 in the "
          "environment makes the limits of meshing ten times as large")
START = "import sys; sys.path[:] = {path!r}; from hybrid.body.mesh_worker import main; main({request!r})"
REST = "rest"                                       # part of a surface that is in no other one, where it has parts
KEPT = 32                                           # meshes of this process, for scenes that share a body
versions = {}                                       # of gmsh, once it has been used


def generate(path, parameters=None, size=None, scale=1.0, symmetry=None, volumes=()):
    """Mesh the geometry file at `path` and return a validated TetMesh.

    `parameters` maps names declared by the file to numbers [SI units; angles in the unit that the file states]; a file of
    CAD has the parameter `size`. `size` [m] is the edge length of the tetrahedra, short for the parameter of that name.
    `scale` [-] multiplies all coordinates: 0.001 for triangles in millimetres. `symmetry` "x" or "y": the half on the
    positive side of the plane x = 0 or y = 0. `volumes`: names of the physical volumes that the body consists of, instead
    of "body". Raises GeometryError with the reason when the file, a parameter, a group or the mesh is unusable or above
    a limit.
    """
    path = Path(path)
    parameters = dict(parameters or {})
    if size is not None:
        parameters["size"] = size
    if symmetry not in (None, *AXES):
        raise GeometryError(f"geometry {path}: symmetry = {symmetry!r} must be one of {', '.join(map(repr, AXES))}")
    check_values(path, {**parameters, "scale": scale})
    files = geometry_text.files_of(path)
    given = tuple(sorted((name, float(value)) for name, value in parameters.items()))
    mesh = _mesh(path, tuple(files.items()), given, float(scale), symmetry, tuple(volumes))
    copies = {name: value.copy() for name, value in vars(mesh).items() if isinstance(value, np.ndarray)}
    points = {name: place.copy() for name, place in mesh.named_points.items()}
    return dataclasses.replace(mesh, named_points=points, **copies)


@functools.lru_cache(KEPT)
def _mesh(path, files, parameters, scale, symmetry, volumes):
    """TetMesh of the files ((name, bytes), ...) with these parameters ((name, value), ...)."""
    if not offered():
        log.warning("geometry %s: gmsh is %s", path, shortcoming())
    answer = in_child(path, dict(files), dict(parameters), scale=scale, symmetry=symmetry, volumes=volumes)
    answer["regions"] = tuple(answer["regions"].tolist())
    named = [answer.pop(name) for name in ("parts", "part_triangles", "part_numbers")]
    names, places = answer.pop("point_names").tolist(), answer.pop("point_places")
    if scale != 1.0:
        answer["points"], places = scale * answer["points"], scale * places
    cut = path.suffix.lower() in geometry_text.SOLIDS
    if "contact" not in answer:
        answer["contact"] = _outside(answer["tets"], answer["symmetry"])
    answer["parts"], answer["part"] = _parts(answer["contact"], *named)
    mesh = oriented(TetMesh(named_points=dict(zip(names, places)), name=path.stem, **answer))
    validate(mesh)
    if symmetry and not cut:
        mesh = half_of(smoothed(mesh), symmetry)
        validate(mesh)
    if symmetry and not len(mesh.symmetry):
        raise GeometryError(f"geometry {path}: no face of it lies in the plane {symmetry} = 0, which symmetry = "
                            f"'{symmetry}' cuts it by; move the plane of symmetry of the drawing there")
    return smoothed(mesh)


def _outside(tets, symmetry):
    """Faces (t, 3) around the tetrahedra but those of the cut face."""
    cut = {tuple(sorted(face)) for face in symmetry.tolist()}
    faces = boundary_faces(tets)
    return faces[[tuple(sorted(face)) not in cut for face in faces.tolist()]]


def _parts(contact, names, triangles, numbers):
    """Names of the parts of the contact surface, and the number (t,) of that of each of its triangles `contact` (t, 3); (),
    None without any. Parts without a triangle there are left out; triangles in none are the part REST, the last one."""
    known = dict(zip(map(tuple, np.sort(triangles, axis=1).tolist()), numbers.tolist()))
    part = np.array([known.get(face, len(names)) for face in map(tuple, np.sort(contact, axis=1).tolist())])
    used, part = np.unique(part, return_inverse=True)
    if not (used < len(names)).any():
        return (), None
    return tuple([*names.tolist(), REST][k] for k in used), part.reshape(-1)


def check_values(path, parameters):
    """Refuse values of parameters that are not finite numbers, and a size that is not positive."""
    for name, value in parameters.items():
        number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
        if not number or not math.isfinite(value):
            raise GeometryError(f"geometry {path}: parameter '{name}' = {value!r} must be a finite number")
    for name, unit in (("size", " m"), ("scale", "")):
        if parameters.get(name, 1.0) <= 0.0:
            raise GeometryError(f"geometry {path}: {name} = {parameters[name]}{unit} must be positive")


def in_child(path, files, parameters, **more):
    """Arrays {name: array} that a confined process of its own answers with; GeometryError if it gives none."""
    factor = _factor()
    seconds = max(1, math.ceil(SECONDS * factor))
    request = {"path": str(path), "file": next(iter(files)), "parameters": parameters, "seconds": seconds,
               "memory": int(MEMORY * factor), "tetrahedra": int(TETRAHEDRA * factor), "remedy": REMEDY, **more}
    try:
        with tempfile.TemporaryDirectory(prefix="hybrid-mesh-") as scratch:
            folder = Path(scratch)
            (folder / "geometry").mkdir()
            for name, content in files.items():
                (folder / "geometry" / name).write_bytes(content)
            code = _run(request, folder, WAITING * seconds)
            answer = _answer(folder / "answer.npz")
            messages = _end_of(folder / "messages")
    except OSError as error:
        place = error.filename or "the folder for temporary files"
        raise GeometryError(f"geometry {path}: cannot be meshed, as {place} gives: "
                            f"{error.strerror or error}; name a folder with free space by TMPDIR") from None
    if answer is None:
        raise GeometryError(f"geometry {path}: {_why(code, messages, request)}")
    if "error" in answer:
        raise GeometryError(str(answer["error"]).replace(f"{os.path.realpath(scratch)}/geometry/", ""))
    versions["gmsh"] = str(answer.pop("version"))
    return answer


def _factor():
    text = os.environ.get(FACTOR, "1")
    try:
        factor = float(text)
    except ValueError:
        factor = math.nan
    if not 0.0 < factor <= 1e4:
        raise GeometryError(f"{FACTOR}={text}: must be a number above 0, at most 1e4, that multiplies the limits of "
                            f"meshing: {SECONDS} s, {MEMORY / 2**30:g} GiB and {TETRAHEDRA} tetrahedra")
    return factor


def _run(request, folder, patience):
    """Exit code of the worker for this request, None if it had to be ended after `patience` seconds."""
    # The modules of this very program, whatever the environment and the working folder hold.
    path = [os.path.abspath(place) for place in (str(Path(__file__).parents[2]), *sys.path) if place]
    command = [sys.executable or os.path.realpath("/proc/self/exe"), "-I", "-S", "-B", "-c",
               START.format(path=path, request=json.dumps(request))]
    environment = {name: os.environ[name] for name in ("LD_LIBRARY_PATH", "SYSTEMROOT") if name in os.environ}
    environment.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
    environment.update(dict.fromkeys(("HOME", "NUMBA_CACHE_DIR"), str(folder)))
    child = None
    try:
        with open(folder / "messages", "wb") as messages:
            # In a session of its own: an interrupt from the keyboard comes here, and ends the child from here.
            child = subprocess.Popen(command, cwd=folder, env=environment, start_new_session=True, stderr=messages,
                                     stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        return child.wait(patience)
    except subprocess.TimeoutExpired:
        return None
    finally:
        if child and child.poll() is None:
            os.killpg(child.pid, signal.SIGKILL)
            child.wait()


def _answer(path):
    """Arrays of the worker's answer, None if there is none or it is cut."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except (EOFError, ValueError, KeyError, FileNotFoundError, zipfile.BadZipFile):
        return None


def _end_of(path):
    """Last lines of a text that a geometry may have made long."""
    with open(path, "rb") as file:
        file.seek(max(0, path.stat().st_size - 4000))
        return file.read().decode(errors="replace")


def _why(code, messages, request):
    """Reason of a worker without an answer."""
    last = (messages.strip().splitlines() or [""])[-1][:300]
    if code is None or code == -signal.SIGXCPU:
        return (f"meshing took more than {request['seconds']} s of processor time, the limit, or waited {WAITING} "
                f"times as long; look for a loop without end, or {REMEDY}")
    if "bad_alloc" in last or "MemoryError" in messages or "llocat" in last:
        return f"meshing needed more than {request['memory'] / 2**30:.3g} GiB of memory, the limit; {REMEDY}"
    if "Traceback" in messages:
        return f"meshing failed: {last}; see that gmsh can be used from {sys.executable}"
    if code < 0:
        name = signal.Signals(-code).name
        return f"gmsh crashed ({name}{': ' * bool(last)}{last}); check the shape for faces that cross or have no extent"
    return (f"gmsh ended without a mesh (exit code {code}{': ' * bool(last)}{last}); "
            "delete statements that end it, such as Exit and Abort")
