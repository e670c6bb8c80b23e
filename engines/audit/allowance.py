"""The processor time that a part of an audit may take, and the processes that share its work."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from typing import Any

from plumbob.engines.audit.user_models import quietly


class Allowance:
    """About `seconds` of processor time from now on. Work is done in an `executor` of two processes
    or more, if given; `progress` is called with a description of the work."""

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
        """The processor time [s] that has been spent."""
        return time.process_time() - self.begin

    @property
    def left(self) -> float:
        """The processor time [s] that is left."""
        return self.seconds - self.spent

    def part(self, fraction: float) -> Allowance:
        """Returns an allowance from now on, a fraction of the whole."""
        return Allowance(fraction * self.seconds, self.executor, self.progress)

    def start(self, do: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
        """Starts a call of a function in the executor; returns a function that waits for the
        result. Without an executor the call is made by that function."""
        if self.executor is None:
            return partial(do, *arguments)
        return self.executor.submit(quietly, do, *arguments).result
