"""The timed part of a scene: it fits the budget and is long enough to represent the whole."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat

import pytest

from plumbob.engines.method import Stepping
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.engines.study import cost
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

SCENE = find_scene("simple-pendulum/free-large")  # 50 s


@dataclass
class Clock:
    """What stands in for the module `time`: each look at the wall clock is 100 s after the last,
    while this thread computed for 1 s."""

    computed: float = 0.0  # [s]
    wall: float = 0.0  # [s]

    def perf_counter(self):
        self.wall += 100.0
        return self.wall

    def thread_time(self):
        self.computed += 1.0
        return self.computed


@pytest.mark.parametrize(("method", "step"), [("mujoco/rk4", 1e-2), ("ode/dop853", 1e-4)])
def test_waiting_is_no_cost(method, step, monkeypatch):
    chosen = find_method(method)
    simulation = engine_of(chosen).prepare(case_of(SCENE), chosen, step)
    monkeypatch.setattr("plumbob.engines.adapters.stepping.time", Clock())
    assert simulation.stepped(0.1).seconds == 1.0


@dataclass
class Slow:
    """A simulation whose turns of 1000 steps, and the reference steps before and after each, take
    what `milliseconds` and `rules` [ns] give."""

    milliseconds: Iterator[float]
    compile_seconds: float = 0.5

    def stepped(self, fraction):
        assert fraction == 0.25
        return Stepping(1000, 1e-3 * next(self.milliseconds))


def cost_of(patch, milliseconds, rules):
    """What is made of these times, and the unit [ns]."""
    piece = cost.TimedSteps(Slow(iter(milliseconds)), 0.25)
    steps = iter(rules)
    patch.setattr(cost, "first_steps", lambda *_: piece)
    patch.setattr(cost, "reference_step", lambda _: lambda: next(steps))
    found = cost.costs(SCENE, [(find_method("mujoco/euler"), 1e-3)], budget=1e-3)
    return found.by_method["mujoco/euler"], found.reference_step


@pytest.mark.parametrize(
    ("milliseconds", "median", "low", "high"),
    [
        ((3.0, 1.0, 10.0, 2.0, 4.0), 3.0, 1.5, 7.0),
        ((3.0, 3.23, 3.02), 3.02, 3.0, 3.23),  # close to each other: two rounds less
        ((3.0, 9.0, 3.02, 3.04), 3.03, 3.005, 7.51),  # three of four are
        ((1.0, 3.0, 3.02, 9.0, 3.04), 3.02, 2.0, 6.02),  # three of five
        ((1.0, 2.0, 3.0, 3.01, 3.02), 3.0, 1.5, 3.015),  # the median is one of them
        ((3.0, 3.25, 3.12, 3.12), 3.12, 3.03, 3.2175),
    ],
)
def test_a_cost_is_computing_time_over_steps_with_its_quartiles(
    milliseconds, median, low, high, monkeypatch
):
    one, unit = cost_of(monkeypatch, milliseconds, repeat(500.0))
    assert unit == 500.0
    assert (one.ns_per_step, one.ratio) == pytest.approx((1e3 * median, 2 * median), rel=1e-9)
    assert (one.low, one.high) == pytest.approx((1e3 * low, 1e3 * high), rel=1e-9)
    assert (one.compile_seconds, one.repeats) == (0.5, len(milliseconds))


def test_a_machine_that_becomes_slower_changes_no_cost(monkeypatch):
    """All of it takes three times as long from the second round on, or grows slower evenly."""
    one, unit = cost_of(monkeypatch, (3.0, 9.0, 9.0), (500.0, 500.0, 2500.0, 500.0))
    assert (one.ratio, unit) == pytest.approx((6.0, 500.0))
    one, unit = cost_of(monkeypatch, (3.0, 6.0, 9.0), (250.0, 750.0, 1250.0, 1750.0))
    assert (one.ratio, one.repeats, unit) == pytest.approx((6.0, 3, 1000.0))
    assert (one.ns_per_step, one.low, one.high) == pytest.approx((6000.0, 6000.0, 6000.0))


@pytest.mark.parametrize(("method", "step"), [("mujoco/euler", 1e-4), ("ode/dop853", 1e-8)])
def test_a_piece_gets_as_long_as_its_time_tells_enough(method, step):
    piece = cost.first_steps(case_of(SCENE), find_method(method), step)
    run = piece.stepped()
    assert method == "ode/dop853" or run.steps == cost.MIN_TIMED_STEPS
    while longer := piece.longer(run, 2e-3):
        piece = longer
        run = longer.stepped()
    assert run.seconds >= 1e-3
    assert run.steps >= piece.least
    assert piece.fraction < 0.5
