"""Worker processes, each with one task at a time: a crash costs its task alone.

Each worker has a thread in this process that sends tasks and receives results, so that a worker
that stops in the middle of an answer blocks that thread alone. A worker ends when the process that
began it ends, for whatever reason. A worker never sees an interrupt (SIGINT), which a terminal
sends to all processes. The limit of a task is processor time, measured by the worker's timer, so
that it does not depend on what else the machine runs."""

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

TRIES = 2  # attempts at a task whose worker dies or hangs
STARTS = 3  # workers in a row that may end before they are ready
LOADING_TIME = 300.0  # [s] longest time until a worker is ready
TICK = 0.2  # [s] time between two looks at the clock
# If a task has run for longer than its limit, and the ratio of its processor time to its wall time
# is smaller than this fraction, it hangs. A task that computes on a core with fifteen other
# processes has a ratio of 1/16.
IDLE_FRACTION = 0.01
# If the system does not tell the processor time, a task counts as hung when its wall time exceeds
# its limit times this factor.
WALL_TIME_FACTOR = 20.0
LONGEST_TIMER = 1e8  # [s] longest time that a timer accepts
AHEAD = 3  # tasks that each worker of a cluster has at a time
OUT_OF_MEMORY = "out of memory"


@dataclass(frozen=True)
class Lost:
    """The reason why a task has no result."""

    why: str


@dataclass(frozen=True, eq=False)
class Task:
    """A function with its arguments, to be called in a worker."""

    key: Any
    do: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit: float  # [s] processor time after which it counts as hanging
    group: str = ""  # name shared by tasks that use the same models and references
    label: str = ""  # description for the progress bar
    instead: Callable[[str], Any] = str  # reason of a task that is given up -> its result


def _ignored(task: Task) -> None:
    """Does nothing: the default callback."""


class _Worker:
    """A process, and the thread of this process that sends tasks to it and receives results."""

    def __init__(self, module: str) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, module), daemon=True)
        self.process.start()
        theirs.close()
        self._thread = ThreadPoolExecutor(1)
        self.ready = self._thread.submit(self._pipe.recv)
        self.late = ""  # why the process was killed, if its task hung
        # Time [s] at which the task began, or before the first task the process, and the processor
        # time [s] of the process then, if it is known. The thread sets both at once.
        self._task_start: tuple[float, float | None] = time.monotonic(), None

    def submit(
        self, do: Callable[..., Any], *arguments: Any, limit: float = 0.0
    ) -> Future[Any]:
        """The future result of a task, which begins when earlier tasks are done. The future raises
        BrokenExecutor if the process has ended. If a `limit` [s] of processor time is given, the
        process ends when the limit is used up."""
        return self._thread.submit(self._answer, do, arguments, limit)

    def _answer(self, do: Callable[..., Any], arguments: tuple[Any, ...], limit: float) -> Any:
        """Sends a task to the process, and returns its result. Runs in the thread."""
        self._task_start = time.monotonic(), _processor_time(self.process.pid)
        try:
            self._pipe.send((do, arguments, limit))
            value, error, text = self._pipe.recv()
        except (EOFError, OSError) as end:
            raise BrokenExecutor("a worker process has ended") from end
        if error is not None:
            raise error from RuntimeError(f"in a worker process:\n{text}")
        return value

    def end_idle(self, limit: float) -> None:
        """Ends the process if it is not ready in time, or if its task has run for longer than the
        task's limit [s] and hardly used any processor time meanwhile. If the system does not tell
        the processor time, ends it after WALL_TIME_FACTOR limits."""
        started_at, processor_time_at_start = self._task_start
        seconds = time.monotonic() - started_at
        if seconds > self._allowed_time(limit, processor_time_at_start):
            self.late = f"no answer within {seconds:.3g} s"
            self.process.kill()

    def _allowed_time(self, limit: float, processor_time_at_start: float | None) -> float:
        """Returns the longest time [s] since the start of the task, or of the process, after which
        the process does not hang."""
        if not self.ready.done():
            return LOADING_TIME
        processor_time = _processor_time(self.process.pid)
        if processor_time is None or processor_time_at_start is None:
            return WALL_TIME_FACTOR * limit
        used = processor_time - processor_time_at_start
        return max(limit, used / IDLE_FRACTION)

    def end(self) -> None:
        """Ends the process, whatever it is doing, and the thread."""
        self.process.kill()
        self._thread.shutdown(cancel_futures=True)
        self.process.join()
        self._pipe.close()


