"""A failure mode: a small scene, the parameters that drive it to failure, and the limits that classify a run."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Mode:
    """One way in which runs fail. The docstring of `solve` explains the failure and its cause.

    title: the failure in a few words; parameters: names, with units, of the one or two parameters that drive it.
    measure: what the error is; up to `right` a run is right, up to `wrong` degraded.
    methods: {label: keyword arguments of `solve`}, the plain method first, then the remedies.
    default: label of the method that a scene gets by default; it never fails silently.
    message: regular expression that every report of this failure matches (value, limit, remedy); None if a failure of
        this mode is never reported.
    full: settings that figures show, from mild to severe: values of the parameter, tuples if there are two; quick: some
        of them.
    solve(*setting, **method): Observation of one run; raises HybridError if the run stops.
    """

    title: str
    parameters: tuple[str, ...]
    measure: str
    right: float
    wrong: float
    methods: dict[str, dict]
    default: str
    message: str | None
    full: tuple
    quick: tuple
    solve: Callable

    def settings(self, quick=False):
        """[(value of each parameter), ...]."""
        return [s if isinstance(s, tuple) else (s,) for s in (self.quick if quick else self.full)]

    def observe(self, method, setting):
        """Observation of a run, with only those messages that report this failure. Raises HybridError if it stops."""
        return self.relevant(self.solve(*setting, **self.methods[method]))

    def relevant(self, observation):
        """The Observation without messages that do not match `message`."""
        return replace(observation, messages=matching(self.message, observation.messages))


def matching(pattern, messages):
    """The messages that a regular expression matches; none if it is None."""
    return tuple(text for text in messages if pattern is not None and re.search(pattern, text))
