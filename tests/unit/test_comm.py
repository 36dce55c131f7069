"""Reductions over points: their values, and that halves of the points in two processes give what all of them give."""

import ast
from dataclasses import replace
from pathlib import Path
from threading import Barrier, Thread, get_ident
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.runtime import comm
from hybrid.state import Points
from hybrid.step import energy, loads


def test_values_and_what_nothing_gives():
    values = np.array([3.0, 0.0, 4.0])
    assert comm.total(values) == 7.0 and comm.total(np.ones((4, 2))).tolist() == [4.0, 4.0]
    assert comm.count(values) == 2 and comm.anywhere(values) and not comm.anywhere(values < 0)
    assert comm.number(values) == 3 and comm.norm(values) == 5.0 and comm.largest(values) == 4.0
    assert comm.maximum(-1 - values) == -1.0 and comm.minimum(values) == 0.0 and comm.largest(-1 - values) == 0.0
    none = values[:0]
    assert [f(none) for f in (comm.total, comm.count, comm.number, comm.largest, comm.norm)] == [0.0] * 5
    assert (comm.maximum(none), comm.minimum(none, 2.0), comm.anywhere(none)) == (0.0, 2.0, False)


@pytest.fixture
def processes(monkeypatch):
    """processes(function, *halves): results of function(half), each in a thread that stands for a process."""
    def run(function, *halves):
        barrier, shared, local = Barrier(len(halves), timeout=30), [None] * len(halves), {}
        results = [None] * len(halves)

        def over_processes(mine, combine):
            shared[local[get_ident()]] = mine
            barrier.wait()
            found = shared[0]
            for other in shared[1:]:
                found = combine(found, other)
            barrier.wait()
            return found

        def work(rank):
            local[get_ident()] = rank
            results[rank] = function(halves[rank])

        monkeypatch.setattr(comm, "_over_processes", over_processes)
        threads = [Thread(target=work, args=(rank,)) for rank in range(len(halves))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        monkeypatch.undo()
        return results
    return run


@pytest.mark.parametrize("name", ["total", "count", "number", "largest", "maximum", "minimum", "anywhere", "norm"])
def test_every_process_gets_the_result_of_all(processes, name):
    values, function = np.random.default_rng(1).random(11), getattr(comm, name)
    assert processes(function, values[:4], values[4:]) == pytest.approx([function(values)] * 2, rel=1e-15)
    assert processes(function, values[:0], values) == pytest.approx([function(values)] * 2, rel=1e-15)


def points(n, seed=2):
    rng = np.random.default_rng(seed)
    vectors, matrices = (lambda: rng.standard_normal((n, 3))), (lambda: rng.standard_normal((n, 3, 3)))
    return Points(vectors(), vectors(), vectors(), np.abs(vectors()), matrices(), matrices(), matrices(), rng.random(n))


def part(points, chosen):
    return replace(points, **{name: value[chosen] for name, value in vars(points).items() if value is not None})


def test_energies_and_works_of_soil_are_those_of_all_processes(processes):
    soil, mass = points(9), np.random.default_rng(3).random(9)
    initial, gravity = np.random.default_rng(4).random((9, 3)), np.array([0.0, 0.0, -9.81])

    def found(chosen):
        constants = SimpleNamespace(mass=mass[chosen], position=initial[chosen])
        model = SimpleNamespace(gravity=gravity, scheme=SimpleNamespace(inertia=True), soil=SimpleNamespace(
            constants=constants, stored_energy=lambda given: float(comm.total(given.plastic_strain))))
        ramp = loads.Loads(gravity).during(0.0, 2.0, (0.0, 1.0))
        own = part(soil, chosen)
        return [*energy.soil_energies(model, own).values(),
                ramp.work(0.5, 1.0, mass[chosen], initial[chosen], own.velocity)]

    every = found(slice(None))
    assert np.abs(every).min() > 0.1
    for each in processes(found, slice(0, 3), slice(3, None)):
        assert each == pytest.approx(every, rel=1e-13)


# ------------------------------------------------------------------ who reduces arrays of points otherwise

PACKAGE = Path(comm.__file__).parents[1]
REDUCTIONS = {"sum", "max", "min", "mean", "any", "all", "count_nonzero", "argmax", "argmin", "norm", "median", "ptp"}
ARRAYS = set("""half half_width deformation b_elastic stress plastic_strain affine inactive inverted mass volume gap
    slip contact_pressure touching clearance active parameters strength""".split())
LOCAL = {   # module: why a process may do it by itself
    "soil/lost_points.py": "nothing to change among its own points",
    "contact/contact_points.py": "whether points have domains at all",
    "contact/interface_shares.py": "contact points of all processes, given together",
    "step/joint_terms.py": "rows of joints, which every process has",
    "step/joint_rates.py": "the same",
    "contact/body_to_body.py": "places on bodies, which every process has",
    "step/pair_terms.py": "the same",
    "step/flight.py": "the same",
    "monitors/limits/soil.py": "point that a message names",
    "monitors/missed_contact.py": "vertex of a body among its own points",
    "setup/law.py": "refusal of its own points",
}


def jitted(function):
    return any("njit" in ast.unparse(decorator) for decorator in function.decorator_list)


def reductions(node, function=""):
    """(function, source) of each reduction over the first axis, or all, of what is named like an array of points."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef):
            if not jitted(child):
                yield from reductions(child, child.name)
            continue
        yield from reductions(child, function)
        if not isinstance(child, ast.Call) or not isinstance(child.func, ast.Attribute):
            continue
        axes = [ast.unparse(keyword.value) for keyword in child.keywords if keyword.arg == "axis"]
        names = {getattr(inner, "attr", getattr(inner, "id", "")) for inner in ast.walk(child)} & ARRAYS
        source = ast.unparse(child)
        if child.func.attr in REDUCTIONS and names and axes in ([], ["0"]) and not source.startswith("comm."):
            yield function, source


def test_points_are_reduced_by_comm_alone():
    found = {}
    for folder in ("soil", "contact", "step", "monitors", "setup", "linalg", "."):
        for path in sorted((PACKAGE / folder).glob("*.py" if folder == "." else "**/*.py")):
            for function, source in reductions(ast.parse(path.read_text(encoding="utf-8"))):
                found.setdefault(str(path.relative_to(PACKAGE)), []).append((function, source))
    assert {place: sources for place, sources in found.items() if place not in LOCAL} == {}


def test_a_reduction_by_numpy_is_found():
    source = "def f(points):\n    return np.max(points.mass)\n\ndef g(points):\n    return points.position.sum(axis=1)"
    assert list(reductions(ast.parse(source))) == [("f", "np.max(points.mass)")]
