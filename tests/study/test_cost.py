"""The timed part of a scene: it fits the budget and is long enough to represent the whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco.trimming import trimming
from plumbob.engines.registry import method as find_method
from plumbob.engines.study import cost
from plumbob.engines.trajectory import Trajectory
from plumbob.models.registry import scene as find_scene
from plumbob.models.registry import system_of

SCENE = find_scene("simple-pendulum/free-large")  # 50 s


def timed(method: str, step: float, budget: float) -> Any:
    return cost._sized(system_of(SCENE).case(SCENE), find_method(method), step, budget)


@pytest.mark.parametrize(("method", "step"), [("ode/dop853", 1e-8), ("ode/radau", 1e-4)])
def test_a_long_adaptive_run_is_cut(method: str, step: float) -> None:
    piece = timed(method, step, budget=1e-9)  # so that evaluations decide, and no clock
    assert piece.duration <= SCENE.duration / 4
    # The first step of a solver costs more than the rest; from 300 on it is a per cent or two.
    assert cost.EVALUATIONS <= piece.run().steps <= 3 * cost.EVALUATIONS


def test_what_fits_the_budget_is_run_whole() -> None:
    assert timed("ode/dop853", 1e-8, budget=1e3).duration == SCENE.duration
    assert timed("mujoco/euler", 1e-1, budget=1e-9).steps == 500
    assert 2000 <= timed("mujoco/euler", 1e-4, budget=4e-3).steps < 500_000


@dataclass
class Clock:
    """What stands in for the module `time`: it advances when a test says so."""

    wall: float = 7.0  # [s]
    computed: float = 3.0  # [s]

    def perf_counter(self) -> float:
        return self.wall

    def thread_time(self) -> float:
        return self.computed

    def go(self, wall: float, computed: float) -> None:
        """Let `wall` [s] pass, of which this thread computes for `computed` [s]."""
        self.wall += wall
        self.computed += computed


@pytest.mark.parametrize("computing", [0.02, 0.05])
def test_waiting_is_no_cost(computing: float, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock()
    monkeypatch.setattr(cost, "time", clock)

    def run() -> Trajectory:
        clock.go(0.1, computing)
        return Trajectory(np.zeros(2), {}, steps=1, seconds=0.1)

    fraction, found = cost._computing(run)
    assert fraction * found.seconds == pytest.approx(computing, rel=1e-12)


def test_clocks_that_disagree_cost_no_more_than_the_wall_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    monkeypatch.setattr(cost, "time", clock)

    def run() -> Trajectory:
        clock.go(0.1, 0.101)
        return Trajectory(np.zeros(2), {}, steps=1, seconds=0.1)

    assert cost._computing(run)[0] == 1.0


def test_a_cost_is_computing_time_over_steps_with_its_quartiles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock, computing = Clock(), iter((3.0, 1.0, 10.0, 2.0, 4.0))  # [ms] of five rounds

    class Waiting:
        compile_seconds = 0.5

        def run(self) -> Trajectory:
            spent = 1e-3 * next(computing)
            clock.go(2.0 * spent, spent)
            return Trajectory(np.zeros(2), {}, steps=1000, seconds=2.0 * spent)

    monkeypatch.setattr(cost, "time", clock)
    monkeypatch.setattr(cost, "_sized", lambda *_: Waiting())
    monkeypatch.setattr(cost, "reference_step", lambda: lambda: 500.0)
    task = system_of(SCENE).case(SCENE), find_method("mujoco/euler"), 1e-3
    found, unit = cost.costs([task])
    one = found[SCENE.name, "mujoco/euler"]
    assert unit == 500.0
    assert (one.ns_per_step, one.ratio) == pytest.approx((3000.0, 6.0), rel=1e-9)
    assert (one.low, one.high) == pytest.approx((1500.0, 7000.0), rel=1e-9)
    assert (one.compile_seconds, one.repeats) == (0.5, 5)


@pytest.mark.parametrize("name", ["capsule-turn", "capsule-line", "simple-pendulum/forced-small"])
def test_what_a_model_leaves_out_is_timed_whatever_its_controls(name: str) -> None:
    scene = find_scene(name)
    method = "mujoco/euler+coulomb" if name.startswith("capsule") else "mujoco/euler"
    found = trimming(system_of(scene).case(scene), find_method(method), 1e-4, steps=50, repeats=1)
    assert found.identical
