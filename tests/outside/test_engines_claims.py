"""What an added engine says of its own runs is held to what was asked of it: times, samples, the
end, the number of steps, and what a step costs."""

import pytest

from plumbob.engines import sampling
from plumbob.engines.trajectory import Trajectory
from plumbob.models import entry_points
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


def claiming(site, run="run", seconds="timed.seconds"):
    """Install the engine of engines/README.md, with a simulation that says this of its runs."""
    text = ENGINE.replace("return stepped(", "return Claiming(stepped(")
    text = text.replace("(case, step, build)", "(case, step, build))")
    points = {entry_points.ENGINES: {"tiny": "theirs:ENGINE"}}
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


@pytest.mark.parametrize(("late", "why"), [(5e-7, ""), (1e-5, "ends at")])
def test_a_clock_that_rounds_is_no_other_grid(late, why):
    """A thousandth of a step is what adding up times may round; a hundredth is another time."""
    times = sampling.sampled(1000) * 1e-3
    run = Trajectory(times * (1.0 + late), {"theta": times}, steps=1000)
    short = sampling.cut_short(run, 1.0, 1e-3)
    assert why in short
    assert bool(short) == bool(why)
