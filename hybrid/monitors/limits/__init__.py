"""Limits of the methods: `hybrid check`, and the first step of a run, warn of a scene that exceeds one.

Each limit is a generator of texts (none or one, or one for each body) over (scene, model). The failure study
(`hybrid.study.failure`), or problems set up afresh (`cells`, `sand_cells`), measure what happens beyond its number, and tests hold the two together. A text names the
value, the limit and the remedy. Numbers that are merely unlikely come first (`hybrid.scene.check_sense`, `place`).
"""

from hybrid.monitors.limits import cells, contact, guided, margins, place, sand_cells, soil, stages, stepping
from hybrid.scene.check_sense import sense_notes

LIMITS = (*place.LIMITS, *soil.LIMITS, *contact.LIMITS, *cells.LIMITS, *sand_cells.LIMITS, *guided.LIMITS, *margins.LIMITS, *stages.LIMITS, *stepping.LIMITS)


def limit_warnings(scene, model):
    """Texts about numbers of a `scene` that look wrong, and about limits that it exceeds with its Model."""
    return *sense_notes(scene), *(text for limit in LIMITS for text in limit(scene, model))
