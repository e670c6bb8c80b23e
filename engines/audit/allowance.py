"""The time that a part of an audit may take, and the processes that share its work."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from typing import Any

from plumbob.engines.audit.user_models import quietly


class Allowance:
    """About so many `seconds` of processor time, from now on; work is done in an `executor` of two
    processes or more, if given, and `progress` is called with what is being done."""

    def __init__(
        self,
        seconds: float = math.inf,
        executor: Executor | None = None,
        progress: Callable[[str], None] = lambda what: None,
    ) -> None:
        self.seconds, self.executor, self.progress = seconds, executor, progress
        self.begin = time.process_time()

    @property
    def spent(self) -> float:
        """[s]"""
        return time.process_time() - self.begin

    @property
    def left(self) -> float:
        """[s]"""
        return self.seconds - self.spent

    def part(self, fraction: float) -> Allowance:
        """A fraction of all of it, from now on."""
        return Allowance(fraction * self.seconds, self.executor, self.progress)

    def start(self, do: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
        """Call a function beside what follows; its result is then waited for. Without an executor
        it is called when that is asked for."""
        if self.executor is None:
            return partial(do, *arguments)
        return self.executor.submit(quietly, do, *arguments).result
