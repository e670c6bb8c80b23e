"""A small study by `plumbob validate` in processes of its own, which a test ends too early."""

import os
import resource
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

from plumbob.engines.study.checkpoint import Checkpoint, measured_into
from plumbob.engines.study.cost import SceneCosts
from plumbob.engines.study.results import TaskResult
from plumbob.engines.study.store import FILE, load
from plumbob.reports.cli import main

SCENE = "linear-pendulum/overdamped"
METHODS = "ode/rk4,ode/leapfrog,mujoco/euler"
ENDS = 2.0  # [s] after which an interrupted study has ended
LOADED = 10.0  # times that on a machine with other work


def words(out, jobs, *more):
    """The command line of the study."""
    wanted = ("--scenes", SCENE, "--methods", METHODS)
    return ["validate", *wanted, "--out", str(out), "--jobs", str(jobs), *more]


def begun(out, jobs, ends=0, number=0, limit=0):
    """The study, begun in a process group of its own: see `study` and `listing`."""
    asked = (str(out / "log"), words(out, jobs), ends, number, limit)
    return subprocess.Popen(
        [sys.executable, "-c", f"from {__name__} import study; study(*{asked})"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def study(log, words, ends, number, limit):
    """Measure, and list results as `listing` does, with files no larger than a `limit` [bytes], if
    any; the process ends."""
    Checkpoint.keep = listing(log, ends, number)
    if limit:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(main(words))


def listing(log, ends=0, number=0):
    """`Checkpoint.keep` that lists results as they are kept; the one of number `ends` gets a signal
    `number`."""
    keep = Checkpoint.keep
    kept = []

    def listed(self, results):
        kept.extend(results)
        if number and len(kept) == ends:
            os.kill(os.getpid(), number)
        keep(self, results)
        with open(log, "a", encoding="utf-8") as file:
            file.writelines(f"{key}\n" for key in results)

    return listed


def measures(file, kept):
    """Begin a study in a store with one result of two, say that it is `kept`, and wait for the
    end."""
    with measured_into(file) as checkpoint:
        checkpoint.begin("a plan", ["one", "two"])
        checkpoint.keep({"one": TaskResult(SceneCosts("", {}, 1.0))})
        kept.set()
        signal.pause()


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
                fields = (
                    (entry / "stat").read_text("ascii", "replace").rpartition(")")[2].split()
                )
            except OSError:
                continue
            if int(fields[2]) == leader and fields[0] != "Z":
                found.append(int(entry.name))
    return found


def ended(process):
    """What it has written on stderr, and the time [s] until the last process of its group ended."""
    begin = time.monotonic()
    _, err = process.communicate(timeout=300.0)
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
