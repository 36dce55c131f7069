"""Locking of plastic flow: clay that flows keeps its volume, whatever its Poisson's ratio.

          |  B/2 |
          |=====|________    smooth rigid strip footing on weightless clay in plane strain, half a model, φ = 0,
          |                  E = 10⁴ s_u, ν = 0.3, pressed down until the clay flows (`hybrid.study.problems.footing`)
          |______________

Fully developed flow of von Mises' law is isochoric, and linear cells have more constraints than modes for it: the load
goes on rising with the settlement, and finer cells only rise more slowly. Exact: Prandtl's F/(B s_u) = 2 + π.
"""

from hybrid.scene import Material
from hybrid.study.outcome import Seen
from hybrid.study.problems.footing import COHESION, STIFFNESS, prandtl, press

TITLE = "locking of flow"
PARAMETERS = ("cells under half a footing",)
MEASURE, RIGHT, WRONG = "error of the load at collapse", 0.05, 0.25
METHODS = {"no F-bar": {}, "F-bar, ghost = 0.0033": {"fbar": True, "ghost": 0.0033}}
DEFAULT = "no F-bar"
SAYS = r"von-mises.*limit .*soil\.fbar"
CLAY = Material(law="von-mises", poisson=0.3, strength=COHESION, young=STIFFNESS * COHESION, density=1.0,
                cone="plane strain")


def settings(quick=False):
    return [(cells,) for cells in ((2, 1) if quick else (16, 8, 4, 2, 1))]


def solve(cells, **soil):
    """Seen of a footing with so many cells under its half."""
    exact = prandtl(0)
    found = press(0, cells, law=CLAY, steps=10, settlement=6 * exact / STIFFNESS, depth=1.0, width=2.0, **soil)
    return Seen(float(abs(found.factor[-1] / exact - 1)), tuple(text for text in found.notes if "soil.fbar" in text))
