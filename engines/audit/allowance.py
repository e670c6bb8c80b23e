"""The time that a part of an audit may take, and the processes that share its work."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from typing import Any

Clock = Callable[[], float]


def _silent(what: str) -> None:
    """Nobody is informed."""


class Allowance:
    """About so many `seconds` by a clock, from now on; work is done in an `executor` of two
    processes or more, if given, and `progress` is called with what is being done."""

    def __init__(
        self,
        seconds: float = math.inf,
        clock: Clock = time.process_time,
        executor: Executor | None = None,
        progress: Callable[[str], None] = _silent,
    ) -> None:
        self.seconds, self.clock, self.executor, self.progress = seconds, clock, executor, progress
        self.begin = clock()

    @property
    def spent(self) -> float:
        """[s]"""
        return self.clock() - self.begin

    @property
    def left(self) -> float:
        """[s]"""
        return self.seconds - self.spent

    def part(self, fraction: float) -> Allowance:
        """A fraction of all of it, from now on."""
        return Allowance(fraction * self.seconds, self.clock, self.executor, self.progress)

    def start(self, do: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
        """Call a function beside what follows; its result is then waited for. Without an executor
        it is called when that is asked for."""
        if self.executor is None:
            return partial(do, *arguments)
        return self.executor.submit(do, *arguments).result
