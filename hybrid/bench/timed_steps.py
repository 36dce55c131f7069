"""Takes the steps of a simulation and times them; sizes of a model; growth of a cost with the size."""

from time import perf_counter

import numpy as np

from hybrid.bench.scenes import ELASTIC, SAND, block
from hybrid.setup.build import build


def warm():
    """Compile the kernels, so that no measured time includes it."""
    for material in (ELASTIC, SAND):
        list(build(block((3, 3, 2), 0.1, material, (0.1, 50.0), steps=1)).steps())


def timed_steps(simulation, *, after=lambda record: None, clock=perf_counter):
    """(Records of all steps, time [s] of each).

    clock: perf_counter for wall time, process_time for the time of the processor, which other programs on the machine
    hardly change; after(record) is called after each step; its time is not counted. Raises StepError if a step fails.
    """
    records, seconds, begin = [], [], clock()
    for record in simulation.steps():
        seconds.append(clock() - begin)
        records.append(record)
        after(record)
        begin = clock()
    return records, seconds


def newton_iterations(records):
    """Newton iterations of all steps."""
    return sum(record.iterations for record in records)


def sizes(simulation):
    """{"points", "unknowns", "entries" of the soil block}, as the model sheet gives them."""
    modelled = simulation.sheet()["modelled"]
    return {"points": modelled["material points"], "unknowns": modelled["soil unknowns"] + modelled["body unknowns"],
            "entries": modelled["entries of the soil block"]}


def exponent(unknowns, values):
    """Power of the number of unknowns with which `values` grow, by least squares."""
    return float(np.polyfit(np.log(unknowns), np.log(values), 1)[0])
