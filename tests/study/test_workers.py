"""A worker that dies, hangs or runs out of memory costs its task; the others are worked out."""

import gc
import multiprocessing
import os
import re
import signal
from multiprocessing.connection import Connection

import pytest

from plumbob.engines.workers import Lost, Task, Workers

FATAL = {
    "killed": (signal.raise_signal, (signal.SIGKILL,), 60.0, "ended by SIGKILL, 2 times"),
    "aborted": (os.abort, (), 60.0, "ended by SIGABRT, 2 times"),
    "left": (os._exit, (7,), 60.0, "exit code 7, 2 times"),
    "out of memory": (bytearray, (2**62,), 60.0, "out of memory, 2 times"),
    "no memory for a library": (
        exec,
        ("raise ImportError('a.so: failed to map segment from shared object')",),
        60.0,
        "out of memory, 2 times",
    ),
    "stopped": (signal.raise_signal, (signal.SIGSTOP,), 0.4, "s, 2 times"),
    # one call, which lets no other thread of Python run
    "long": (
        re.match,
        ("(a+)+b", "a" * 60),
        0.3,
        "no answer within 0.3 s of processor time, 2 times",
    ),
}


def _worked_out(tasks, jobs=1):
    with Workers(jobs) as workers:
        found = {task.key: result for task, result in workers.results(tasks)}
    lost = {key: result.why for key, result in found.items() if isinstance(result, Lost)}
    return {key: result for key, result in found.items() if key not in lost}, lost


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("kind", FATAL)
def test_a_fatal_task_is_tried_once_more_and_given_up(kind):
    do, arguments, limit, said = FATAL[kind]
    others = set(multiprocessing.active_children())
    found, lost = _worked_out(
        [Task(1, abs, (-1,), 60.0), Task(2, do, arguments, limit), Task(3, abs, (-3,), 60.0)]
    )
    assert found == {1: 1, 3: 3}
    assert list(lost) == [2]
    assert said in lost[2]
    assert set(multiprocessing.active_children()) <= others


def test_a_task_on_a_busy_machine_has_its_time():
    """A twentieth of a core for four times its limit."""
    code = "import time\n"
    code += "end = time.monotonic() + 1.6\n"
    code += "while time.monotonic() < end:\n"
    code += "    begin = time.process_time()\n"
    code += "    while time.process_time() < begin + 0.01: pass\n"
    code += "    time.sleep(0.09)\n"
    assert _worked_out([Task(1, exec, (code,), 0.4)]) == ({1: None}, {})


def test_an_executor_begins_no_more_processes_than_it_has_tasks():
    with Workers(10**6) as workers:
        workers.submit(abs, -1)
        assert len(multiprocessing.active_children()) == 1


def test_a_task_that_is_fatal_once_is_worked_out(tmp_path):
    code = f"import os, signal\ntry: os.mkdir({str(tmp_path / 'tried')!r})\n"
    code += "except FileExistsError: pass\nelse: signal.raise_signal(signal.SIGKILL)"
    assert _worked_out([Task(1, exec, (code,), 60.0)]) == ({1: None}, {})


def _cut_short():
    """In a worker: begin an answer that is longer than a pipe holds, and end."""
    import struct

    (pipe,) = (f for f in gc.get_objects() if isinstance(f, Connection))
    os.write(pipe.fileno(), struct.pack("!i", 10**6) + bytes(1000))
    signal.raise_signal(signal.SIGKILL)


def test_a_worker_that_is_killed_in_the_middle_of_an_answer_costs_its_task():
    found, lost = _worked_out([Task(1, _cut_short, (), 60.0), Task(2, abs, (-2,), 60.0)])
    assert found == {2: 2}
    assert "ended by SIGKILL, 2 times" in lost[1]


def test_what_a_task_raises_is_raised_and_ends_the_others():
    others = set(multiprocessing.active_children())
    tasks = [
        Task(1, signal.pause, (), 60.0),
        Task(2, exec, ("raise LookupError('of a task')",), 60.0),
    ]
    with pytest.raises(LookupError, match="of a task") as raised:
        _worked_out(tasks, jobs=2)
    assert "in a worker process" in str(raised.value.__cause__)
    assert set(multiprocessing.active_children()) <= others
