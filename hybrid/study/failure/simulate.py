"""Runs a scene and collects its messages."""

from hybrid.setup.build import build


def simulate(scene, **given):
    """(Simulation after all its steps, its records, its messages). given: further arguments of `build`."""
    simulation = build(scene, **given)
    records = list(simulation.steps())
    return simulation, records, messages(simulation, records)


def messages(simulation, records):
    """Warnings of the model sheet and notes of the steps, each text once."""
    warnings = simulation.sheet().get("warnings", ())
    return tuple(dict.fromkeys([*warnings, *(note for record in records for note in record.notes)]))
