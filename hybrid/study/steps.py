"""Steps of a built simulation with what a study counts of them."""

from time import perf_counter


def stepped(simulation):
    """(Records of all its steps, wall time [s] of them). Raises StepError where one fails."""
    begin = perf_counter()
    records = list(simulation.steps())
    return records, perf_counter() - begin


def unknowns(simulation):
    """Of soil and bodies together."""
    modelled = simulation.sheet()["modelled"]
    return modelled["soil unknowns"] + modelled["body unknowns"]


def iterations(records):
    """Newton iterations of all steps."""
    return sum(record.iterations for record in records)
