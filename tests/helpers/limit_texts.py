"""Texts of one limit about a scene."""

from hybrid.setup.build import build


def limit_texts(limit, scene):
    """Warnings of a limit (`hybrid.monitors.limits`) about a Scene."""
    simulation = build(scene)
    return list(limit(simulation.scene, simulation.model))
