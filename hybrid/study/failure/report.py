"""Figures and tables of the study of failure, made from a file of outcomes only.

RECORDED is the file that ships with the program; the limits that `hybrid check` warns of (`hybrid.monitors.limits`) are
derived from it.
"""

from pathlib import Path

from hybrid.output.failure_map import Map, draw_one_parameter_maps, draw_two_parameter_maps
from hybrid.study.failure.outcome import KINDS, load
from hybrid.study.failure.registry import MODES

RECORDED = Path(__file__).with_name("failure.json")


def draw(path, out):
    """Draw the figures of a file of outcomes in the folder `out`: modes of one parameter, and maps over two; returns
    their paths."""
    marks, outcomes = load(path)
    panels = [panel(name, own) for name in MODES if (own := [o for o in outcomes if o.case == name])]
    mark = f"commit {str(marks['commit'])[:8]}, numpy {marks['versions']['numpy']}"
    rows, maps = ([p for p in panels if len(p.parameters) == n] for n in (1, 2))
    return ([draw_one_parameter_maps(Path(out) / "atlas.png", rows, mark)] if rows else []) + (
        [draw_two_parameter_maps(Path(out) / "maps.png", maps, mark)] if maps else [])


def panel(name, outcomes):
    """Map of the outcomes of a mode."""
    mode = MODES[name]
    kinds = {method: {o.setting: o.kind for o in outcomes if o.method == method} for method in mode.methods}
    return Map(mode.title, mode.parameters, kinds, mode.default)


def table(outcomes):
    """Rows of {case, method, number of outcomes of each kind}."""
    return [{"case": name, "method": method, **{
        kind: sum((o.case, o.method, o.kind) == (name, method, kind) for o in outcomes) for kind in KINDS}}
        for name, method in dict.fromkeys((o.case, o.method) for o in outcomes)]


def listing():
    """Rows of {name, title} of all failure modes."""
    return [{"name": name, "title": mode.title} for name, mode in MODES.items()]


def line(o):
    """Text of an outcome."""
    setting = ", ".join(map(str, o.setting))
    return f"{o.case}, {o.method}, {setting}: {o.kind}, error {o.error:.2g}" + f"; {o.message}" * bool(o.message)
