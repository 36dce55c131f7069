"""Limits of the methods: `hybrid check`, and the first step of a run, warn of a scene that exceeds one.

Each limit is a generator of texts (none or one, or one for each body) over (scene, model). The failure study
(`hybrid.study.failure`) measures what happens beyond its number, and tests hold the two together. A text names the
value, the limit and the remedy.
"""

from hybrid.monitors.limits import contact, soil, stepping

LIMITS = (*soil.LIMITS, *contact.LIMITS, *stepping.LIMITS)


def limit_warnings(scene, model):
    """Texts about the limits that a `scene` with its Model exceeds."""
    return tuple(text for limit in LIMITS for text in limit(scene, model))
