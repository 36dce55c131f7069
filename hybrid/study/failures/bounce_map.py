"""Steps and penalties: the stiffer the contact, the shorter the step that sees it come and go.

The bounce of `bounce_step`, whose time of contact T_c = π √(m / (p_f E A)) is 70 ms at p_f E = 1 MPa/m, over step and
penalty: what fails lies above the line Δt = T_c / 2.
"""

from hybrid.study.failures import bounce_step

TITLE = "step and penalty"
PARAMETERS = ("step Δt [s]", "penalty p_f E [Pa/m]")
MEASURE, RIGHT, WRONG = bounce_step.MEASURE, bounce_step.RIGHT, bounce_step.WRONG
METHODS = {"Newmark": {}, "time.accuracy": {"accuracy": 1e-3}}
DEFAULT = "Newmark"
SAYS = bounce_step.SAYS
STARTS = (0.5, 0.9)


def settings(quick=False):
    if quick:
        return [(0.01, 1e6), (0.1, 1e8)]
    return [(step, stiffness) for stiffness in (1e6, 1e7, 1e8, 1e9) for step in (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)]


def solve(step, stiffness, **time):
    """Seen of the worse of two bounces."""
    return bounce_step.worst([bounce_step.bounce(step, start, stiffness, **time) for start in STARTS])
