"""Verdicts that are expected: known limits and unsupported pairs, with their reasons.

The comparison is strict. A limit that disappears or changes its size is reported. An engine that
refuses a model without having declared so is reported too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from sys import float_info
from types import MappingProxyType
from typing import Literal, cast

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.registry import engine_of, limits_of
from plumbob.engines.registry import method as find_method
from plumbob.models.registry import find_system
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.reports.judge.known_sizes import (
    known_factor,
    median_mismatch,
    run_size_mismatch,
    size_mismatch,
    tolerance_sizes_mismatch,
)
from plumbob.reports.judge.tolerance import STARTS_OFF, TOO_WIDE
from plumbob.reports.judge.verdict import LEAVES_OUT, NO_STEP_FITS, Judgement, Verdict

# Reasons of failures that no known limit allows.
NEVER_LIMITS = (LEAVES_OUT, STARTS_OFF, TOO_WIDE)
INACCURATE = "inaccurate, misses the accuracy asked for"
# Calibrated: if no theory predicts the error, largest allowed ratio of the error at a drawn step
# (or tolerance) to the largest error at the listed steps (or tolerances). In 1752 draws of the
# quick profile with the seeds 1 to 4, the largest ratio was 2.2 for steps and 6.6 for tolerances;
# with seed 5 it was 2.6 for steps.
DRAWN_RATIO = MappingProxyType({"step": 4.0, "tolerance": 20.0})
VerdictStanding = Literal[
    "as expected", "known limit", "pre-asymptotic", "not run", "unexpected"
]


@dataclass(frozen=True)
class Expectation:
    """The verdict that a method should have on a scene."""

    verdict: Verdict
    reason: str
    other: Verdict | None = None  # a second expected verdict: the step sizes decide which one
    size: float = 0.0  # relative error of a known limit that is declared by one number; else 0

    @property
    def limit(self) -> bool:
        """Whether the expected verdict is a known limit, whose error has a size."""
        without_limit = {"predicted", "converges", "unsupported", None}
        return not {self.verdict, self.other} <= without_limit

    def allows(self, judgement: Judgement) -> bool:
        """Whether a verdict is an expected one. In a convergence study that was cut short, an error
        that should not converge may also be `off-prediction`, and a study whose steps should be too
        large must not be `predicted`. No expectation allows a missing observable, a wrong start or
        a model-error bound that is too wide."""
        if judgement.reason.startswith(NEVER_LIMITS):
            return False
        allowed = {self.verdict, self.other}
        if judgement.cut and "not-converging" in allowed:
            allowed.add("off-prediction")
        if judgement.cut and self.verdict == "pre-asymptotic":
            allowed.discard("predicted")
        return judgement.verdict in allowed


def expected(scene: str, method: str) -> Expectation:
    """Returns the expected verdict on a method on a scene: the known limit that the method's engine
    declares. Without one it is `predicted`; if a plug-in brings no theory, `converges` is allowed
    too."""
    known = limits_of(method).limit(scene, method)
    if known is None:
        return Expectation("predicted", "", _without_theory(scene, method))
    verdict = cast(Verdict, known.verdict)
    other = cast("Verdict | None", known.other)
    return Expectation(verdict, known.reason, other, known.size)


def _without_theory(scene: str, method: str) -> Verdict | None:
    """Returns `converges` if no theory of plumbob's covers the pair; otherwise None. The pair is
    not covered if a plug-in brings the system, or if a plug-in brings the method and its scheme has
    a name that plumbob does not know."""
    try:
        known_method = find_method(method)
        system = find_system(scene.partition("/")[0])
    except ParameterError:  # a stored study may name an engine that is no longer installed
        return None
    plug_in_engine = engine_of(known_method).distribution
    plug_in_scheme = plug_in_engine and not known_method.scheme.known
    return "converges" if plug_in_scheme or system.distribution else None


def surprise(scene: Scene, method: Method, judgement: Judgement) -> str:
    """Message if the verdict on a convergence study is not the expected one; empty if it is. A
    missing engine is no surprise. A verdict on a user's own settings is a surprise only if the
    accuracy asked for is missed."""
    if judgement.verdict == "inaccurate":
        return INACCURATE
    if method.name == USER_METHOD or judgement.verdict == "missing":
        return ""
    expectation = expected(scene.name, method.name)
    if judgement.verdict == "unsupported":
        # If the profile leaves out every step of a scene, the scene was not tried.
        untried = judgement.cut and judgement.reason == NO_STEP_FITS
        return "" if untried else _verdict_mismatch(expectation, judgement)
    if _pre_asymptotic_allowed(scene, method, judgement) and not expectation.limit:
        return _drawn_surprise(scene, method, judgement)
    return (
        _verdict_mismatch(expectation, judgement)
        or _size_mismatch(scene, method, judgement, expectation)
        or _drawn_surprise(scene, method, judgement)
    )


def _drawn_surprise(scene: Scene, method: Method, judgement: Judgement) -> str:
    """Message if the run at a drawn step is not as expected; empty if it is, or there is none."""
    drawn = judgement.drawn
    if drawn is None:
        return ""
    step, error = next(iter(drawn.errors.items()), (math.nan, math.nan))
    listed_errors = compared_errors(scene, method, judgement, step)
    # At a known limit the error of the run is compared, and not its verdict.
    by_error_alone = listed_errors and method.control == "step" and drawn.errors
    reason = "" if by_error_alone else run_surprise(scene, method, drawn)
    if listed_errors and not reason:
        largest = max(listed_errors)
        # Errors at listed steps may all be zero, hence the machine epsilon.
        if error > DRAWN_RATIO[method.control] * max(largest, float_info.epsilon):
            reason = (
                f"the relative error is {error:.3g}, and {largest:.3g} at most at listed steps"
            )
    if not reason:
        return ""
    return f"at a randomly drawn step, {reason}: {drawn.reason}".rstrip(": ")


def compared_errors(
    scene: Scene, method: Method, judgement: Judgement, step: float
) -> list[float]:
    """Returns the relative errors that the error at a drawn `step` must not exceed by much; `step`
    is a step [s], or the tolerance of a solver.

    For a solver with a tolerance they are the errors at the two nearest tolerances. For a known
    limit they are the errors at all listed steps. For any other scene and method the list is empty,
    because their error is checked against a prediction. There is no lower bound: the error may pass
    through zero between two listed steps.
    """
    errors = judgement.errors
    if method.control == "tolerance":
        nearest = sorted(errors, key=lambda listed: abs(math.log(listed / step)))[:2]
        return [errors[listed] for listed in nearest]
    if expected(scene.name, method.name).limit:
        return list(errors.values())
    return []


def verdict_is_expected(scene: Scene, method: Method, judgement: Judgement) -> bool:
    """Whether a verdict on a convergence study is the expected one."""
    return not surprise(scene, method, judgement)


def run_surprise(scene: Scene, method: Method, judgement: Judgement) -> str:
    """Message if the verdict on one run is not an expected one; empty if it is. A single run is a
    convergence study cut short:

    If the error should not converge, the run may be `off-prediction`, or `predicted` where the
    step's own error is larger.

    If the scene's steps should be too large for theory, the run may be `predicted`, and any run may
    be `pre-asymptotic`.

    The error of a known limit must lie within a factor of two of the range that its study spans.
    """
    expectation = expected(scene.name, method.name)
    cut_short = replace(judgement, cut=True)
    if judgement.verdict == "inaccurate":
        return INACCURATE
    if method.name == USER_METHOD or judgement.verdict in ("pre-asymptotic", "missing"):
        return ""
    expected_verdicts = {expectation.verdict, expectation.other}
    may_be_predicted = expected_verdicts & {"pre-asymptotic", "not-converging"}
    if judgement.verdict == "predicted" and may_be_predicted:
        return ""
    mismatch = _verdict_mismatch(expectation, cut_short)
    return mismatch or _size_mismatch(scene, method, judgement, expectation, run=True)


def _verdict_mismatch(expectation: Expectation, judgement: Judgement) -> str:
    """Message that names the verdict and the expected ones; empty if the verdict is expected."""
    if expectation.allows(judgement):
        return ""
    other = f" or {expectation.other}" if expectation.other else ""
    return f"{judgement.verdict}, expected {expectation.verdict}{other}"


def _pre_asymptotic_allowed(scene: Scene, method: Method, judgement: Judgement) -> bool:
    """Whether a verdict `pre-asymptotic` on a scene of the full profile is allowed without a
    declared limit. It is allowed if the scene is hard, if the profile left out steps, or if the
    solver has a tolerance: there every step may be outside the asymptotic range."""
    allowed = scene.hard or judgement.cut or method.control == "tolerance"
    return judgement.verdict == "pre-asymptotic" and scene.profile == "full" and bool(allowed)


def _size_mismatch(
    scene: Scene,
    method: Method,
    judgement: Judgement,
    expectation: Expectation,
    run: bool = False,
) -> str:
    """Message if the relative error of a known limit, or of a solver with a tolerance, differs from
    its declared size; empty if it does not. A scene with changed parameters has no declared size.
    `run` says that the judgement is on a single run."""
    if _has_changed_parameters(scene):
        return ""
    limits = limits_of(method.name)
    pair = scene.name, method.name
    errors = judgement.errors
    if method.control == "tolerance":
        factor = known_factor(method, judgement.versions)
        return tolerance_sizes_mismatch(limits.solvers.get(pair, {}), errors, factor)
    if not expectation.limit or judgement.verdict == "predicted":
        return ""
    known = limits.sizes.get(pair)
    if known is not None and run:
        mismatches = (run_size_mismatch(known, step, error) for step, error in errors.items())
        mismatch = next(mismatches, "")
    elif known is not None:
        mismatch = size_mismatch(known, errors, known_factor(method, judgement.versions))
    elif not expectation.size:
        mismatch = "its size is not known"
    else:
        mismatch = "" if run else median_mismatch(expectation.size, errors)
    return f"{judgement.verdict}, a known limit, but {mismatch}" if mismatch else ""


def _has_changed_parameters(scene: Scene) -> bool:
    """Whether a scene has other parameters or another duration than the registered scene."""
    try:
        registered = find_scene(scene.name)
    except ParameterError:
        return False
    same_parameters = dict(registered.parameters) == dict(scene.parameters)
    return not same_parameters or registered.duration != scene.duration


def require_accuracy(judgement: Judgement, within: float) -> Judgement:
    """Returns the judgement, with the verdict `inaccurate` if the relative error of the finest run
    exceeds `within`."""
    if not judgement.errors:
        return judgement
    finest = min(judgement.errors)
    error = judgement.errors[finest]
    if error <= within:
        return judgement
    reason = f"the relative error is {error:.2g} at {finest:g}, and {within:g} was asked for"
    return replace(judgement, verdict="inaccurate", reason=reason)


def standing(scene: Scene, method: Method, judgement: Judgement) -> VerdictStanding:
    """Returns the meaning of a verdict to a reader. `known limit` is a declared limit;
    `pre-asymptotic` and `not run` claim nothing."""
    if not verdict_is_expected(scene, method, judgement):
        return "unexpected"
    if judgement.verdict in ("unsupported", "missing"):
        return "not run"
    if method.name == USER_METHOD or judgement.verdict == "predicted":
        return "as expected"
    if expected(scene.name, method.name).limit:
        return "known limit"
    return "as expected" if judgement.verdict == "converges" else "pre-asymptotic"
