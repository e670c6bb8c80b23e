"""How large steps may be on a scene: within 1 % of the exact motion, and before it is lost."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from plumbob.engines.method import Method
from plumbob.engines.study.measurement import worst
from plumbob.engines.study.results import Study
from plumbob.engines.study.stability import KnownLimit
from plumbob.models.scene import Scene
from plumbob.reports.view import notation

PERCENT = 0.01

# Whose limits the first screen shows, and the quick profile predicts.
SCENES = (
    "simple-pendulum/free-large",
    "cone-pendulum/rotating-base",
    "cone-pendulum/fast-platform",
    "linear-pendulum/overdamped",
    "free-body/flip",
)


@dataclass(frozen=True)
class StepRange:
    """The steps of a method on a scene that are accurate, and those that are stable."""

    method: str
    control: Literal["step", "tolerance"]
    least: float  # relative error of all that were run; infinite where all diverged
    accurate: float | None  # [s], or relative tolerance: the largest that was run within 1 %
    next_larger: float | None  # that was run
    limit: KnownLimit | None  # of a method that is given a step

    @property
    def margin(self) -> float | None:
        """The largest stable step over the largest accurate one; None where there is no limit."""
        if self.limit is None or not self.accurate or math.isinf(self.limit.step):
            return None
        return self.limit.step / self.accurate

    @property
    def limited_by(self) -> str:
        """Whether steps above the accurate ones are inaccurate, or lost; empty where none is
        known."""
        if self.limit is None or (self.accurate is not None and self.next_larger is None):
            return ""
        lost = self.accurate is not None and (self.next_larger or 0.0) > self.limit.step
        return "stability" if lost or not self.limit.step else "accuracy"

    @property
    def text(self) -> str:
        """The range in words."""
        within = "within 1 % at no step run"
        if self.accurate is not None:
            within = f"within 1 % up to {notation.short(self.accurate)} s"
        if self.limit is None:
            return within
        stable = "no step unstable"
        if math.isfinite(self.limit.step):
            stable = f"stable up to {notation.number(self.limit.step, 3)} s"
        return f"{within}, {stable} ({'measured' if self.limit.measured else 'predicted'})"


def step_ranges(study: Study, scene: Scene) -> tuple[StepRange, ...]:
    """The ranges of every method that was run."""
    methods = {method.name: method for method in study.methods}
    return tuple(
        _step_range(study, scene, methods[series.method], errors)
        for series in study.convergence
        if series.scene == scene.name
        if (
            errors := {
                run.step: worst(run, study.quantities(scene.name))[1]
                if run.status == "done"
                else math.inf
                for run in series.measurements
                if run.status in ("done", "diverged")
            }
        )
    )


def finite_limits(ranges: Iterable[StepRange]) -> dict[str, float]:
    """The largest stable step [s] of each method that has one and a next that is not."""
    limits = {of.method: of.limit.step for of in ranges if of.limit}
    return {method: step for method, step in limits.items() if 0.0 < step < math.inf}


def _step_range(
    study: Study, scene: Scene, method: Method, errors: dict[float, float]
) -> StepRange:
    accurate = max((step for step, error in errors.items() if error <= PERCENT), default=None)
    larger = min((step for step in errors if step > (accurate or 0.0)), default=None)
    limit = study.step_limit(scene.name, method.name) if method.control == "step" else None
    return StepRange(method.name, method.control, min(errors.values()), accurate, larger, limit)
