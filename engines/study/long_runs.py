"""Measures for how long a method stays right, by runs that are each longer than the one before."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from plumbob.analytic.answer_cache import Same, exactly
from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.stability import LEVELS, LongRun, StabilityTheory
from plumbob.engines.method import Method, Unsupported
from plumbob.engines.registry import engine_of
from plumbob.engines.study.measurement import scheme_of
from plumbob.engines.study.request import RunRequest
from plumbob.engines.trajectory import Trajectory, lost
from plumbob.models.registry import case_of, stability_of
from plumbob.models.scene import Case, Scene

MAX_LONG_RUN_STEPS = 1_000_000  # largest number of steps of a run: a second in MuJoCo
# steps of the first run, and the factor from one run to the next
FIRST_STEPS, RUN_LENGTH_FACTOR = (
    1_000,
    4,
)
A_PERIOD = 100  # preferred number of steps in a period of the fastest mode
OF_A_SOLVER = 1e3  # assumed number of steps in a period, of a solver that chooses its steps
A_SAMPLE = 16.0  # samples in a period of the fastest mode: errors oscillate within the period
MOST_SAMPLES = 50_000  # largest number of samples of a run
DOUBT = 0.2  # largest uncertainty of the exact motion, as a fraction of the smallest level
SHARP = 4.0  # standard errors by which a drift of the energy must differ from zero
LOST_ENERGY = 1.0  # change of the energy, relative to its scale, at which it counts as lost


@dataclass(frozen=True)
class MeasuredLongRun:
    """The times at which a method's error reaches each level, as measured and predicted."""

    step: float = math.nan  # [s], or the relative tolerance
    period: float = math.nan  # [s] fastest period of the motion
    predicted: LongRun | None = None
    times: Mapping[float, float] = field(default_factory=dict)  # [s] times by level
    followed: float = 0.0  # [s] duration of the longest run
    stopped: str = ""  # why no run was longer; empty if the error reached all of LEVELS
    energy: Literal["bounded", "drifting", "lost", "not conserved"] = "not conserved"
    energy_rate: float = 0.0  # [1/s] drift of the energy, relative to its scale
    why: str = ""  # why nothing was measured


@dataclass(frozen=True)
class LongRunSearch(RunRequest[MeasuredLongRun]):
    """A search for the times at which a method's error on a scene reaches each of LEVELS."""

    label = "long run"

    scene: str
    method: str
    step: float | None = None
    """[s], or the relative tolerance; None: the scene's step nearest to A_PERIOD steps a period."""
    most_steps: int = MAX_LONG_RUN_STEPS  # largest number of steps of a run

    def made(self, scene: Scene, method: Method) -> MeasuredLongRun:
        """Measures at which times [s] the error of a run reaches each of LEVELS. Runs become longer
        until all levels are reached or the reason to stop is known. Raises ParameterError."""
        case = case_of(scene)
        theory = stability_of(case)
        if theory is None:
            return MeasuredLongRun(why="long runs are of pendulums and of a free body")
        step = self.step or own_step(scene, method, theory)
        fixed = method.control == "step"
        if fixed:
            self._require_a_period(step, theory.fastest)
        scales = {q.observable: q.scale for q in case.system.quantities(case)}
        predicted = theory.long_run(scheme_of(case, method), step, scales) if fixed else None
        pace = step if fixed else theory.fastest / OF_A_SOLVER
        times: dict[float, float] = {}
        longest: Trajectory | None = None
        stopped = f"not within {self.most_steps:.3g} steps"
        try:
            for run in _runs(case, method, step, pace, self.most_steps, theory):
                if run.diverged_at is None and not lost(run):
                    longest = run
                else:
                    stopped = f"lost after {run.diverged_at or 0.0:.3g} s"
                    break
                known = _reached(case, run, scales, times)
                if len(times) == len(LEVELS):
                    stopped = ""
                elif not known:
                    stopped = "double precision knows the exact motion no longer"
                elif run.times[-1] >= theory.lasts * (1.0 - 1e-9) - 2.0 * pace:
                    stopped = "the motion has come to rest, or repeats"
                else:
                    continue
                break
        except Unsupported as why:
            return MeasuredLongRun(why=str(why))
        energy = _energy(theory, longest, "lost" in stopped)
        followed = 0.0 if longest is None else float(longest.times[-1])
        return MeasuredLongRun(
            step, theory.fastest, predicted, times, followed, stopped, *energy
        )

    def _require_a_period(self, step: float, period: float) -> None:
        """Raises ParameterError if `most_steps` of `step` [s] do not last a `period` [s]."""
        if step * self.most_steps < period:
            least = period / self.most_steps
            raise ParameterError("step", step, f"at least {least:.3g} s: a period in a run")


