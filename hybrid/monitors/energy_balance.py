"""Energy that a run gains from nothing, or loses in one step without being asked to."""


class Gain:
    """Says once each when there is energy out of nothing, and when a step loses most of it without being asked to, as
    happens where an impact falls into one step."""

    LIMIT = 0.25    # of the most that ever was kinetic, elastic and in contact springs
    LOSS = 0.5      # of the same, in one step; 0.3 is the most in 200 runs whose steps resolve contact

    def __init__(self):
        self._said, self._lost, self._held, self._before = False, False, 0.0, 0.0

    def notes(self, time, energy, damped=False):
        """Texts (none or one) about the state at `time` [s]; energy: `energies` with their "error"; damped: whether the
        scheme is meant to lose some, or time is only the order of events."""
        gain, loss = energy["error"], self._before - energy["error"]
        self._before = gain
        self._held = held = max(self._held, energy["kinetic"] + energy["elastic"] + energy["contact"])
        if not self._said and gain > self.LIMIT * held > 0:
            self._said = True
            return (f"energy out of nothing: at t = {time:.4g} s there are {gain:.3g} J too many, {gain / held:.0%} of "
                    f"what moves, soil and contact hold (limit {self.LIMIT:.0%}). {_REMEDY}",)
        if not self._lost and not damped and loss > self.LOSS * held > 0:
            self._lost = True
            return (f"energy into nothing: in the step to t = {time:.4g} s {loss:.3g} J are lost, {loss / held:.0%} of "
                    f"what moves, soil and contact hold (limit {self.LOSS:.0%}). {_REMEDY}",)
        return ()


_REMEDY = ("Contact comes and goes faster than the step resolves; use a smaller time.step, time.accuracy = 1e-3, a "
           "lower body.penalty, or a scheme that damps")
