"""The integration of an exact motion within a budget of processor time."""

from __future__ import annotations

import time
from collections.abc import Callable

from plumbob.models.scene import Case


class _OutOfTime(Exception):
    """The budget of processor time is spent."""


def integrated(
    case: Case, last: float, seconds: float, progress: Callable[[float, float], None]
) -> float:
    """Integrates the exact motion of a case up to `last` [s], if it has no closed form. The case
    keeps the motion for later use. Returns the time [s] until which the motion is certified: less
    than `last` if `seconds` of processor time do not suffice. Before each step `progress` is called
    with the time reached [s] and the processor time spent [s]."""
    begin = time.process_time()
    until = last

    def watch(reached: float) -> None:
        """Reports the time reached [s]; raises _OutOfTime if the budget is spent."""
        nonlocal until
        spent = time.process_time() - begin
        if spent > seconds:
            until = reached
            raise _OutOfTime
        progress(reached, spent)

    try:
        if integrate := getattr(case.reference, "certify", None):
            integrate(last, watch)
    except _OutOfTime:
        pass
    return until
