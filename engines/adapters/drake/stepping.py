"""Drake code shared by pendulums and capsules: inertias, the simulator, and its stepping."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.multibody import tree
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig

from plumbob.analytic.reference import Array
from plumbob.engines.adapters.divergence import within
from plumbob.engines.method import Stepping
from plumbob.engines.sampling import SAMPLES
from plumbob.engines.trajectory import Trajectory

BROKEN = (OverflowError, ValueError, RuntimeError)  # raised where numbers are no longer finite


def spatial_inertia(mass: float, centre: Any, moments: Array) -> Any:
    """Of a body whose `moments` are about its `centre` of mass."""
    xx, yy, zz = np.diag(moments)
    about = tree.RotationalInertia(xx, yy, zz, moments[0, 1], moments[0, 2], moments[1, 2])
    return tree.SpatialInertia.MakeFromCentralInertia(mass, centre, about)


def simulator_of(diagram: Any, context: Any) -> Any:

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


@dataclass
class ErrorControlledSimulation:
    """A continuous plant with an integrator and its accuracy; every `run` starts afresh."""

    made: Any  # a diagram, its `start`, what to `read`, and the `limits` of its body
    scheme: str
    accuracy: float
    duration: float  # [s]
    compile_seconds: float

    def run(self) -> Trajectory:
        """Run from sample to sample; steps count evaluations of the derivatives."""

        simulator = self._started()
        times = np.linspace(0.0, self.duration, SAMPLES + 1)
        rows, seconds, failure = [self.made.read(simulator.get_context())], 0.0, ""
        for until in times[1:].tolist():
            begin = time.perf_counter()
            try:
                simulator.AdvanceTo(until)
            except BROKEN as error:
                failure = " ".join(str(error).split())
                break
            seconds += time.perf_counter() - begin
            rows.append(self.made.read(simulator.get_context()))
        theta, theta_dot = np.array(rows).T
        done = Trajectory(
            times=times[: len(rows)],
            observables={"theta": theta, "theta_dot": theta_dot},
            steps=int(simulator.get_integrator().get_num_derivative_evaluations()),
            seconds=seconds,
            diverged_at=float(times[len(rows)]) if failure else None,
            warnings=(failure,) if failure else (),
        )
        return within(done, self.made.body.limits)

    def stepped(self, fraction: float) -> Stepping:
        """The evaluations of the first `fraction` of the duration alone."""
        simulator, begin = self._started(), time.thread_time()
        try:
            simulator.AdvanceTo(fraction * self.duration)
        except BROKEN:
            return Stepping(0, 0.0)
        seconds = time.thread_time() - begin
        return Stepping(int(simulator.get_integrator().get_num_derivative_evaluations()), seconds)

    def _started(self) -> Any:
        """A simulator at the start, with the integrator and its accuracy."""
        simulator = simulator_of(self.made.diagram, self.made.start())
        chosen = SimulatorConfig(
            integration_scheme=self.scheme,
            accuracy=self.accuracy,
            max_step_size=self.duration,
            use_error_control=True,
            target_realtime_rate=0.0,
        )
        ApplySimulatorConfig(chosen, simulator)
        simulator.Initialize()
        return simulator
