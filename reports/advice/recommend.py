"""Records of a recommendation, and the rule that decides which methods may be recommended.

The error of a run is relative: the worst error of the scene's quantities of interest over their
scales. Only steps that were run are recommended. No step above a step that misses the error is
recommended: the error at one step may be near zero by chance. No step near a limit of stability is
recommended.

Three kinds of methods are left out. A closed form is no simulation. If a method's error does not
converge on the scene, or is not the predicted one, one run near the exact answer says nothing about
the next. A surrogate, whose model is not the full body, is named beside a full model only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from plumbob.engines.study.convergence import DEFAULT
from plumbob.engines.study.measurement import Measurement
from plumbob.engines.study.results import Quantities
from plumbob.engines.study.stability import SmallestLimit
from plumbob.reports.advice.work_precision import error_or_infinity, errors_converge
from plumbob.reports.judge.verdict import JudgedMethod, Verdict

DEFAULT_METHOD, RECOMMENDED_STEP = DEFAULT
# Verdicts that rule a method out.
UNTRUSTED = ("off-prediction", "inaccurate", "not-converging", "diverged", "cut-short")
# With this verdict, the method is judged by the errors of its runs.
UNJUDGED = "pre-asymptotic"
# Integrator of methods that are no simulation, and are not recommended.
CLOSED_FORM_INTEGRATOR = "closed-form"


@dataclass(frozen=True)
class Choice:
    """A method at a step, with a bound on its error and its cost."""

    method: str
    control: str  # "step" or "tolerance": the meaning of `step`
    step: float  # step size [s], or relative tolerance
    error: float  # bound on the relative error
    absolute: float  # the same bound on the observable's error, in the observable's unit
    ns_per_second: float  # [ns] wall time per simulated second
    measured: bool = True  # whether this very step was run
    surrogate: str = ""  # reason why the model is not the full body; empty for a full model
    # the smallest limit of the step on the scenes asked about
    limit: SmallestLimit | None = None
    margin: float | None = None  # ratio of the limit to this step
    limited: bool = False  # a larger step may reach the error, but is too near the limit


@dataclass(frozen=True)
class Recommendation:
    """The answer to "which step?" for one scene and one wanted error."""

    scene: str
    observable: str  # the first quantity of interest
    unit: str
    error: float  # wanted relative error
    absolute: float  # the wanted error of the observable, in its unit
    choice: Choice | None  # the cheapest choice that reaches the error
    runner_up: Choice | None  # the cheapest choice with another method
    by_engine: tuple[Choice, ...]  # the cheapest choice in each engine, cheapest first
    best: Choice | None  # the most accurate run, if no choice reaches the error
    # Runs with MuJoCo's default settings, and with the chosen method at the default step.
    defaults: tuple[Choice, ...]
    surrogate: Choice | None = None  # the cheapest surrogate, if cheaper than `choice`


def may_recommend(
    judged: JudgedMethod | None, runs: Sequence[Measurement], quantities: Quantities
) -> bool:
    """Whether a method may be recommended on a scene by its verdict. If the verdict is
    `pre-asymptotic`, the errors of its `runs` have to converge. Without a verdict it may be
    recommended."""
    return judged is None or verdict_allows(judged.whole.verdict, runs, quantities)


def verdict_allows(
    verdict: Verdict, runs: Sequence[Measurement], quantities: Quantities
) -> bool:
    """Whether a method with this verdict on its `runs` on a scene may be recommended."""
    if verdict != UNJUDGED:
        return verdict not in UNTRUSTED
    return errors_converge([(run.step, error_or_infinity(run, quantities)) for run in runs])
