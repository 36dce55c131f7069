"""Names of methods as figures give them, and the values of a scene's tables that they stand for."""

TABLES = ("soil", "solver", "body")     # of a run's values, what a scene can have too

# Tables [soil] and [time]; what is not named here is the default.
SOILS = {
    "standard MPM": {"basis": "mpm", "domain": "none", "transfer": "increments"},
    "GIMP, rigid domains": {"domain": "none"},
    "GIMP, F-bar": {"fbar": True},
    "GIMP, ghost": {"ghost": 0.033},
    "3 points an axis": {"points_per_axis": 3},
    "4 points an axis": {"points_per_axis": 4},
}
SCHEMES = {
    "Newmark (1/4, 1/2)": {},
    "Newmark (0.5625, 1)": {"beta": 0.5625, "gamma": 1.0},
    "generalised α, ρ∞ = 0.8": {"scheme": "generalised-alpha"},
    "energy-momentum": {"scheme": "energy-momentum"},
}
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-9)         # of Newton's method
LINEAR_TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-5, 1e-8)  # of the Krylov method, everywhere


def with_solver(values, **more):
    """`values` of a run with `more` values of its table [solver]."""
    return {**values, "solver": {**values.get("solver", {}), **more}}


def newton_tolerances(**values):
    """Settings of a curve over Newton's tolerance, the rest of a run being `values`."""
    return [(f"{t:.0e}", with_solver(values, tolerance=t)) for t in TOLERANCES]


def krylov_tolerances(**values):
    """Settings of a curve over the Krylov method's tolerance, which is then as strict far from the solution."""
    return [(f"{t:.0e}", with_solver(values, linear_tolerance=t, loosest_tolerance=t))
            for t in LINEAR_TOLERANCES]


def few(curves, counts):
    """The first settings of some curves: {curve: how many}."""
    return {curve: curves[curve][:count] for curve, count in counts.items()}


def alike(values, cells, *own):
    """What a scene can take over from a run with so many `cells` in the length that its problem names LIKE, as JSON;
    None where the run's values have others besides TABLES and its `own`."""
    if set(values) - {*TABLES, *own}:
        return None
    return {"cells": cells, **{name: values.get(name, {}) for name in TABLES}}
