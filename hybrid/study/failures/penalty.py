"""Contact too soft and too stiff: springs in series with the soil take a share of the way, or drown its tangent.

A rigid platen presses an elastic cube by a quarter (`platen`). With the height l = 0.6 m + δ under a platen at 0.6 m,

    F = p_f E A δ = A E ln(L/l) L/l         ideal, δ = 0: 245.49 kN

so the error is about 2.7 / p_f, p_f in 1/m; a contact takes 1 / (1 + p_f L) of the way. Multipliers press the overlap
out whatever the penalty, as far as their updates go. Nothing is lost by stiffness up to 1e11 /m here, where Newton's
method only stops earlier at round-off; what impacts make of it is in `bounce_map`.
"""

from hybrid.study.cases import told
from hybrid.study.outcome import Seen
from hybrid.study.problems import platen

TITLE = "penalty too soft and too stiff"
PARAMETERS = ("penalty factor p_f [1/m]",)
MEASURE, RIGHT, WRONG = "error of the force", 0.06, 0.25
METHODS = {"penalty": {}, "augmented Lagrangian": {"enforcement": "augmented"}}
DEFAULT = "penalty"
SAYS = r"penalty .* limit 10: contact takes .*body\.penalty.*augmented"
STEPS = 10


def settings(quick=False):
    return [(p,) for p in ((2.0, 50.0) if quick else (1.0, 2.0, 5.0, 10.0, 50.0, 1e3, 1e5, 1e7, 1e9, 1e11))]


def solve(penalty, **body):
    """Seen of the platen at its lowest."""
    found = platen.press(penalty=penalty, steps=STEPS, **body)
    said = tuple(text for text in told(found.simulation, found.records) if "contact takes" in text)
    return Seen(abs(found.force / platen.IDEAL - 1), said)
