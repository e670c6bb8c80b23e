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
    # No command but `view` opens a window. MuJoCo's search for a graphics library starts a process;
    # that process prints a traceback when the terminal is interrupted.
    if sys.argv[1:2] != ["view"]:
        os.environ.setdefault("MUJOCO_GL", "disable")
    # OpenBLAS ends a process, as an interrupt would, if memory does not suffice for its threads.
    if resource and resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # A study keeps its records to the end: with Python's own threshold of 700 objects, looking for
    # garbage takes a tenth of the time of a report.
    gc.set_threshold(LIVING)
    try:
        from plumbob.reports.cli import main as run

        return run()
    except KeyboardInterrupt:
        print("plumbob: interrupted", file=sys.stderr)
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(main())