def own_step(scene: Scene, method: Method, theory: StabilityTheory) -> float:
    """The step of the scene [s] with a number of steps in the fastest period nearest to A_PERIOD;
    for a solver that chooses its steps, the middle one of its tolerances."""
    if method.control == "tolerance":
        return method.step_sizes[len(method.step_sizes) // 2]
    wanted = theory.fastest / A_PERIOD
    return min(scene.steps, key=lambda step: abs(math.log(step / wanted)))


def _runs(
    case: Case,
    method: Method,
    step: float,
    pace: float,
    most_steps: int,
    theory: StabilityTheory,
) -> Iterator[Trajectory]:
    """Yields runs that last FIRST_STEPS to `most_steps` times `pace` [s], each RUN_LENGTH_FACTOR
    times as long as the one before, until the motion ends."""
    steps = FIRST_STEPS
    duration = 0.0
    last = min(most_steps * pace, theory.lasts)
    while duration < last:
        duration = min(steps * pace, last)
        with np.errstate(all="ignore"):
            fine = math.ceil(A_SAMPLE * duration / theory.fastest)
            lasting = case.lasting(duration, min(max(case.samples, fine), MOST_SAMPLES))
            yield engine_of(method).prepare(lasting, method, step).run()
        steps *= RUN_LENGTH_FACTOR


def _reached(
    case: Case, run: Trajectory, scales: Mapping[str, float], times: dict[float, float]
) -> bool:
    """Adds to `times` the times [s] at which the run's error first reaches levels that no earlier
    run reached, as far as the exact motion is known. Returns whether it is known to the end of the
    run."""
    try:
        exact, doubt = exactly(Same(case.reference), run.times.tobytes())
    except ParameterError:
        return False
    names = [name for name in scales if name in run.observables]
    differences = [np.abs(run.observables[n] - exact[n]) / scales[n] for n in names]
    uncertainties = [doubt[n] / scales[n] for n in names]
    unknown = np.flatnonzero(np.max(uncertainties, axis=0) > DOUBT * LEVELS[0])
    known_samples = unknown[0] if unknown.size else None
    errors = np.max(differences, axis=0)[:known_samples]
    for level in LEVELS:
        above = np.flatnonzero(errors >= level)
        if above.size:
            times.setdefault(level, float(run.times[above[0]]))
    return not unknown.size


def _energy(
    theory: StabilityTheory, run: Trajectory | None, lost: bool
) -> tuple[Literal["bounded", "drifting", "lost", "not conserved"], float]:
    """Whether the energy of a run stays bounded, drifts or is lost; and the rate of the drift,
    relative to the energy's scale [1/s], which is the slope of a line fitted to its samples."""
    if theory.energy is None:
        return "not conserved", 0.0
    if run is None or lost:
        return "lost", 0.0
    energy: Array = theory.energy(run.observables)
    drift = energy - energy[0]
    if np.abs(drift).max() > LOST_ENERGY:
        return "lost", 0.0
    (rate, _), ((variance, _), _) = np.polyfit(run.times, drift, 1, cov=True)
    if abs(rate) < SHARP * math.sqrt(variance):
        return "bounded", 0.0
    return "drifting", float(rate)
