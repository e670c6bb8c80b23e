"""The results of an engine's run: sampled observables, the run's cost, and why it failed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from plumbob.analytic.reference import Array, Signals

ByName = Mapping[str, float]
"""Numbers in SI units by the name of an observable, a bound or a derivative."""


@dataclass(frozen=True)
class Trajectory:
    """Observables of one run at the times that the engine reached."""

    times: Array  # [s], shape (n,); the last one is the end of the run
    observables: Signals  # by the system's names, SI, shape (n,)
    channels: Signals = field(default_factory=dict)  # other signals of the engine, shape (n,)
    steps: int = 0  # number of steps; of evaluated right-hand sides for adaptive methods
    seconds: float = 0.0  # wall time of the stepping alone
    diverged_at: float | None = None  # [s] time of divergence; later samples are left out
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Stepping:
    """The processor time of steps whose states are not read. Unlike wall time it does not depend on
    what else the machine runs."""

    steps: int  # number of steps; of evaluated right-hand sides for adaptive methods
    seconds: float  # processor time of this thread


class TimedSimulation(Protocol):
    """A simulation whose steps can be timed without reading state."""

    @property
    def compile_seconds(self) -> float:
        """Time that compiling the scene took [s]."""

    def stepped(self, fraction: float) -> Stepping:
        """Takes the steps of the first `fraction` of the duration, 0 to 1, without reading states.
        If a step fails, no steps count."""


def last_sample(run: Trajectory) -> Trajectory:
    """The run with its last sample alone."""
    ends = [
        {name: values[-1:] for name, values in recorded.items()}
        for recorded in (run.observables, run.channels)
    ]
    return replace(run, times=run.times[-1:], observables=ends[0], channels=ends[1])


def not_a_trajectory(run: Any) -> str:
    """Returns why an object is no Trajectory with finite samples of one length; empty if it is."""
    if not isinstance(run, Trajectory):
        return f"a run returns {type(run).__name__} in place of a Trajectory"
    shape = np.shape(run.times)
    if len(shape) != 1:
        return f"the times of a run have shape {shape}, not (n,)"
    for name, values in {**run.observables, **run.channels}.items():
        if np.shape(values) != shape:
            return f"{name} has shape {np.shape(values)}, the times of the run {shape}"
        if not np.isfinite(np.asarray(values, dtype=np.float64)).all():
            return f"{name} is not finite, and diverged_at does not say when it was lost"
    return ""


def lost(run: Trajectory) -> str:
    """Returns why a run that an engine returned cannot be measured; empty if it can."""
    if run.diverged_at is not None:
        return "; ".join(run.warnings) or "beyond every reach of the motion"
    return not_a_trajectory(run)