class Workers(Executor):
    """Up to `count` worker processes, which begin when there is work for them. As a context manager
    it ends them all."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._workers: list[_Worker] = []
        self._groups: dict[str, _Worker] = {}  # the last worker of each group of tasks
        self._unready = 0  # workers in a row that have ended before they were ready
        self._submitted = 0

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends all processes, whatever they are doing."""
        while self._workers:
            self._workers.pop().end()

    def begin(self, count: int, module: str = __name__) -> None:
        """Begins workers until there are `count`, or as many as there may be. Each first imports
        the module that its tasks need."""
        while len(self._workers) < min(count, self.count):
            with interrupts_held():
                self._workers.append(_Worker(module))

    def submit(self, do: Callable[..., Any], /, *arguments: Any, **named: Any) -> Future[Any]:
        """The future result of a call, as any executor returns it. The workers take turns, and a
        call is tried once."""
        turn = self._submitted % self.count
        self.begin(turn + 1)
        self._submitted += 1
        worker = self._workers[turn]
        return worker.submit(partial(do, *arguments, **named))

    def _living(self) -> list[_Worker]:
        """The workers whose processes have not ended."""
        self._workers = [worker for worker in self._workers if worker.process.is_alive()]
        return self._workers

    def results(
        self, tasks: Sequence[Task], begun: Callable[[Task], None] = _ignored
    ) -> Iterator[tuple[Task, Any]]:
        """Yields each task with its result when it is done, or with `Lost` if its worker has died
        or hung twice. If possible, tasks of one group are done by one worker. A worker is given the
        next task before the result of its last task is yielded. Raises the exception of a task, and
        ParameterError if no worker starts."""
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
        """The next task, and an idle worker for it. A task of a group that the worker has worked on
        comes first, then a task of a group that no worker has worked on."""
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
        """The result of a task that had a `limit` [s] of processor time. It is `Lost` if the worker
        has ended, with an empty reason if the worker never was ready."""
        error = future.exception()
        if error is None:
            self._unready = 0
            return future.result()
        if not isinstance(error, (BrokenExecutor, MemoryError)):
            raise error
        worker.end()  # a worker that ran out of memory is given no other task
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
    """Yields each task with its result. The executor is `Workers`; or another one with `count`
    processes, which repeats lost tasks itself; or None: then tasks are done in this process."""
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
    """Waits until some of the running tasks are done, removes them, and yields their results."""
    for future in wait(running, return_when=FIRST_COMPLETED).done:
        yield running.pop(future), future.result()


def spent() -> float:
    """The processor time [s] that this process and its children, living or ended, have used."""
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
    """Returns why a process ended, from its exit code. The task of the process had a `limit` [s] of
    processor time."""
    if hasattr(signal, "SIGPROF") and code == -signal.SIGPROF:
        return f"no answer within {limit:.3g} s of processor time"
    if code >= 0:
        return f"its process ended with exit code {code}"
    named = {-number: number.name for number in signal.Signals}
    return f"its process was ended by {named.get(code, f'signal {-code}')}"


def _serve(theirs: connection.Connection, module: str) -> None:
    """Runs in a worker: imports the module that tasks need, then does one task after the other."""
    beginner = multiprocessing.parent_process()
    assert beginner is not None
    threading.Thread(target=_end_with, args=(beginner.sentinel,), daemon=True).start()
    with suppress(
        ImportError, MemoryError
    ):  # a task that needs the module raises the error again
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
    """Has the system end this process when it has used `seconds` more of processor time, even
    within a call of a library that does not return. 0 stops the timer."""
    if hasattr(signal, "ITIMER_PROF"):  # not on Windows
        signal.setitimer(signal.ITIMER_PROF, min(seconds, LONGEST_TIMER))


def _outcome(
    do: Callable[..., Any], arguments: tuple[Any, ...]
) -> tuple[Any, Exception | None, str]:
    """The result of a task, or the exception that the task raises with its traceback."""
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
    """Ends this process when the process that began it has ended."""
    connection.wait([sentinel])
    os._exit(1)


@contextmanager
def workers_of(jobs: int | Workers) -> Iterator[Workers]:
    """The given workers, or a number of new ones, which end with the context."""
    if isinstance(jobs, Workers):
        yield jobs
        return
    with Workers(jobs) as workers:
        yield workers


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Holds back interrupts (SIGINT) within the context. Processes that begin within it never see
    an interrupt; this process receives it afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # begun now: later it would unblock interrupts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
