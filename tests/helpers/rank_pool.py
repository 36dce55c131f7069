"""Processes that stay: mpirun starts each number of them once, and they call one function after another, such as the
command `hybrid`, with their kernels loaded. As a program, one of these processes."""

import atexit
import json
import shutil
import socket
import subprocess
import sys
import tempfile
from contextlib import redirect_stderr
from functools import cache
from importlib import import_module
from io import StringIO
from pathlib import Path

from hybrid.runtime import ranks

START, RUN = 60.0, 300.0    # [s] given to all processes to start, and to a call


def call(number, function, *arguments):
    """[(result, stderr)] of a function "module.name" that so many processes call together; arguments and results are
    those that JSON has, or paths."""
    streams = _pool(number)
    for stream in streams:
        print(json.dumps([function, arguments], default=str), file=stream, flush=True)
    answers = [stream.readline() for stream in streams]
    assert all(answers), f"{function}{arguments}: a process has ended"
    return [json.loads(answer) for answer in answers]


@cache
def _pool(number):
    """Streams of the processes, which end when this one does."""
    folder = Path(tempfile.mkdtemp())
    command, environment = ranks.launch(number, [__file__, folder / "socket"])
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(folder / "socket"))
        server.listen(number)
        server.settimeout(START)
        processes = subprocess.Popen(command, env=environment | {"NUMBA_NUM_THREADS": "1"}, stdin=subprocess.DEVNULL)
        connections = [server.accept()[0] for _ in range(number)]
    shutil.rmtree(folder)
    for connection in connections:
        connection.settimeout(RUN)
    atexit.register(_end, processes, connections)
    return [connection.makefile("rw") for connection in connections]


def _end(processes, connections):
    for connection in connections:
        connection.shutdown(socket.SHUT_RDWR)
    processes.wait(START)


def serve(path):
    """Call the functions that come from a socket, and answer each with its result and what it printed to stderr."""
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(path)
        stream = connection.makefile("rw")
        for order in stream:
            function, arguments = json.loads(order)
            module, _, name = function.rpartition(".")
            with redirect_stderr(StringIO()) as text:
                result = getattr(import_module(module), name)(*arguments)
            print(json.dumps([result, text.getvalue()]), file=stream, flush=True)


if __name__ == "__main__":
    serve(sys.argv[1])
