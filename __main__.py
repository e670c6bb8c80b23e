"""`python -m plumbob`, and the command `plumbob`: an interrupt while it loads is one line, too."""

import gc
import os
import sys

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]

INTERRUPTED = 130
# new objects, after which Python looks for those that nothing refers to any more
LIVING = 100_000


def main() -> int:
    """Run the command line; returns its exit code."""
    # No command opens a window: MuJoCo need not look for a library that does, which takes a process
    # of its own that an interrupt of the terminal would end with a traceback.
    os.environ.setdefault("MUJOCO_GL", "disable")
    # OpenBLAS ends a process, as an interrupt would, if memory does not suffice for its threads.
    if resource and resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(LIVING)  # a study's records stay to the end: 700 takes a tenth of a report
    try:
        from plumbob.reports.cli import main as run

        return run()
    except KeyboardInterrupt:
        print("plumbob: interrupted", file=sys.stderr)
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
