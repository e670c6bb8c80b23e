"""What an added engine says of its own runs is held to what was asked of it: times, samples, the
end, the number of steps, and what a step costs."""

import os
import subprocess
import sys
from contextlib import contextmanager, nullcontext

import pytest

from plumbob.engines import sampling
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import study_with_true_cost, timed_run
from plumbob.engines.study.cost import false_cost
from plumbob.engines.trajectory import Trajectory
from plumbob.models import entry_points
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.cli import main
from plumbob.tests.commands.outcomes import validated, without_pages
from plumbob.tests.outside.installed_packages import ENGINE, install, seen

SMALL = "simple-pendulum/free-small"
CLAIMING = """
from dataclasses import replace
from plumbob.engines.method import Stepping


def part(run, kept):
    observables = {name: values[kept] for name, values in run.observables.items()}
    return replace(run, times=run.times[kept], observables=observables)


class Claiming:
    def __init__(self, own):
        self.own, self.compile_seconds = own, own.compile_seconds

    def run(self):
        run = self.own.run()
        return %s

    def stepped(self, fraction):
        timed = self.own.stepped(fraction)
        return Stepping(timed.steps, %s)
"""
RUNS = {
    "honest": ("run", ""),
    "ends at 10 %": ("part(run, slice(len(run.times) // 10))", "s of 50 s"),
    "first sample alone": ("part(run, slice(0, 1))", "its 1 times do not increase"),
    "last one dropped": ("part(run, slice(-1))", "s of 50 s"),
    "first and last alone": ("part(run, [0, -1])", "its 2 samples are not those at the"),
    "no time passes": ("replace(run, times=0.0 * run.times)", "do not increase"),
    "ten times the steps": ("replace(run, steps=10 * run.steps)", "steps, and takes"),
    "a tenth of the steps": ("replace(run, steps=run.steps // 10)", "steps, and takes"),
    "1e16 times the steps": ("replace(run, steps=10**16 * run.steps)", "steps, and takes"),
    "no number of steps": ("replace(run, steps='all')", "it counts all steps, and takes"),
    "a time is no number": ("replace(run, times=run.times * float('nan'))", "do not increase"),
}
COSTS = {  # seconds that `stepped` claims of what its steps took, and whether they are refused
    "honest": ("timed.seconds", False),
    "half": ("timed.seconds / 2", False),
    "a tenth": ("timed.seconds / 10", True),
    "ten times": ("timed.seconds * 10", True),
    "the same for any steps": ("1e-9", True),
}


def claiming(site, run="run", seconds="timed.seconds"):
    """Install the small engine of these tests, with a simulation that says this of its runs."""
    text = ENGINE.replace("return stepped(", "return Claiming(stepped(")
    text = text.replace("(case, step, build)", "(case, step, build))")
    points = {entry_points.ENGINE_GROUP: {"tiny": "theirs:ENGINE"}}
    install(site, "their-package", points, theirs=text + CLAIMING % (run, seconds))


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("kind", RUNS)
def test_a_run_is_the_one_that_was_asked_for(kind, tmp_path, monkeypatch, capsys):
    run, why = RUNS[kind]
    claiming(tmp_path / "site", run)
    without_pages(monkeypatch)
    with seen(tmp_path / "site"):
        found = validated(tmp_path, capsys, SMALL, "tiny")
    assert found.code == (1 if why else 0), found.out
    said = found.failure(SMALL, "tiny/euler")
    assert bool(said) == bool(why)
    if why:
        assert said.startswith("cut-short, expected predicted: the run is cut short: ")
        assert why in said
        assert f"UNEXPECTED {SMALL} tiny/euler: cut-short" in found.out


@contextmanager
def busy_machine():
    """Every processor has two processes that compute."""
    spin = [sys.executable, "-c", "while True: pass"]
    others = [subprocess.Popen(spin) for _ in range(2 * (os.cpu_count() or 1))]
    try:
        yield
    finally:
        for other in others:
            other.kill()
            other.wait()


@pytest.mark.parametrize(
    ("kind", "busy"), [*((kind, False) for kind in COSTS), ("honest", True), ("a tenth", True)]
)
def test_a_claimed_cost_is_held_to_the_processor_time_of_runs(kind, busy, tmp_path):
    """The factor is 3: a claim of half passes, one of a tenth does not, whatever else runs."""
    seconds, refused = COSTS[kind]
    claiming(tmp_path / "site", seconds=seconds)
    with seen(tmp_path / "site"), busy_machine() if busy else nullcontext():
        why = false_cost(case_of(find_scene(SMALL)), find_method("tiny/euler"), 1e-3)
    assert bool(why) == refused, why
    assert not refused or "of processor time" in why


def test_a_study_cuts_a_run_short_whose_cost_is_false(tmp_path):
    claiming(tmp_path / "site", seconds="timed.seconds / 10")
    with seen(tmp_path / "site"):
        method = find_method("tiny/euler")
        study = study_with_true_cost(find_scene(SMALL), method, 50_000, 1)
    (run,) = (run for run in study.measurements if run.status != "done")
    assert (run.status, run.step) == ("cut-short", 1e-3)
    assert run.reason.startswith("stepped() claims")
    assert timed_run(study, method) is None


@pytest.mark.long(keep=1)
@pytest.mark.parametrize(
    "command", ["check-engine tiny --scenes {}", "run {} tiny/euler --step 1e-3"]
)
def test_a_false_cost_is_refused_with_one_line(command, tmp_path, capsys):
    claiming(tmp_path / "site", seconds="timed.seconds / 10")
    with seen(tmp_path / "site"):
        assert main(command.format(SMALL).split()) == 1
    out = capsys.readouterr().out
    (line,) = (line for line in out.splitlines() if "stepped() claims" in line)
    assert "ns a step, its runs take" in line


@pytest.mark.parametrize(("late", "why"), [(5e-7, ""), (1e-5, "ends at")])
def test_a_clock_that_rounds_is_no_other_grid(late, why):
    """A thousandth of a step is what adding up times may round; a hundredth is another time."""
    times = sampling.sampled(1000) * 1e-3
    run = Trajectory(times * (1.0 + late), {"theta": times}, steps=1000)
    short = sampling.cut_short(run, 1.0, 1e-3)
    assert why in short
    assert bool(short) == bool(why)
