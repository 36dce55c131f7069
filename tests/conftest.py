import os
import signal
from pathlib import Path

# Before numba reads it: two threads are compared even on a machine of one processor.
os.environ.setdefault("NUMBA_NUM_THREADS", str(max(2, os.cpu_count() or 1)))

import numba
import pytest


def pytest_configure():
    """Processes of tests side by side share the processors, instead of each taking all of them."""
    workers = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", 1))
    numba.set_num_threads(max(1, numba.config.NUMBA_NUM_THREADS // workers))


@pytest.fixture(scope="session")
def geometry():
    """Folder of the .geo files."""
    return Path(__file__).parents[1] / "geometry"


@pytest.fixture(autouse=True)
def signals_are_not_ignored():
    """They are where a shell or nohup started the tests in the background, and a program would inherit that."""
    ignored = {signal.SIGINT: signal.default_int_handler, signal.SIGHUP: signal.SIG_DFL}
    before = {number: signal.getsignal(number) for number in ignored}
    for number, handler in ignored.items():
        if before[number] is signal.SIG_IGN:
            signal.signal(number, handler)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
