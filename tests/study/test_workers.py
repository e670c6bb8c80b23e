"""A worker that dies, hangs or runs out of memory costs its task; the others are worked out."""

import gc
import multiprocessing
import os
import signal
import sys
from concurrent.futures import BrokenExecutor
from multiprocessing.connection import Connection

import pytest

from plumbob.analytic.parameters import ParameterError
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
    "stopped": (signal.raise_signal, (signal.SIGSTOP,), 0.4, "no answer within 0.4 s, 2 times"),
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


def test_workers_that_are_killed_while_they_load_cost_nothing():
    with Workers(2) as workers:
        workers.begin(2)
        for child in multiprocessing.active_children()[:1]:
            child.kill()
        tasks = [Task(number, abs, (-number,), 60.0) for number in range(4)]
        assert {task.key: result for task, result in workers.results(tasks)} == {
            number: number for number in range(4)
        }


def test_tasks_are_for_the_worker_that_knows_their_group():
    def pids(workers, names):
        tasks = [Task((name, k), os.getpid, (), 60.0, name) for k, name in enumerate(names)]
        return {task.key: pid for task, pid in workers.results(tasks)}

    with Workers(2) as workers:
        first = pids(workers, "ab")
        assert first["a", 0] != first["b", 1]
        for name in "baba":
            assert {*pids(workers, name).values()} == {first[name, "ab".index(name)]}
        os.kill(first["b", 1], signal.SIGKILL)
        assert pids(workers, "b")["b", 0] != first["b", 1]


def test_no_worker_is_idle_while_another_is_busy(tmp_path):
    file = str(tmp_path / "there")
    waits = f"import os, time\nwhile not os.path.exists({file!r}): time.sleep(0.01)"
    tasks = [
        Task(1, exec, (waits,), 60.0, "a"),
        Task(2, abs, (-2,), 60.0, "a"),
        Task(3, exec, (f"open({file!r}, 'w').close()",), 60.0, "a"),
    ]
    assert _worked_out(tasks, jobs=2) == ({1: None, 2: 2, 3: None}, {})


def test_workers_are_an_executor():
    with Workers(2) as workers:
        futures = [workers.submit(abs, number) for number in (-1, -2, -3)]
        assert [future.result() for future in futures] == [1, 2, 3]
        assert isinstance(workers.submit(signal.raise_signal, 9).exception(), BrokenExecutor)


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


def test_bad_input_comes_back_as_what_it_is():
    code = "from plumbob.analytic.parameters import positive\npositive('length', -1.0)"
    with pytest.raises(ParameterError, match=r"length = -1\.0: must be greater than 0"):
        _worked_out([Task(1, exec, (code,), 60.0)])


def test_an_error_that_cannot_be_sent_comes_back_as_text():
    code = "class Own(Exception): pass\nraise Own('of its own')"
    with pytest.raises(RuntimeError, match="Own: of its own"):
        _worked_out([Task(1, exec, (code, {"__name__": "nowhere"}), 60.0)])


def test_a_machine_that_starts_no_process_is_one_line():
    multiprocessing.set_executable("/bin/false")
    try:
        with pytest.raises(ParameterError, match=r"jobs = 1: .*exit code 1"):
            _worked_out([Task(1, abs, (-1,), 60.0)])
    finally:
        multiprocessing.set_executable(sys.executable)


def test_workers_never_see_an_interrupt():
    found, _ = _worked_out([Task(1, signal.pthread_sigmask, (signal.SIG_BLOCK, ()), 60.0)])
    assert signal.SIGINT in found[1]
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
