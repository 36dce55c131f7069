"""Methods and tolerances that curves share: their labels in figures, and the values of a scene's tables they stand
for."""

TABLES = ("soil", "solver", "body")     # among the values of a run: tables that a scene has as well

# Values of the tables [soil] and [time]; the other keys keep their defaults.
SOILS = {
    "standard MPM": {"basis": "mpm", "domain": "none", "transfer": "increments"},
    "rigid domains": {"domain": "none"},
    "3 points an axis": {"points_per_axis": 3},
}
SCHEMES = {
    "steps, ρ∞ = 0": {},     # the default of a scene
    "steps, Newmark": {"scheme": "newmark"},
}
PUBLISHED = "published method"      # label of the curve with method = "published"
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)         # of Newton's method
LINEAR_TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-5)  # of the Krylov method, in every Newton iteration


def with_solver(values, **more):
    """`values` of a run, its table [solver] extended by `more`."""
    return {**values, "solver": {**values.get("solver", {}), **more}}


def newton_tolerances(**values):
    """Settings of a curve over Newton's tolerance; `values`: all other values of the run."""
    return [(f"{t:.0e}", with_solver(values, tolerance=t)) for t in TOLERANCES]


def krylov_tolerances(**values):
    """Settings of a curve over the Krylov tolerance, used in every Newton iteration; `values`: all others of the
    run."""
    return [(f"{t:.0e}", with_solver(values, linear_tolerance=t)) for t in LINEAR_TOLERANCES]


def few(curves, counts):
    """The first settings of some curves; counts: {curve: number of settings}."""
    return {curve: curves[curve][:count] for curve, count in counts.items()}


def transferable(values, cells, *own):
    """Settings of a run that a scene can take over, as a dict for JSON; None if the run's values include others than
    the TABLES and those named in `own`, which define the problem. cells: number of cells across the problem's
    length."""
    if set(values) - {*TABLES, *own}:
        return None
    return {"cells": cells, **{name: values.get(name, {}) for name in TABLES}}
