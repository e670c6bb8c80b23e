"""A small study by `plumbob validate` in processes of its own, which a test ends too early."""

import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

from plumbob.engines.study.store import FILE, load

SCENE = "linear-pendulum/overdamped"
METHODS = "ode/rk4,ode/leapfrog,mujoco/euler"
ENDS = 2.0  # [s] after which an interrupted study has ended
LOADED = 10.0  # times that on a machine with other work
# Keeps a list of the results that were measured, to tell whether one was measured twice.
COUNTED = """
import sys
from plumbob.engines.study.checkpoint import Checkpoint
usual = Checkpoint.keep
def keep(self, results):
    usual(self, results)
    with open(log, "a", encoding="utf-8") as kept:
        for key, result in results.items():
            kept.write(f"{'lost ' if result.lost else ''}{key}\\n")
Checkpoint.keep = keep
from plumbob.__main__ import main
if __name__ == "__main__":
    %s
    log = sys.argv.pop(1)
    sys.exit(main())
"""


def words(out, jobs, *more):
    """The command line of the study."""
    wanted = ("--scenes", SCENE, "--methods", METHODS)
    return ["validate", *wanted, "--out", str(out), "--jobs", str(jobs), *more]


def begun(out, jobs, first=""):
    """The study, begun in a process group of its own; `first` is run before."""
    return subprocess.Popen(
        [sys.executable, "-c", COUNTED % first, str(out / "log"), *words(out, jobs)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def logged(out):
    """The results that were measured, in the order in which they were kept."""
    file = out / "log"
    return file.read_text("utf-8").splitlines() if file.exists() else []


def until(true, process):
    """Wait until something is so, or the process has ended."""
    while process.poll() is None and not true():
        time.sleep(0.005)


def group(leader):
    """The processes of a group that still run."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text("ascii", "replace").rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[2]) == leader and fields[0] != "Z":
                found.append(int(entry.name))
    return found


def ended(process):
    """What it has written on stderr, and the time [s] until the last process of its group ended."""
    begin = time.monotonic()
    _, err = process.communicate(timeout=60.0)
    while group(process.pid) and time.monotonic() - begin < LOADED * ENDS:
        time.sleep(0.01)
    return err, time.monotonic() - begin


def stored(out):
    """The newest study of a folder."""
    found = load(out / FILE)
    assert found is not None
    return found


def figures(out):
    """The figures of the newest study of a folder that do not depend on how long it took."""
    return {
        (c.scene, c.method): [(m.step, m.status, m.steps, m.errors) for m in c.measurements]
        for c in stored(out).convergence
    }


def rows(out):
    """How many studies, and how many rows in all, a folder's store has."""
    with closing(sqlite3.connect(f"file:{out / FILE}?mode=ro", uri=True)) as opened:
        return opened.execute("select count(distinct study), count(*) from result").fetchone()
