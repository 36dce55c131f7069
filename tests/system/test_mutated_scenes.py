"""Scenes with absurd values are built or refused with a reason; none ends in a traceback, hangs or fills the memory."""

import subprocess
import sys
from collections import Counter

import mutated_scenes
import pytest

QUICK, ALL = 40, 1000


def outcomes(folder, first, end):
    """{seed: (outcome, reason)}; a process that dies counts as one more seed, and the next one goes on."""
    found = {}
    while first < end:
        command = [sys.executable, mutated_scenes.__file__, str(folder), str(first), str(end)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=mutated_scenes.ROOT)
        for line in done.stdout.splitlines():
            seed, outcome, reason = (*line.split("\t"), "", "")[:3]
            if seed.isdecimal():
                found[int(seed)] = outcome, reason
        first = max(found, default=first - 1) + 1 if done.returncode == 0 else max([first - 1, *found]) + 2
        if done.returncode:
            found[first - 1] = "died", f"code {done.returncode}: {done.stderr[-300:]}"
    return found


def check(folder, first, end):
    found = outcomes(folder, first, end)
    print(Counter(outcome for outcome, _ in found.values()))
    wrong = {seed: result for seed, result in found.items() if result[0] not in ("built", "refused")}
    assert len(found) == end - first and not wrong, wrong
    assert all(reason for outcome, reason in found.values() if outcome == "refused")
    assert {outcome for outcome, _ in found.values()} == {"built", "refused"}


def test_some_mutated_scenes(tmp_path):
    check(tmp_path, 0, QUICK)


@pytest.mark.slow
def test_many_mutated_scenes(tmp_path):
    check(tmp_path, QUICK, ALL)
