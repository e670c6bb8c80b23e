"""What a run of an engine gives back: sampled observables, what it cost, what went wrong."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from plumbob.analytic.reference import Array


@dataclass(frozen=True)
class Trajectory:
    """Observables of one run at the times that the engine itself reached."""

    times: Array  # [s], shape (n,); the last one is the end of the run
    observables: Mapping[str, Array]  # by the system's names, SI, shape (n,)
    channels: Mapping[str, Array] = field(default_factory=dict)  # the engine's own, shape (n,)
    steps: int = 0  # steps taken (right-hand sides evaluated, for adaptive methods)
    seconds: float = 0.0  # wall time of the stepping alone
    diverged_at: float | None = None  # [s]; samples after it are left out
    warnings: tuple[str, ...] = ()
