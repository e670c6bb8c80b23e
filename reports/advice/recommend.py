"""Which method, and which step: an answer, and what may be named in it.

The error of a run is relative: the worst of the scene's quantities of interest over their scales.
Only steps that were run are named, none above one that misses the error, so that a zero of a
sawtooth is no recommendation, and none near a limit of stability. A closed form is no simulation:
it is left out. So is a method whose error on the scene does not converge, or is off what theory
says: that one of its runs came near the exact answer says nothing of the next. A surrogate, whose
model is not the full body, is named beside a full model alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from plumbob.engines.study.convergence import DEFAULT
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Quantities
from plumbob.engines.study.stability import SmallestLimit
from plumbob.reports.advice.work_precision import converging, error_of
from plumbob.reports.judge.verdict import Judged

DEFAULT_METHOD, DEFAULT_STEP = DEFAULT
UNTRUSTED = (
    "off-prediction",
    "inaccurate",
    "not-converging",
    "diverged",
    "cut-short",
)  # verdicts that rule a method out
UNJUDGED = "pre-asymptotic"  # the verdict that leaves it to the curve of errors
EXACT = "closed-form"  # the scheme of what is no simulation, and is not recommended as one


@dataclass(frozen=True)
class Choice:
    """A method at a step: the error it stays within and what it costs."""

    method: str
    control: str  # "step" or "tolerance": what the step is
    step: float  # [s], or the relative tolerance
    error: float  # bound on the relative error
    absolute: float  # what that allows the observable's error to be, in its unit
    ns_per_second: float  # [ns] of wall time per simulated second
    measured: bool = True  # this very step was run
    surrogate: str = ""  # why its model is not the full body, where it is not
    limit: SmallestLimit | None = None  # the smallest of its steps, on the scenes asked about
    margin: float | None = None  # that over this step
    limited: bool = False  # a larger step may reach the error, but is too near the limit


@dataclass(frozen=True)
class Recommendation:
    """The answer to "which step?" for one scene and one wanted error."""

    scene: str
    observable: str  # the first quantity of interest
    unit: str
    error: float  # wanted, relative
    absolute: float  # the same of the observable, in its unit
    choice: Choice | None  # the cheapest that reaches it
    runner_up: Choice | None  # the cheapest of another method
    by_engine: tuple[Choice, ...]  # the cheapest in each engine that reaches it, cheapest first
    best: Choice | None  # the most accurate of all that was measured
    defaults: tuple[Choice, ...]  # MuJoCo's default settings, and the chosen method at its step
    surrogate: Choice | None = None  # the cheapest, if cheaper than the full model


def trusted(judged: Judged | None, runs: Sequence[Measurement], about: Quantities) -> bool:
    """Whether nothing is known against a method on a scene, and where there is no theory of it, the
    errors of its runs converge."""
    if judged is None:
        return True
    verdict = judged.whole.verdict
    if verdict != UNJUDGED:
        return verdict not in UNTRUSTED
    return converging([(m.step, error_of(m, about)) for m in runs])
