"""The stages of a scene: periods of time with the motions and loads of bodies in each."""

import csv
import math
from pathlib import Path

from hybrid.runtime.errors import SceneError
from hybrid.scene.body import Freedom, Vector
from hybrid.scene.table import key, table

Pairs = tuple[tuple[float, float], ...]
Rows = tuple[tuple[float, float, float, float], ...]
LONGEST = 16 * 2**20    # bytes of a file with a table of time
TIMES = "a list of [time, value], or the path of a CSV file with these columns; times count from the start of the stage"


@table
class Motion:
    """What guides do to components of a body in one stage, instead of what body.held, body.driven and stage.held say.
    Translations are those of the centre of mass, or of a point that goes with the body, and is then all that is guided.

    A driven component is one `component` with a `velocity` or a `displacement`. Between the times of a table values are
    linear; before its first and after its last time they stay. A displacement is relative to its first value and changes at
    a constant velocity between two times.
    """

    body: str | None = key("name of the body; left out: the only one", default=None)
    free: tuple[Freedom, ...] = key("components that are released", default=())
    held: tuple[Freedom, ...] = key("components that do not change", default=())
    component: Freedom | None = key("component that is driven", default=None)
    point: str | Vector | None = key(
        "whose translations are held or driven: name of a physical point of the geometry, or three coordinates of the "
        "geometry; left out: the centre of mass", "m", default=None)
    velocity: float | Pairs | Path | None = key(f"of that component: one number, {TIMES}", "m/s, rad/s", default=None)
    displacement: Pairs | Path | None = key(f"of that component: {TIMES}", "m, deg", default=None)


@table
class Load:
    """A force and a moment on a body in one stage, along the axes of space.

    The point goes with the body. Between the times of a table values are linear; before its first and after its last time
    they stay.
    """

    body: str | None = key("name of the body; left out: the only one", default=None)
    point: str | Vector | None = key(
        "where the force acts: name of a physical point of the geometry, or three coordinates of the geometry; left out: "
        "the centre of mass", "m", default=None)
    force: Vector | Rows | Path | None = key(
        "three numbers, a list of [time, x, y, z], or the path of a CSV file with these columns; times count from the start "
        "of the stage; in half or quarter models that on the part that is modelled", "N", default=None)
    moment: Vector | Rows | Path | None = key("the same for a moment", "N m", default=None, also=("torque",))


@table
class Stage:
    """A period of time."""

    name: str = key("label of the stage in the output")
    steps: int = key("outer steps", "-", at_least=1, remedy="remove the stage to leave it out",
                     also=("duration", "time"))
    step: float | None = key("duration of each outer step; left out: time.step", "s", default=None, above=0,
                             remedy="leave it out for time.step")
    pull: bool = key("whether pull lines act; their far ends stand still where not", default=True)
    held: tuple[Freedom, ...] = key("translations and rotations of all bodies that stay as they are in this stage, "
                                    "driven ones too", default=())
    gravity: tuple[float, float] = key("shares of gravity that act at the start and at the end of the stage, linear in "
                                       "between", "-", default=(1.0, 1.0), at_least=0, at_most=10,
                                       remedy="[0.0, 1.0] turns gravity on, leave it out for all of it")
    beta: float | None = key("β of Newmark's scheme in this stage, such as that of a dissipative pair to settle with; "
                             "left out: that of [time]", "-", default=None)
    gamma: float | None = key("γ of that pair; left out: that of [time]", "-", default=None)
    motions: tuple[Motion, ...] = key("components of bodies that are released, held or driven in this stage", default=(),
                                      name="motion")
    loads: tuple[Load, ...] = key("forces and moments on bodies in this stage", default=(), name="load")


def table_rows(value, columns, path):
    """Rows (time, values...) of a table of time: of a number or numbers that are constant, of rows, or of a CSV file.

    columns: numbers in a row, with the time; path: key in the scene. Raises SceneError for a file that is no such table and
    for times that do not increase.
    """
    if isinstance(value, float):
        return ((0.0, value),)
    if isinstance(value, tuple) and value and isinstance(value[0], float):
        return ((0.0, *value),)
    rows = csv_rows(value, (columns,), path) if isinstance(value, Path) else value
    if not rows:
        raise SceneError(f"{path} = {value}: must be a table with at least one row; give [time, value] rows")
    for before, after in zip(rows, rows[1:]):
        if after[0] <= before[0]:
            raise SceneError(f"{path}: time {after[0]:g} s follows {before[0]:g} s, but times must increase; sort the rows, "
                             "and give a jump two times that differ by less than a step")
    return rows


def csv_rows(file, columns, path, first="the time first"):
    """Rows of a CSV file with as many numbers each as one of `columns`; a first line that is no numbers is a heading, lines
    that begin with # are comments."""
    count = " or ".join(map(str, columns))
    try:
        if file.stat().st_size > LONGEST:
            raise SceneError(f"{path} = {file}: has {file.stat().st_size} bytes, limit {LONGEST}; thin it out")
        lines = list(csv.reader(line for line in file.read_text(encoding="utf-8-sig").splitlines()
                                if line.strip() and not line.lstrip().startswith("#")))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"{path} = {file}: cannot be read ({reason}); give a CSV file with {count} columns") from None
    rows = []
    for number, line in enumerate(lines):
        values = _numbers(line)
        if values is None and number == 0:
            continue
        if values is None or len(values) not in columns or rows and len(values) != len(rows[0]):
            raise SceneError(f"{path} = {file}: line {','.join(line)[:60]!r} must have {count} finite numbers with commas "
                             f"between them, {first}")
        rows.append(values)
    return tuple(rows)


def _numbers(texts):
    """Finite numbers of a line, None where one is none."""
    try:
        values = tuple(map(float, texts))
    except ValueError:
        return None
    return values if all(map(math.isfinite, values)) and max(map(abs, values)) < 1e30 else None
