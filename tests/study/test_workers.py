"""A worker that dies, hangs or runs out of memory costs its piece; the others are worked out."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from collections.abc import Callable, Hashable, Mapping
from pathlib import Path
from typing import Any

import pytest

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.workers import Work, Workers

FATAL: Mapping[str, tuple[Callable[..., Any], tuple[Any, ...], float, str]] = {
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


def _worked_out(
    given: dict[Hashable, Work], jobs: int = 1
) -> tuple[dict[Any, Any], dict[Any, str]]:
    waiting = dict(given)
    found: dict[Any, Any] = {}
    lost: dict[Any, str] = {}
    with Workers(jobs) as workers:
        workers.work_out(
            lambda _: waiting.popitem() if waiting else None, found.__setitem__, lost.__setitem__
        )
    return found, lost


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("kind", FATAL)
def test_a_fatal_piece_is_tried_once_more_and_given_up(kind: str) -> None:
    do, arguments, limit, said = FATAL[kind]
    others = set(multiprocessing.active_children())
    found, lost = _worked_out({1: Work(abs, (-1,), 60.0), 2: Work(do, arguments, limit),
                               3: Work(abs, (-3,), 60.0)})  # fmt: skip
    assert found == {1: 1, 3: 3}
    assert list(lost) == [2]
    assert said in lost[2]
    assert set(multiprocessing.active_children()) <= others


def test_a_piece_that_is_fatal_once_is_worked_out(tmp_path: Path) -> None:
    code = f"import os, signal\ntry: os.mkdir({str(tmp_path / 'tried')!r})\n"
    code += "except FileExistsError: pass\nelse: signal.raise_signal(signal.SIGKILL)"
    assert _worked_out({1: Work(exec, (code,), 60.0)}) == ({1: None}, {})


def test_the_next_piece_is_taken_and_given_before_the_last_one_is_done_with() -> None:
    waiting, seen = [3, 2, 1], []

    def take(last: Hashable | None) -> tuple[Hashable, Work] | None:
        return (waiting[-1], Work(abs, (-waiting.pop(),), 60.0)) if waiting else None

    with Workers(1) as workers:
        workers.work_out(take, lambda key, _: seen.append((key, len(waiting))), lambda *_: None)
        assert seen == [(1, 1), (2, 0), (3, 0)]
        assert len(multiprocessing.active_children()) > 0  # for what comes after


def test_pieces_one_after_the_other_are_for_the_worker_that_knows_their_group() -> None:
    found: dict[Any, Any] = {}

    def take_from(given: dict[Hashable, Work]) -> Callable[..., tuple[Hashable, Work] | None]:
        return lambda _: (key := next(iter(given)), given.pop(key)) if given else None

    def work_out(given: dict[Hashable, Work], count: int | None) -> None:
        workers.work_out(take_from(given), found.__setitem__, lambda *_: None, count)

    with Workers(2) as workers:
        work_out({name: Work(os.getpid, (), 60.0, name) for name in "ab"}, None)
        assert found["a"] != found["b"]
        assert {workers.who(name) for name in "ab"} == {1, 2}
        assert workers.who("c") is workers.who("") is None
        again = [("b", 1), ("a", 2), ("b", 3), ("a", 4), ("a", 5)]
        work_out({key: Work(os.getpid, (), 60.0, key[0]) for key in again}, 1)
        assert [found[key] for key in again] == [found[name] for name, _ in again]
        os.kill(found["b"], signal.SIGKILL)
        while workers.who("b") is not None:  # until the system has ended it
            pass
        work_out({("b", 6): Work(os.getpid, (), 60.0, "b")}, 1)
        assert found["b", 6] != found["b"]


def test_a_piece_taken_for_a_busy_worker_is_done_by_an_idle_one(tmp_path: Path) -> None:
    file = str(tmp_path / "there")
    waits = f"import os, time\nwhile not os.path.exists({file!r}): time.sleep(0.01)"
    given: dict[Hashable, Work] = {
        3: Work(exec, (f"open({file!r}, 'w').close()",), 60.0),
        2: Work(abs, (-2,), 60.0),
        1: Work(exec, (waits,), 60.0),
    }
    assert _worked_out(given, jobs=2) == ({1: None, 2: 2, 3: None}, {})


def test_workers_that_begin_early_do_the_work_then() -> None:
    others = set(multiprocessing.active_children())
    with Workers(2) as workers:
        workers.begin(5, "json")
        early = set(multiprocessing.active_children()) - others
        assert len(early) == 2
        waiting = [Work(os.getpid, (), 60.0) for _ in range(4)]
        found: dict[Hashable, int] = {}
        workers.work_out(
            lambda _: (len(waiting), waiting.pop()) if waiting else None,
            found.__setitem__, lambda *_: None,
        )  # fmt: skip
        assert set(found.values()) <= {process.pid for process in early}


def test_what_a_piece_raises_is_raised_and_ends_the_others() -> None:
    others = set(multiprocessing.active_children())
    given: dict[Hashable, Work] = {
        1: Work(signal.pause, (), 60.0),
        2: Work(exec, ("raise LookupError('of a piece')",), 60.0),
    }
    with pytest.raises(LookupError, match="of a piece") as raised:
        _worked_out(given, jobs=2)
    assert "in a worker process" in str(raised.value.__cause__)
    assert set(multiprocessing.active_children()) <= others


def test_bad_input_comes_back_as_what_it_is() -> None:
    code = "from plumbob.analytic.parameters import positive\npositive('length', -1.0)"
    with pytest.raises(ParameterError, match=r"length = -1\.0: must be greater than 0"):
        _worked_out({1: Work(exec, (code,), 60.0)})


def test_a_machine_that_starts_no_process_is_one_line() -> None:
    multiprocessing.set_executable("/bin/false")
    try:
        with pytest.raises(ParameterError, match=r"jobs = 1: .*exit code 1"):
            _worked_out({1: Work(abs, (-1,), 60.0)})
    finally:
        multiprocessing.set_executable(sys.executable)


def test_workers_never_see_an_interrupt() -> None:
    found, _ = _worked_out({1: Work(signal.pthread_sigmask, (signal.SIG_BLOCK, ()), 60.0)})
    assert signal.SIGINT in found[1]
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())
