"""Steps of a built simulation with what a study counts of them."""

from hybrid.bench import soils


def stepped(simulation, after=lambda record: None):
    """(Records of all its steps, wall time [s] of them); `after` is called with every record, off the clock. Raises
    StepError where one fails."""
    records, seconds = soils.stepped(simulation, after=after)
    return records, sum(seconds)


def unknowns(simulation):
    """Of soil and bodies together."""
    modelled = simulation.sheet()["modelled"]
    return modelled["soil unknowns"] + modelled["body unknowns"]


def iterations(records):
    """Newton iterations of all steps."""
    return sum(record.iterations for record in records)
