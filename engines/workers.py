"""Worker processes, each with one piece of work at a time: a crash costs its piece alone.

A worker ends with the process that began it, whatever ends that. It never sees an interrupt
(SIGINT), which a terminal sends to all processes: the one that began it ends it.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import queue
import signal
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from importlib import import_module
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import TYPE_CHECKING, Any

from plumbob.analytic.parameters import ParameterError

if TYPE_CHECKING:
    from concurrent.futures import Executor

TRIES = 2  # of a piece whose worker dies or hangs
STARTS = 3  # workers in a row that may end before they are ready
LOADING = 300.0  # [s] that a worker may take until it is ready
TICK = 0.2  # [s] between two looks at the clock
OUT_OF_MEMORY = "out of memory"
UNMAPPED = "failed to map segment"  # what is said of a library that memory does not suffice to load


@dataclass(frozen=True)
class Work:
    """A piece of work, the time [s] after which it hangs, and what it shares with others."""

    do: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float
    group: str = ""  # what a worker has found once for all pieces with this name


@dataclass(frozen=True)
class _Worker:
    process: BaseProcess
    orders: queue.SimpleQueue[tuple[Callable[..., Any], tuple[Any, ...]] | None]
    thread: threading.Thread


@dataclass(frozen=True)
class _Job:
    key: Hashable
    work: Work
    tries: int = 1
    elapsed: float = 0.0  # [s]; a machine that sleeps adds nothing
    hangs: bool = False


class Workers:
    """Up to `count` processes, begun where there is work for them; as a context, they have ended
    when it ends."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._events: queue.SimpleQueue[tuple[int, str, Any]] = queue.SimpleQueue()
        self._workers: dict[int, _Worker] = {}
        self._last: dict[int, Hashable] = {}  # what each has worked on
        self._groups: dict[str, int] = {}  # who has worked on each last
        self._ready: set[int] = set()
        self._begun = self._unready = 0

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers.values():
            worker.process.kill()
            worker.orders.put(None)
        for worker in self._workers.values():
            worker.thread.join()

    def begin(self, count: int, module: str) -> None:
        """Begin so many of them, `count` of these workers at most, before there is work, with the
        module that the work will need."""
        for number in range(self._begun + 1, min(count, self.count) + 1):
            self._of(number, module)

    def who(self, group: str) -> int | None:
        """The number of the worker that has worked on this group of pieces, the last of several;
        None where none has, or it is no longer there."""
        number = self._groups.get(group, 0) if group else 0
        return number if number in self._workers and self._lives(number) else None

    def _lives(self, number: int) -> bool:
        return not wait([self._workers[number].process.sentinel], 0.0)

    def work_out(
        self,
        take: Callable[[Hashable | None], tuple[Hashable, Work] | None],
        done: Callable[[Hashable, Any], None],
        lost: Callable[[Hashable, str], None],
        count: int | None = None,
    ) -> None:
        """Work out what `take` gives, given what that worker had last, until it gives None; one
        after the other, by whoever knows its group, for a `count` of 1. `done` is called with each
        result, and `lost` with the reason where a worker has died or hung twice. What a worker does
        next is taken while it is busy, and given to it before `done` is called. Raises what a piece
        raises, and ParameterError where no worker starts."""
        running: dict[int, _Job] = {}
        ahead: dict[int, _Job] = {}
        again: deque[_Job] = deque()
        limit = min(self.count, count or self.count)
        seen = time.monotonic()

        def begin() -> None:
            while len(running) < limit:
                idle = self._idle(running)
                own = idle if limit > 1 else next(iter(ahead), idle)
                if again:
                    job = again.popleft()
                elif own in ahead:
                    job = ahead.pop(own)
                elif (taken := take(self._last.get(idle, None))) is not None:
                    job = _Job(*taken)
                elif ahead:  # of a worker that is still busy
                    job = ahead.pop(next(iter(ahead)))
                else:
                    return
                if limit == 1:
                    idle = self.who(job.work.group) or idle
                running[idle] = job
                self._last[idle] = job.key
                self._groups[job.work.group] = idle
                self._of(idle).orders.put((job.work.do, job.work.arguments))

        while True:
            begin()
            if not running:
                return
            for number, job in running.items():
                if number not in ahead and (taken := take(job.key)) is not None:
                    ahead[number] = _Job(*taken)
            event = self._event()
            seen = self._watched(running, seen)
            if event is None or event[1] == "ready":
                continue
            number, kind, value = event
            ended = running.pop(number, None)
            if kind == "done" and ended is not None:
                begin()
                done(ended.key, value)
            elif kind == "raised":
                raise value
            elif kind == "dead":
                self._workers.pop(number).thread.join()
                if ended is not None:
                    self._tried(ended, value, again, lost)

    def _idle(self, running: dict[int, _Job]) -> int:
        """The number of a worker that has nothing to do, or that of the next one to begin."""
        for number in [n for n in self._workers if n not in running]:
            if self._lives(number):
                return number
        return self._begun + 1

    def _of(self, number: int, module: str = __name__) -> _Worker:
        if number not in self._workers:
            self._workers[number] = _begun(number, self._events, module)
            self._begun = number
        return self._workers[number]

    def _event(self) -> tuple[int, str, Any] | None:
        try:
            event = self._events.get(timeout=TICK)
        except queue.Empty:
            return None
        if event[1] == "ready":
            self._unready = 0
            self._ready.add(event[0])
        elif event[1] == "unready":
            self._unready += 1
            if self._unready >= STARTS:
                raise ParameterError(
                    "jobs", self.count,
                    f"a number of processes that can be started here ({_ending(event[2])})",
                )  # fmt: skip
            return event[0], "dead", None
        return event

    def _watched(self, running: dict[int, _Job], seen: float) -> float:
        """End workers that take longer than their piece may; returns the time [s]."""
        now = time.monotonic()
        for number, job in running.items():
            older = replace(job, elapsed=job.elapsed + min(now - seen, 1.0))
            limit = job.work.limit if number in self._ready else max(job.work.limit, LOADING)
            if older.elapsed > limit and not job.hangs:
                self._of(number).process.kill()
                older = replace(older, hangs=True)
            running[number] = older
        return now

    def _tried(
        self, job: _Job, value: Any, again: deque[_Job], lost: Callable[[Hashable, str], None]
    ) -> None:
        if value is None:  # its worker was never ready
            again.append(_Job(job.key, job.work, job.tries))
        elif job.tries < TRIES:
            again.append(_Job(job.key, job.work, job.tries + 1))
        else:
            why = f"no answer within {job.work.limit:.3g} s" if job.hangs else _ending(value)
            lost(job.key, f"{why}, {TRIES} times")


