"""The processes of a study leave interrupts to the one that began them, and end with it."""

import multiprocessing
import signal
import subprocess
import sys
import time

import pytest

from plumbob.engines.workers import Workers, interrupts_held

BEGINS = """
import signal
from plumbob.engines.workers import Task, Workers
tasks = [Task(name, signal.pthread_sigmask, (signal.SIG_BLOCK, ()), 60.0) for name in "ab"]
with Workers(2) as workers:
    workers.begin(2, "signal")
    for _, held in workers.results(tasks):
        print(signal.SIGINT in held)
print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ()))
"""


def test_workers_never_see_an_interrupt():
    """With the first of them Python begins another process, and lets interrupts through then."""
    said = subprocess.run(
        [sys.executable, "-c", BEGINS], capture_output=True, text=True, timeout=300, check=True
    )
    assert (said.stdout.split(), said.stderr) == (["True", "True", "False"], "")


def test_an_interrupt_that_comes_while_processes_begin_is_not_lost():
    with pytest.raises(KeyboardInterrupt), interrupts_held():
        signal.raise_signal(signal.SIGINT)


def test_processes_end_with_what_began_them():
    others = set(multiprocessing.active_children())
    with pytest.raises(KeyboardInterrupt):
        _interrupted_while_a_process_sleeps()
    assert set(multiprocessing.active_children()) <= others


def _interrupted_while_a_process_sleeps():
    with Workers(1) as pool:
        pool.submit(time.sleep, 3600.0)  # [s]: not waited for
        raise KeyboardInterrupt
