"""The timed part of a scene: it fits the budget and is long enough to represent the whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from plumbob.engines.adapters.mujoco import trimming as trimming_
from plumbob.engines.adapters.mujoco.trimming import trimming
from plumbob.engines.method import Stepping
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.engines.study import cost
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene

SCENE = find_scene("simple-pendulum/free-large")  # 50 s


def timed(method: str, step: float, budget: float) -> Any:
    return cost._sized(case_of(SCENE), find_method(method), step, budget)


@pytest.mark.parametrize(("method", "step"), [("ode/dop853", 1e-8), ("ode/radau", 1e-4)])
def test_a_long_adaptive_run_is_cut(method: str, step: float) -> None:
    piece = timed(method, step, budget=1e-9)  # so that evaluations decide, and no clock
    assert piece.fraction <= 1 / 4
    # The first step of a solver costs more than the rest; from 300 on it is a per cent or two.
    assert cost.EVALUATIONS <= piece.stepped().steps <= 3 * cost.EVALUATIONS


def test_what_fits_the_budget_is_run_whole() -> None:
    assert timed("ode/dop853", 1e-8, budget=1e3).fraction == 1.0
    assert timed("mujoco/euler", 5e-1, budget=1e-9).stepped().steps == 100
    assert cost.TRIAL <= timed("mujoco/euler", 1e-4, budget=4e-3).stepped().steps < 500_000


@dataclass
class Clock:
    """What stands in for the module `time`: each look at the wall clock is 100 s after the last,
    while this thread computed for 1 s."""

    computed: float = 0.0  # [s]
    wall: float = 0.0  # [s]

    def perf_counter(self) -> float:
        self.wall += 100.0
        return self.wall

    def thread_time(self) -> float:
        self.computed += 1.0
        return self.computed


@pytest.mark.parametrize(
    ("module", "method", "step"),
    [
        ("mujoco.simulation", "mujoco/rk4", 1e-2),
        ("pymunk.simulation", "pymunk/tight", 1e-2),
        ("ode.simulation", "ode/rk4", 1e-2),
        ("ode.simulation", "ode/dop853", 1e-4),
        ("heyoka", "heyoka/taylor", 1e-6),
        ("closed_form", "exact/closed-form", 1e-15),
    ],
)
def test_waiting_is_no_cost(
    module: str, method: str, step: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("heyoka" if module == "heyoka" else "plumbob")
    chosen = find_method(method)
    simulation = engine_of(chosen).prepare(case_of(SCENE), chosen, step)
    monkeypatch.setattr(f"plumbob.engines.adapters.{module}.time", Clock())
    assert simulation.stepped(0.1).seconds == 1.0


@pytest.mark.parametrize("method", ["mujoco/rk4", "pymunk/tight", "ode/rk4"])
def test_a_fraction_of_the_steps_is_taken(method: str) -> None:
    chosen = find_method(method)
    simulation = engine_of(chosen).prepare(case_of(SCENE), chosen, 1e-2)
    assert [simulation.stepped(f).steps for f in (1e-9, 0.1, 1.0)] == [1, 500, 5000]
    assert simulation.run().steps == 5000  # as if nothing had been timed


@pytest.mark.parametrize(
    ("milliseconds", "median", "low", "high"),
    [
        ((3.0, 1.0, 10.0, 2.0, 4.0), 3.0, 1.5, 7.0),
        ((3.0, 3.05, 3.02), 3.02, 3.0, 3.05),  # close to each other: two rounds less
        ((3.0, 3.07, 3.02, 3.03, 3.03), 3.03, 3.01, 3.05),
    ],
)
def test_a_cost_is_computing_time_over_steps_with_its_quartiles(
    milliseconds: tuple[float, ...], median: float, low: float, high: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    computing = iter(milliseconds)

    class Simulation:
        compile_seconds = 0.5

        def stepped(self, fraction: float) -> Stepping:
            assert fraction == 0.25
            return Stepping(1000, 1e-3 * next(computing))

    monkeypatch.setattr(cost, "_sized", lambda *_: cost.Piece(Simulation(), 0.25))  # type: ignore[arg-type]
    monkeypatch.setattr(cost, "reference_step", lambda: lambda: 500.0)
    task = system_of(SCENE).case(SCENE), find_method("mujoco/euler"), 1e-3
    found, unit = cost.costs([task])
    one = found[SCENE.name, "mujoco/euler"]
    assert unit == 500.0
    assert (one.ns_per_step, one.ratio) == pytest.approx((1e3 * median, 2 * median), rel=1e-9)
    assert (one.low, one.high) == pytest.approx((1e3 * low, 1e3 * high), rel=1e-9)
    assert (one.compile_seconds, one.repeats) == (0.5, len(milliseconds))


@pytest.mark.parametrize("name", ["capsule-turn", "capsule-line", "simple-pendulum/forced-small"])
def test_what_a_model_leaves_out_is_timed_whatever_its_controls(name: str) -> None:
    scene = find_scene(name)
    method = "mujoco/euler+coulomb" if name.startswith("capsule") else "mujoco/euler"
    found = trimming(system_of(scene).case(scene), find_method(method), 1e-4, steps=50, repeats=1)
    assert found.identical


def test_turns_end_where_they_agree_and_go_on_where_one_is_slow() -> None:
    """The error of a saving, 1 less a ratio of two medians, is at most 4 per cent of the whole
    if no time is further than 2 per cent from its median."""
    alike = np.array([[1.0, 2.0], [1.0 + trimming_.CLOSE / 3, 2.0], [1.0, 2.0]])
    assert trimming_.agree(alike)
    assert trimming_.agree(np.array([[1.0], [1.0], [1.019]]))
    assert not trimming_.agree(np.array([[1.0], [1.0], [1.021]]))
    for turn in range(3):
        slow = alike.copy()
        slow[turn, 0] *= 1.0 + 1.5 * trimming_.CLOSE
        assert not trimming_.agree(slow)
