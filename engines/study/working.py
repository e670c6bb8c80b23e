"""Works out the pieces of a study: those that are there are taken, others claimed, and kept."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

from plumbob.engines.study.unfinished import PAUSE, Piece, Pieces
from plumbob.engines.workers import Work, Workers

if TYPE_CHECKING:  # reading a stored study starts no processes
    from concurrent.futures import Executor

Progress = Callable[[str, int, int], None]  # what is being done, how many are done, of how many
PREDICTED = 3e-5  # [s] of a unit of work, the most that a quick run took
GENEROUS = 100.0  # times that, and at least:
LEAST = 300.0  # [s], before a piece of work hangs


@dataclass(frozen=True)
class Task:
    """A piece of work for one process, its key in a store, and roughly how many steps of a pendulum
    it takes."""

    label: str
    key: str
    group: str  # what shares references and models
    work: float
    do: Callable[..., Piece]
    arguments: tuple[Any, ...]

    def asked(self) -> Work:
        """The same for a worker."""
        limit = LEAST + GENEROUS * PREDICTED * self.work
        return Work(_done, (self.do, self.arguments), limit, self.group)


def _done(do: Callable[..., Piece], arguments: tuple[Any, ...]) -> Piece:
    """What a piece gives, and the time [s] that it took."""
    begin = time.perf_counter()
    return replace(do(*arguments), seconds=time.perf_counter() - begin)


@dataclass(frozen=True)
class Working:
    """Who works, where it is kept, and who is informed; without workers, this process works."""

    workers: Workers | None
    kept: Pieces
    progress: Progress
    lost: list[str]  # why costs were given up, the last one last


def worked_out(
    tasks: Mapping[Hashable, Task],
    work: Working,
    executor: Executor | None = None,
    count: int | None = None,
) -> dict[Hashable, Piece]:
    """The pieces of all tasks: those that are there, those worked out by us, and those that
    another process works out meanwhile."""
    names = {task.key: name for name, task in tasks.items()}
    found = {names[key]: piece for key, piece in work.kept.there(list(names)).items()}

    def done(name: Hashable, piece: Piece) -> None:
        work.kept.keep(tasks[name].key, piece)
        found[name] = piece

    def lost(name: Hashable, why: str) -> None:
        done(name, Piece(lost=why))

    while rest := {name: task for name, task in tasks.items() if name not in found}:
        queue = _Queue(rest, work, lambda: (len(found), len(tasks)))
        if executor is not None:
            _by_executor(executor, queue, done)
        elif work.workers is not None:
            work.workers.work_out(queue.take, done, lost, count)
        else:
            last: Hashable | None = None
            while taken := queue.take(last, careful=True):
                last, one = taken
                done(last, one.do(*one.arguments))
            if queue.cut_off:  # a process ended at these: they are worked out in another
                with Workers(1) as workers:
                    workers.work_out(queue.again, done, lost)
        if len(found) < len(tasks):
            missing = [task.key for name, task in tasks.items() if name not in found]
            there = work.kept.there(missing)
            found.update({names[key]: piece for key, piece in there.items()})
            if not there:
                work.kept.waits("measures")
                time.sleep(PAUSE)
    return found


def _by_executor(
    executor: Executor, queue: _Queue, done: Callable[[Hashable, Piece], None]
) -> None:
    from concurrent.futures import as_completed

    waiting = {}
    while taken := queue.take(None):
        name, one = taken
        waiting[executor.submit(one.do, *one.arguments)] = name
    for future in as_completed(waiting):
        done(waiting[future], future.result())


class _Queue:
    """Tasks in the order in which they are begun: those that share a scene by the same worker, the
    long ones first, so that nobody is left with one at the end."""

    def __init__(
        self, tasks: Mapping[Hashable, Task], work: Working, count: Callable[[], tuple[int, int]]
    ) -> None:
        groups = Counter[str]()
        for task in tasks.values():
            groups[task.group] += math.ceil(task.work)
        order = sorted(tasks, key=lambda n: (-groups[tasks[n].group], tasks[n].group,
                                             -tasks[n].work))  # fmt: skip
        self._waiting = {name: tasks[name] for name in order}
        self._tasks, self._work, self._count = tasks, work, count
        self._begun: set[str] = set()
        self.cut_off: list[Hashable] = []

    def take(self, last: Hashable | None, careful: bool = False) -> tuple[Hashable, Work] | None:
        """The next one that is ours, for who has worked on `last`; with `careful` none at which a
        process has ended."""
        group = self._tasks[last].group if last in self._tasks else None
        while self._waiting:
            same = (n for n, t in self._waiting.items() if t.group == group)
            new = (n for n, t in self._waiting.items() if t.group not in self._begun)
            name = next(chain(same, new, self._waiting))
            task = self._waiting.pop(name)
            claim = self._work.kept.claim(task.key, task.label)
            if claim == "cut off" and careful:
                self.cut_off.append(name)
            elif claim in ("ours", "cut off"):
                self._begun.add(task.group)
                self._work.progress(task.label, *self._count())
                return name, task.asked()
        return None

    def again(self, last: Hashable | None) -> tuple[Hashable, Work] | None:
        """The next one of those at which a process has ended."""
        return (name := self.cut_off.pop(), self._tasks[name].asked()) if self.cut_off else None
