"""Worker processes, each with one task at a time: a crash costs its task alone.

A thread speaks with each worker: one that stops in the middle of an answer holds up that thread
alone. A worker ends with the process that began it, whatever ends that, and never sees an interrupt
(SIGINT), which a terminal sends to all processes. The limit of a task is processor time, which the
worker's own timer measures: what else runs on the machine decides nothing.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from itertools import product
from multiprocessing import connection, resource_tracker
from pathlib import Path
from typing import Any

from plumbob.analytic.parameters import ParameterError
from plumbob.models.memory import UNMAPPED

TRIES = 2  # of a task whose worker dies or hangs
STARTS = 3  # workers in a row that may end before they are ready
LOADING = 300.0  # [s] that a worker may take until it is ready
TICK = 0.2  # [s] between two looks at the clock
# A task that has run for longer than its limit is waiting in vain if it used less than this
# fraction of the time: on a core with fifteen other processes a task that computes uses six times
# as much.
IDLE = 0.01
# If the system does not tell the processor time, a task hangs after so many limits of wall time.
FAR = 20.0
MOST = 1e8  # [s]: the longest time that a timer takes
AHEAD = 3  # tasks for each worker of a cluster that are handed out at a time
OUT_OF_MEMORY = "out of memory"


@dataclass(frozen=True)
class Lost:
    """The reason for which a task has no result."""

    why: str


@dataclass(frozen=True, eq=False)
class Task:
    """A function with its arguments, for one process."""

    key: Any
    do: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float  # [s] of processor time, after which it hangs
    group: str = ""  # tasks that share models and references
    label: str = ""
    instead: Callable[[str], Any] = str  # what stands for a result that is given up, and why


def _ignored(task: Task) -> None:
    """Nobody is informed."""


class _Worker:
    """A process, and the thread that speaks with it."""

    def __init__(self, module: str) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, module), daemon=True)
        self.process.start()
        theirs.close()
        self._thread = ThreadPoolExecutor(1)
        self.ready = self._thread.submit(self._pipe.recv)
        self.late = ""  # that it was ended for a task that hung
        self._begun: tuple[float, float | None] = time.monotonic(), None

    def submit(
        self, do: Callable[..., Any], *arguments: Any, limit: float = 0.0
    ) -> Future[Any]:
        """The result of a task, once those before it are done; BrokenExecutor if the process has
        ended. If a `limit` [s] of processor time is given, the process ends when it is used up."""
        return self._thread.submit(self._answer, do, arguments, limit)

    def _answer(self, do: Callable[..., Any], arguments: tuple[Any, ...], limit: float) -> Any:
        self._begun = time.monotonic(), _processor_time(self.process.pid)
        try:
            self._pipe.send((do, arguments, limit))
            value, error, text = self._pipe.recv()
        except (EOFError, OSError) as end:
            raise BrokenExecutor("a worker process has ended") from end
        if error is not None:
            raise error from RuntimeError(f"in a worker process:\n{text}")
        return value

    def end_idle(self, limit: float) -> None:
        """End the process if it is not ready in time, or if its task has run for longer than its
        limit [s] and used hardly any processor time meanwhile."""
        since, before = self._begun
        seconds = time.monotonic() - since
        allowed = LOADING
        if self.ready.done():
            allowed = FAR * limit
            used = _processor_time(self.process.pid)
            if used is not None and before is not None:
                allowed = max(limit, (used - before) / IDLE)
        if seconds > allowed:
            self.late = f"no answer within {seconds:.3g} s"
            self.process.kill()

    def end(self) -> None:
        """End the process, whatever it does, and the thread."""
        self.process.kill()
        self._thread.shutdown(cancel_futures=True)
        self.process.join()
        self._pipe.close()


class Workers(Executor):
    """Up to `count` processes, begun where there is work for them; as a context, they have ended
    when it ends."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._workers: list[_Worker] = []
        self._groups: dict[str, _Worker] = {}  # the last to work on each
        self._unready = 0  # workers in a row that have ended before they were ready
        self._submitted = 0

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End all processes, whatever they do."""
        while self._workers:
            self._workers.pop().end()

    def begin(self, count: int, module: str = __name__) -> None:
        """Begin `count` workers, or all there may be, with the module that their tasks need."""
        while len(self._workers) < min(count, self.count):
            with interrupts_held():
                self._workers.append(_Worker(module))

    def submit(self, do: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """As any executor: the workers take turns, and a task is tried once."""
        turn = self._submitted % self.count
        self.begin(turn + 1)
        self._submitted += 1
        worker = self._workers[turn]
        return worker.submit(partial(do, *arguments, **named))

    def _living(self) -> list[_Worker]:
        self._workers = [worker for worker in self._workers if worker.process.is_alive()]
        return self._workers

    def results(
        self, tasks: Sequence[Task], begun: Callable[[Task], None] = _ignored
    ) -> Iterator[tuple[Task, Any]]:
        """Each task with its result, as they are done, or with `Lost` where a worker has died or
        hung twice; tasks of one group by one worker where possible. A worker has its next task
        before the result of its last one is handed over. Raises what a task raises, and
        ParameterError where no worker starts."""
        waiting = list(tasks)
        running: dict[Future[Any], tuple[Task, _Worker]] = {}
        tries = Counter[Task]()
        done: list[tuple[Task, Any]] = []
        while waiting or running or done:
            while waiting and len(running) < self.count:
                task, worker = self._next(waiting, [worker for _, worker in running.values()])
                future = worker.submit(task.do, *task.arguments, limit=task.limit)
                running[future] = task, worker
                begun(task)
            yield from done
            done.clear()
            for future in wait(running, TICK, FIRST_COMPLETED).done:
                task, worker = running.pop(future)
                result = self._result(future, worker, task.limit)
                if isinstance(result, Lost):
                    tries[task] += bool(result.why)
                    if tries[task] < TRIES:
                        waiting.insert(0, task)
                        continue
                    result = Lost(f"{result.why}, {TRIES} times")
                done.append((task, result))
            for task, worker in running.values():
                worker.end_idle(task.limit)

    def _next(self, waiting: list[Task], busy: Sequence[_Worker]) -> tuple[Task, _Worker]:
        """A task and an idle worker: of a group that it knows, or else that nobody has begun."""
        idle = [worker for worker in self._living() if worker not in busy]
        if not idle:
            self.begin(len(self._workers) + 1)
            idle = self._workers[-1:]
        task, worker = min(
            product(waiting, idle),
            key=lambda pair: {pair[1]: 0, None: 1}.get(self._groups.get(pair[0].group), 2),
        )
        waiting.remove(task)
        self._groups[task.group] = worker
        return task, worker

    def _result(self, future: Future[Any], worker: _Worker, limit: float) -> Any:
        """The result of a task that had a `limit` [s] of processor time; `Lost` if its worker has
        ended, without a reason if the worker never was ready."""
        error = future.exception()
        if error is None:
            self._unready = 0
            return future.result()
        if not isinstance(error, (BrokenExecutor, MemoryError)):
            raise error
        worker.end()  # out of memory it is no place for another task
        if isinstance(error, MemoryError):
            return Lost(OUT_OF_MEMORY)
        why = worker.late or _ending(worker.process.exitcode or 0, limit)
        if worker.ready.exception() is None:
            return Lost(why)
        self._unready += 1
        if self._unready >= STARTS:
            wanted = f"a number of processes that can be started here ({why})"
            raise ParameterError("jobs", self.count, wanted)
        return Lost("")


def results(
    tasks: Sequence[Task],
    executor: Executor | None,
    begun: Callable[[Task], None] = _ignored,
    count: int = 1,
) -> Iterator[tuple[Task, Any]]:
    """Each task with its result: of workers, of another executor with `count` processes, which
    tries again by itself what a lost one had, or without an executor of this process."""
    if isinstance(executor, Workers):
        yield from executor.results(tasks, begun)
        return
    running: dict[Future[Any], Task] = {}
    for task in tasks:
        begun(task)
        if executor is None:
            yield task, task.do(*task.arguments)
            continue
        running[executor.submit(task.do, *task.arguments)] = task
        if len(running) >= AHEAD * count:
            yield from _finished(running)
    while running:
        yield from _finished(running)


def _finished(running: dict[Future[Any], Task]) -> Iterator[tuple[Task, Any]]:
    """Wait for some of the tasks that run, and take them out of them."""
    for future in wait(running, return_when=FIRST_COMPLETED).done:
        yield running.pop(future), future.result()


def spent() -> float:
    """The processor time [s] that this process and its children, living and ended, have used."""
    used = os.times()
    living = (_processor_time(child.pid) or 0.0 for child in multiprocessing.active_children())
    return used.user + used.system + used.children_user + used.children_system + sum(living)


def _processor_time(process: int | None) -> float | None:
    """The processor time [s] that a process has used; None if the system does not tell."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text("ascii", "replace")
        user, system = fields.rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")
    except (OSError, ValueError):
        return None