def _ending(value: Any) -> str:
    """How a worker ended: its exit code, or a text of its own."""
    if not isinstance(value, int):
        return str(value)
    if value >= 0:
        return f"its process ended with exit code {value}"
    try:
        return f"its process was ended by {signal.Signals(-value).name}"
    except ValueError:
        return f"its process was ended by signal {-value}"


def _begun(number: int, events: queue.SimpleQueue[tuple[int, str, Any]], module: str) -> _Worker:
    """A new worker, and the thread that speaks with it: a process that stops in the middle of an
    answer holds up that thread alone."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, module), daemon=True)
    with interrupts_held():
        process.start()
    theirs.close()
    orders: queue.SimpleQueue[tuple[Callable[..., Any], tuple[Any, ...]] | None]
    orders = queue.SimpleQueue()
    thread = threading.Thread(
        target=_attend, args=(number, process, ours, orders, events), daemon=True
    )
    thread.start()
    return _Worker(process, orders, thread)


def _attend(
    number: int,
    process: BaseProcess,
    ours: Connection,
    orders: queue.SimpleQueue[tuple[Callable[..., Any], tuple[Any, ...]] | None],
    events: queue.SimpleQueue[tuple[int, str, Any]],
) -> None:
    ready, said = False, None
    try:
        ours.recv()
        ready = True
        events.put((number, "ready", None))
        while (order := orders.get()) is not None:
            ours.send(order)
            kind, value = ours.recv()
            if kind == "ending":
                said = value
                break
            events.put((number, *_answer(kind, value)))
    except (EOFError, OSError):
        pass
    except Exception as error:  # an answer that cannot be read
        events.put((number, "raised", error))
    process.join()
    ours.close()
    events.put((number, "dead" if ready else "unready", said or process.exitcode))


def _answer(kind: str, value: Any) -> tuple[str, Any]:
    if kind == "refused":
        return "raised", ParameterError(*value)
    if kind == "raised":
        error, text = value
        error.__cause__ = RuntimeError(f"in a worker process:\n{text}")
        return kind, error
    return kind, value


def _serve(theirs: Connection, module: str) -> None:
    """What a worker does: one piece after the other, once it has loaded the module."""
    beginner = multiprocessing.parent_process()
    assert beginner is not None
    threading.Thread(target=_end_with, args=(beginner.sentinel,), daemon=True).start()
    theirs.send(None)
    with suppress(ImportError, MemoryError):  # a piece that needs it says so
        import_module(module)
    while True:
        try:
            do, arguments = theirs.recv()
            theirs.send(_worked(do, arguments))
        except EOFError:
            return
        except MemoryError:  # what is left of this process is no place for the next piece
            theirs.send(("ending", OUT_OF_MEMORY))
            return


def _worked(do: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[str, Any]:
    try:
        return "done", do(*arguments)
    except MemoryError:
        raise
    except ParameterError as error:
        value = error.value if isinstance(error.value, (int, float, str)) else str(error.value)
        return "refused", (error.name, value, error.requirement)
    except Exception as error:
        if isinstance(error, ImportError) and UNMAPPED in str(error):
            raise MemoryError(str(error)) from error
        text = traceback.format_exc()
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:
            error = RuntimeError(f"{type(error).__name__}: {error}")
        return "raised", (error, text)


def _end_with(sentinel: int) -> None:
    """End this process with the one that began it."""
    wait([sentinel])
    os._exit(1)


@contextmanager
def workers_of(jobs: int | Workers) -> Iterator[Workers]:
    """The workers that are given, or so many new ones, which end with the context."""
    if isinstance(jobs, Workers):
        yield jobs
        return
    with Workers(jobs) as workers:
        yield workers


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Processes that begin meanwhile never see an interrupt (SIGINT); it reaches this one
    afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # which would let interrupts through when it begins
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def pool_of(executor: Executor | None, jobs: int) -> Iterator[Executor | None]:
    """The executor, or a pool of processes, which end at once where an error or an interrupt does;
    None for no jobs."""
    if executor is not None or jobs < 1:
        yield executor
        return
    from concurrent.futures import ProcessPoolExecutor

    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        try:
            yield pool
        except BaseException:
            for process in set(multiprocessing.active_children()) - others:
                process.terminate()
            raise
