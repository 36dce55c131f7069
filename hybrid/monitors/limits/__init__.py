"""Limits of the methods: `hybrid check`, and the first step of a run, warn of a scene that exceeds one.

Each limit is a generator of texts (none or one, or one for each body) over (scene, model). The failure study
(`hybrid.study.failure`), or problems set up afresh (`cells`, `clay_cells`, `sand_cells`, `footing_cells`,
`trapdoors`, `ground_cells`, `elastic_cells`, `turning`), measure what happens beyond its number, and tests hold the two
together. A text names the value, the limit and the remedy, and one about a body begins with its name, by which
`unjudged` skips bodies already reported. Numbers that are merely unlikely come first (`hybrid.scene.check_sense`, `place`).

What limits share, each from the ones above it:
    cell_size.py   excess of a load from which cells are reported, and the remedy
    start.py       heights of the soil and poses of bodies at the start
    shape.py       faces that lead a body, its width across its travel, its feet
    materials.py   material of the soil at a height; clay that stays attached
    travels.py     where bodies go, by themselves or moved by others
    loading.py     which bodies are driven or pushed into the soil, and where to
"""

from hybrid.monitors.limits import (bars, base, cells, clay_cells, contact, elastic_cells, footing_cells,
                                    ground_cells, guided, layers, margins, place, rolling, sand_cells, shear_gap, soil,
                                    stages, stepping, trapdoors, turning, uneven, unsupported, waves)
from hybrid.monitors.limits.unjudged import unjudged
from hybrid.scene.check_sense import sense_notes

MODULES = (place, unsupported, soil, layers, contact, base, rolling, cells, bars, clay_cells, sand_cells, footing_cells,
           trapdoors, ground_cells, elastic_cells, turning, guided, margins, shear_gap, stages, stepping, waves, uneven)
LIMITS = tuple(limit for module in MODULES for limit in module.LIMITS)


def limit_warnings(scene, model):
    """Texts about numbers of a `scene` that look wrong, and about limits that it exceeds with its Model."""
    messages = [text for limit in LIMITS for text in limit(scene, model)]
    return *sense_notes(scene), *messages, *unjudged(scene, model, messages)