def _ending(code: int, limit: float) -> str:
    """Why a process ended, by its exit code; its task had a `limit` [s] of processor time."""
    if hasattr(signal, "SIGPROF") and code == -signal.SIGPROF:
        return f"no answer within {limit:.3g} s of processor time"
    if code >= 0:
        return f"its process ended with exit code {code}"
    named = {-number: number.name for number in signal.Signals}
    return f"its process was ended by {named.get(code, f'signal {-code}')}"


def _serve(theirs: connection.Connection, module: str) -> None:
    """In a worker: one task after the other, once it has loaded the module that they need."""
    beginner = multiprocessing.parent_process()
    assert beginner is not None
    threading.Thread(target=_end_with, args=(beginner.sentinel,), daemon=True).start()
    with suppress(ImportError, MemoryError):  # a task that needs it says so
        import_module(module)
    theirs.send(None)
    while True:
        try:
            do, arguments, limit = theirs.recv()
            _end_after(limit)
            outcome = _outcome(do, arguments)
            _end_after(0.0)
            theirs.send(outcome)
        except EOFError:
            return
        except MemoryError:
            theirs.send((None, MemoryError(), ""))


def _end_after(seconds: float) -> None:
    """Let the system end this process when it has used so many more `seconds` of processor time,
    also within a library's call that does not return; 0 stops the timer."""
    if hasattr(signal, "ITIMER_PROF"):  # not on Windows
        signal.setitimer(signal.ITIMER_PROF, min(seconds, MOST))


def _outcome(
    do: Callable[..., Any], arguments: tuple[Any, ...]
) -> tuple[Any, Exception | None, str]:
    """A task's result, or what it raises with the traceback."""
    try:
        return do(*arguments), None, ""
    except MemoryError:
        raise
    except Exception as error:
        if isinstance(error, ImportError) and UNMAPPED in str(error):
            raise MemoryError from error
        text = traceback.format_exc()
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:
            error = RuntimeError(f"{type(error).__name__}: {error}")
        return None, error, text


def _end_with(sentinel: int) -> None:
    """End this process with the one that began it."""
    connection.wait([sentinel])
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
