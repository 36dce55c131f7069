"""Draft of an upright blade in sand beside the wedge of McKyes and Ali (`hybrid.study.blade`): runs plough.toml and draws
both.

The band is the theory from the friction angle of the sand in compression, 32.75 degrees, to that of the law in plane
strain, 36; its lower line has no heap, its upper one all that the blade has swept as a surcharge on the wedge.

    .venv/bin/python demos/plough.py            two minutes; the last line has draft and theory after 0.2 depths of way
    .venv/bin/python demos/plough.py out/plough a run that is there
"""

import sys
from pathlib import Path

import numpy as np

import hybrid
from hybrid.output.figures import COLOURS, figure
from hybrid.output.history import read_history
from hybrid.study.blade import draft

SCENE, OUT = Path(__file__).with_suffix(".toml"), Path("out/plough")
WEIGHT, COHESION, ANGLES = 16.52e3, 300.0, (32.75, 36.07)       # [N/m³], [Pa], [degrees] of sand of 38 %
DEPTH, WIDTH, WALL = 0.6, 0.8, np.degrees(np.arctan(0.3))       # [m], [m], [degrees] of friction on the blade


def wedge(way):
    """Draft [N] of the theory after a way [m]: (lowest, highest)."""
    low, high = ((WEIGHT, COHESION, angle) for angle in ANGLES)
    return draft(low, WALL, DEPTH, WIDTH), draft(high, WALL, DEPTH, WIDTH, way)


def measured(folder):
    """Way [m], draft of the face and of the whole body [N], after each step of a run."""
    history = read_history(folder)
    way = history["time_s"] * history["plough_vx_m_per_s"]
    return way, -history["plough_contact_face_fx_whole_N"], -history["plough_contact_fx_whole_N"]


def draw(folder):
    """Write draft.png in the folder of a run, and return the path."""
    way, face, whole = measured(folder)
    low, high = np.array([wedge(w) for w in way]).T
    with figure(Path(folder) / "draft.png") as drawing:
        axes = drawing.subplots()
        axes.fill_between(way, low / 1e3, high / 1e3, color="#dddddd", label="McKyes and Ali")
        axes.plot(way, whole / 1e3, "o-", color=COLOURS[0], label="whole blade")
        axes.plot(way, face / 1e3, "--", color=COLOURS[1], label="its face alone")
        axes.set(xlabel="way [m]", ylabel="draft [kN]", ylim=(0, None), xlim=(0, None))
        axes.legend(loc="lower right")
    return Path(folder) / "draft.png"


if __name__ == "__main__":
    if len(sys.argv) > 1:
        OUT = Path(sys.argv[1])
    else:
        hybrid.run(SCENE, OUT)
    print(draw(OUT))
    way, face, whole = measured(OUT)
    low, high = wedge(0.2 * DEPTH)
    print(f"draft after 0.2 depths of way: {np.interp(0.2 * DEPTH, way, whole) / 1e3:.1f} kN, theory {low / 1e3:.1f} to "
          f"{high / 1e3:.1f} kN")
