"""Calls of the observers of a run (`hybrid.output`), whose errors name the file that could not be written."""

import logging

from hybrid.output import errors_of

log = logging.getLogger("hybrid")


def notify(observers, call):
    """Call each observer: `call` is a function of it."""
    for observer in observers:
        with errors_of(observer):
            call(observer)


def finish(observers, summary, simulation, together):
    """Call `finish` of every observer, also when one of them fails; its error is raised unless the run failed. Of several
    processes that are not `together` each can only call what needs no other one."""
    failure = None
    for observer in observers:
        try:
            with errors_of(observer):
                if together:
                    observer.finish(summary, simulation)
                elif hasattr(observer, "finish_alone"):
                    observer.finish_alone(summary, simulation)
        except Exception as error:
            log.warning("%s failed at the end of the run: %s", type(observer).__name__, error)
            failure = failure or error
    if failure and summary["outcome"] == "completed":
        raise failure
