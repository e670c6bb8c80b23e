"""Drake code of all scenes: the simulator, and its stepping."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

from plumbob.engines.adapters.stepping import (
    Built,
    Followed,
    FollowedSimulation,
    TakeSteps,
    relative_tolerance,
)
from plumbob.engines.method import Method, Simulation
from plumbob.models.scene import Case

BROKEN = (OverflowError, ValueError, RuntimeError)  # raised where numbers are no longer finite
Scene = Callable[[], tuple[Any, Any, Callable[[Any, TakeSteps], Built]]]
"""A diagram and a context, and what makes a scene of their simulator and what takes its steps."""


def simulator_of(diagram: Any, context: Any) -> Any:
    """Of a diagram from a context on."""
    simulator = Simulator(diagram, context)
    simulator.set_target_realtime_rate(0.0)
    simulator.Initialize()
    return simulator


def advancing(simulator: Any, step: float) -> TakeSteps:
    """A function that takes the steps with these indices, the last one excluded, of `step` [s]."""

    def advance(first: int, last: int) -> None:
        # A discrete update takes place at the time at which its step begins.
        simulator.AdvanceTo((last - 0.5) * step)

    return advance


def by_steps(scene: Scene, step: float) -> Built:
    """A scene in a discrete plant with this step [s]."""
    diagram, context, build = scene()
    simulator = simulator_of(diagram, context)
    return build(simulator, advancing(simulator, step))


def error_controlled(
    case: Case, method: Method, accuracy: float, smallest: float, scene: Scene
) -> Simulation:
    """The simulation of `case` with the integrator that `method` names, at an accuracy of at least
    the `smallest`; raises ParameterError."""
    chosen = SimulatorConfig(
        integration_scheme=method.settings["integration_scheme"],
        accuracy=relative_tolerance(accuracy, smallest),
        max_step_size=case.scene.duration,
        use_error_control=True,
        target_realtime_rate=0.0,
    )

    def started(step: float) -> tuple[Any, Built]:
        diagram, context, build = scene()
        simulator = simulator_of(diagram, context)
        ApplySimulatorConfig(chosen, simulator)
        simulator.Initialize()
        return simulator, build(simulator, lambda first, last: simulator.AdvanceTo(last * step))

    def follow(duration: float, samples: int) -> Followed:
        step = duration / samples
        simulator, built = started(step)
        rows, why = [built.read()], list[str]()
        try:
            for k in range(samples):
                built.advance(k, k + 1)
                rows.append(built.read())
        except BROKEN as error:
            why.append(" ".join(str(error).split()))
        observed, _ = built.gather(rows)
        times = np.asarray(step * np.arange(len(rows)))
        return Followed(times, observed, _evaluations(simulator), not why, tuple(why))

    begin, duration = time.perf_counter(), case.scene.duration
    limits = started(duration)[1].limits
    seconds = time.perf_counter() - begin
    return FollowedSimulation(follow, dict, duration, seconds, limits, case.samples)


def _evaluations(simulator: Any) -> int:
    """So far; of CENIC, which counts none, its solutions of a step: three each, rejected ones
    too."""
    integrator = simulator.get_integrator()
    if counted := integrator.get_num_derivative_evaluations():
        return int(counted)
    rejected = integrator.get_num_step_shrinkages_from_error_control()
    return int(3 * (integrator.get_num_steps_taken() + rejected))
