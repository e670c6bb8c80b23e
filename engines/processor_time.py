"""The processor time of this process, all of its threads together."""

from __future__ import annotations

import time


def processor_time() -> float:
    """The processor time [s] that this process has used, to a microsecond.

    While a limit on processor time is set, as in a worker, `time.process_time` is only updated
    every few milliseconds on Linux."""
    try:
        import resource
    except ImportError:  # Windows, where a worker sets no limit on processor time
        return time.process_time()
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime
