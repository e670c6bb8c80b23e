"""Time saved by a second process in the error half of a study, and time that pages take.

Wall times are significant only on an idle machine, the processor time of each process on any. Run
alone: pytest -s tests/benchmarks/test_study_speed.py
"""

import os
import resource
import subprocess
import sys
import time

import pytest

from plumbob.engines.registry import engine_of, installed, methods
from plumbob.engines.study import store
from plumbob.engines.study.runner import run_study
from plumbob.models.registry import matching_scenes
from plumbob.tests.site import whole_profile
from plumbob.tests.support.benchmark_runs import in_turn
from plumbob.tests.support.stored import save

SCENES = "simple-pendulum,linear-pendulum"
SAVED = 1.5  # required speed-up by two processes, which take a second each to start
STARTS = 4.0  # of Python with numpy, that an answer from a stored study may take
# of these in processor time, that pages may take: of a measured study three seconds
PAGES = 22.0
QUIET = 0.9  # processor time per wall time of a process on an idle machine


def _study(jobs=1, pattern="*"):
    here = [m for m in methods(pattern) if installed(engine_of(m))]
    return run_study(matching_scenes(SCENES, "quick"), here, jobs=jobs, timed=False)


def _wall(jobs=1):
    """Wall time [s] of the study."""
    begin = time.perf_counter()
    _study(jobs)
    return time.perf_counter() - begin


def _computed(who=resource.RUSAGE_SELF):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core")
def test_the_error_half_on_two_processes(hold):
    # what one process loads, once
    _study(pattern="mujoco/euler,pymunk/default,ode/lsoda,heyoka")
    begin = _computed()
    alone = _wall()
    computed = _computed() - begin
    begin = _computed()
    others = _computed(resource.RUSAGE_CHILDREN)
    both = _wall(2)
    here = _computed() - begin
    there = _computed(resource.RUSAGE_CHILDREN) - others
    each = here + there / 2  # this process hands out pieces, and two others work
    print(
        f"\nwall {alone:.1f} s alone, {both:.1f} s by two: {alone / both:.2f} times; computed "
        f"{computed:.1f} s alone, {here:.1f} s here and {there:.1f} s by two others"
    )
    hold(
        "processor time of a study: alone over each of two", [computed / each] * 2, least=SAVED
    )
    if min(computed / alone, each / both) >= QUIET:
        assert alone / both >= SAVED


def _seconds(*words):
    """Wall time [s] of a command of Python."""
    begin = time.perf_counter()
    subprocess.run([sys.executable, *words], capture_output=True, check=True)
    return time.perf_counter() - begin


def _processor(*words):
    """Processor time [s] of a command of Python."""
    begin = _computed(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *words], capture_output=True, check=True)
    return _computed(resource.RUSAGE_CHILDREN) - begin


def test_recommend_answers_in_a_few_starts_of_python(tmp_path, hold):
    (scene, *_), here = matching_scenes(SCENES, "quick"), methods("mujoco/euler,ode/rk4")
    save(run_study([scene], here), tmp_path / store.FILE)
    asked = ("recommend", scene.name, "--error", "1e-1", "--out", str(tmp_path), "--stored")
    turns = in_turn(
        lambda: _seconds("-m", "plumbob", *asked), lambda: _seconds("-c", "import numpy"), 7
    )
    hold("recommend of a stored study over importing numpy", turns, most=STARTS)


def test_report_draws_a_study_in_a_few_starts_of_python(tmp_path, hold):
    """The whole quick profile, invented: nothing is worked out, and so what is measured is what
    reading and writing take."""
    save(whole_profile.shown().common["study"], tmp_path / store.FILE)
    asked = ("-m", "plumbob", "report", str(tmp_path))
    turns = in_turn(lambda: _processor(*asked), lambda: _processor("-c", "import numpy"), 7)
    hold("report of the quick profile over importing numpy", turns, most=PAGES)
