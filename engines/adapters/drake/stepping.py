"""Drake code of all scenes: the simulator, and its stepping."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

from plumbob.engines.adapters.stepping import Built, SteppedSimulation, relative_tolerance
from plumbob.engines.method import Method, Simulation, Stepping
from plumbob.engines.sampling import first_steps
from plumbob.engines.trajectory import Trajectory
from plumbob.models.scene import Case

BROKEN = (OverflowError, ValueError, RuntimeError)  # raised where numbers are no longer finite
EVALUATIONS = "evaluations"
Start = Callable[[Any, Any], tuple[Any, Callable[[int, int], None]]]
"""Diagram and context -> their simulator, and the function that takes its steps."""


def simulator_of(diagram: Any, context: Any) -> Any:
    """Of a diagram from a context on."""
    simulator = Simulator(diagram, context)
    simulator.set_target_realtime_rate(0.0)
    simulator.Initialize()
    return simulator


def advancing(simulator: Any, step: float) -> Callable[[int, int], None]:
    """A function that takes the steps with these indices, the last one excluded, of `step` [s]."""

    def advance(first: int, last: int) -> None:
        # A discrete update takes place at the time at which its step begins.
        simulator.AdvanceTo((last - 0.5) * step)

    return advance


def by_steps(step: float) -> Start:
    """Of a discrete plant with this step [s]."""

    def start(diagram: Any, context: Any) -> tuple[Any, Callable[[int, int], None]]:
        simulator = simulator_of(diagram, context)
        return simulator, advancing(simulator, step)

    return start


class ErrorControlledSimulation(SteppedSimulation):
    """One whose steps are from sample to sample, and which counts evaluations of derivatives."""

    def run(self) -> Trajectory:
        """Run from the start to the end; steps count evaluations."""
        done = super().run()
        counted = int(done.channels[EVALUATIONS][-1]) if len(done.times) else 0
        return replace(done, steps=counted, channels={})

    def stepped(self, fraction: float) -> Stepping:
        """The evaluations of the first `fraction` of the duration alone."""
        built, begin = self.build(), time.thread_time()
        try:
            built.advance(0, first_steps(self.steps, fraction))
        except BROKEN:
            return Stepping(0, 0.0)
        return Stepping(int(built.read()[EVALUATIONS]), time.thread_time() - begin)


def error_controlled(
    case: Case, method: Method, accuracy: float, smallest: float, build: Callable[[Start], Built]
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
    step = case.scene.duration / case.samples

    def started() -> Built:
        simulators = list[Any]()

        def start(diagram: Any, context: Any) -> tuple[Any, Callable[[int, int], None]]:
            simulators.append(simulator := simulator_of(diagram, context))
            ApplySimulatorConfig(chosen, simulator)
            simulator.Initialize()
            return simulator, lambda first, last: simulator.AdvanceTo(last * step)

        built = build(start)
        return replace(
            built,
            read=lambda: {**built.read(), EVALUATIONS: _evaluations(simulators[0])},
            channels=built.channels | {EVALUATIONS},
        )

    begin = time.perf_counter()
    started()
    seconds = time.perf_counter() - begin
    return ErrorControlledSimulation(started, case.samples, step, seconds, BROKEN, case.samples)


def _evaluations(simulator: Any) -> int:
    """So far; of CENIC, which counts none, its solutions of a step: three each, rejected ones
    too."""
    integrator = simulator.get_integrator()
    if counted := integrator.get_num_derivative_evaluations():
        return int(counted)
    rejected = integrator.get_num_step_shrinkages_from_error_control()
    return int(3 * (integrator.get_num_steps_taken() + rejected))
