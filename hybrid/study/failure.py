"""Where methods fail: every known way, driven through by a parameter, with the plain method and with the remedy.

The records are all there is to the figures, as in `hybrid.study.precision`. RECORDED ships with the program; the limits
that `hybrid check` warns of (`hybrid.monitors.limits`) rest on it.
"""

from pathlib import Path

from hybrid.bench.stamp import stamp
from hybrid.output.failure_map import Map, draw_atlas, draw_maps
from hybrid.runtime.errors import SceneError
from hybrid.study import cases, outcome
from hybrid.study.outcome import load

CASES = (
    # soil
    "crossing", "cuts", "cut_ghost", "locking", "locking_cells", "flow_locking", "stretch", "turning", "apex",
    "dilatancy", "softening", "plastic_step", "singular", "weightless", "resting",
    # bodies and contact
    "turns", "bounce_step", "bounce_map", "ringing", "penalty", "light", "squeezed", "chatter", "stick", "thin", "edge",
    "nails", "impact", "window")
RECORDED = Path(__file__).with_name("failure.json")


def run(names=(), quick=False, out=Path("out/failure"), resume=False, tell=print):
    """Run the cases of these names (all if none), write outcomes and figures to the folder `out`; returns outcomes.

    resume: leave out what the folder has already. Raises SceneError for an unknown name.
    """
    names = list(names) or list(CASES)
    if unknown := [name for name in names if name not in CASES]:
        raise SceneError(f"study failure {unknown[0]}: no such case; there are {', '.join(CASES)}")
    path, marks = Path(out) / "records.json", {"quick": quick, **stamp()}
    found = load(path)[1] if resume and path.is_file() else []
    known = {o.key for o in found}
    for run in cases.runs(names, quick):
        if run not in known:
            found.append(cases.observe(*run))
            outcome.save(path, marks, found)
            tell(_told(found[-1]))
    for told in draw(path, out):
        tell(told)
    return found


def draw(path, out):
    """Figures of a file of outcomes in the folder `out`: cases of one parameter, and maps over two; returns paths."""
    marks, found = load(path)
    panels = [panel(name, own) for name in CASES if (own := [o for o in found if o.case == name])]
    mark = f"commit {str(marks['commit'])[:8]}, numpy {marks['versions']['numpy']}"
    rows, maps = ([p for p in panels if len(p.parameters) == n] for n in (1, 2))
    return ([draw_atlas(Path(out) / "atlas.png", rows, mark)] if rows else []) + (
        [draw_maps(Path(out) / "maps.png", maps, mark)] if maps else [])


def panel(name, outcomes):
    """Map of a case's outcomes."""
    module = cases.case(name)
    kinds = {method: {o.setting: o.kind for o in outcomes if o.method == method} for method in module.METHODS}
    return Map(module.TITLE, module.PARAMETERS, kinds, module.DEFAULT)


def table(outcomes):
    """Rows of {case, method, a count of each kind}."""
    return [{"case": name, "method": method, **{
        kind: sum((o.case, o.method, o.kind) == (name, method, kind) for o in outcomes) for kind in outcome.KINDS}}
        for name, method in dict.fromkeys((o.case, o.method) for o in outcomes)]


def _told(o):
    setting = ", ".join(map(str, o.setting))
    return f"{o.case}, {o.method}, {setting}: {o.kind}, error {o.error:.2g}" + f"; {o.message}" * bool(o.message)
