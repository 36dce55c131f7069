"""Where methods stop being right, and whether a scene comes near: `hybrid check` warns of it, a run says it first.

Each limit is a generator of texts (none or one, a body) over (scene, model), with the number at which it starts; the
atlas of failures (`hybrid.study.failure`) has seen what happens beyond it, and tests hold the two together. A text
names the value, the limit and the remedy.
"""

from hybrid.monitors.limits import contact, soil, stepping

LIMITS = (*soil.LIMITS, *contact.LIMITS, *stepping.LIMITS)


def near(scene, model):
    """Texts about the limits that a `scene` and its Model come near."""
    return tuple(text for limit in LIMITS for text in limit(scene, model))
