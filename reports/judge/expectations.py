"""Known limits and unsupported pairs, with their reasons: strict, so that a limit that disappears
or changes its size, and an engine that refuses a model without having said so, are reported."""

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
    differs,
    differs_at,
    differs_from,
    known_within,
    not_those,
)
from plumbob.reports.judge.tolerance import STARTS_OFF, TOO_WIDE
from plumbob.reports.judge.verdict import LEAVES_OUT, NO_STEP_FITS, Judgement, Verdict

NO_LIMITS = (LEAVES_OUT, STARTS_OFF, TOO_WIDE)  # reasons of a failure that no limit admits
INACCURATE = "inaccurate, off the accuracy asked for"
# Calibrated: what an error at a drawn step, or tolerance, may be times those at listed ones, where
# no theory says more. Of 1752 draws of the quick profile, by the seeds 1 to 4, the largest were 2.2
# and 6.6 (`python -m plumbob.tests.validation.drawn_steps 1 4`); seed 5 has one of 2.6.
BETWEEN = MappingProxyType({"step": 4.0, "tolerance": 20.0})
Standing = Literal["as expected", "known limit", "pre-asymptotic", "not run", "unexpected"]


@dataclass(frozen=True)
class Expectation:
    """The verdict that a scene with a method is to have."""

    verdict: Verdict
    reason: str
    other: Verdict | None = None  # also expected: which of the two depends on the step sizes
    size: float = 0.0  # relative error of a known limit, where only that is declared of it

    @property
    def limit(self) -> bool:
        """Whether it admits a known limit, the error of which has a size."""
        return not {self.verdict, self.other} <= {"predicted", "converges", "unsupported", None}

    def allows(self, judgement: Judgement) -> bool:
        """Whether a verdict is an expected one. Of a convergence study cut short, a failure is also
        expected where the error is expected not to converge, and a pass is not where the steps are
        expected to be too large; and to leave out an observable, to start elsewhere or declare too
        much is no limit of a kind that is known here."""
        if judgement.reason.startswith(NO_LIMITS):
            return False
        allowed = {self.verdict, self.other}
        if judgement.cut and "not-converging" in allowed:
            allowed.add("off-prediction")
        if judgement.cut and self.verdict == "pre-asymptotic":
            allowed.discard("predicted")
        return judgement.verdict in allowed


def expected(scene: str, method: str) -> Expectation:
    """The declared expectation, from the limits of the method's engine; or `predicted`, or where a
    package brings no theory `converges`."""
    if (known := limits_of(method).limit(scene, method)) is None:
        return Expectation("predicted", "", _without_theory(scene, method))
    verdict = cast(Verdict, known.verdict)
    other = cast("Verdict | None", known.other)
    return Expectation(verdict, known.reason, other, known.size)


def _without_theory(scene: str, method: str) -> Verdict | None:
    """`converges` for a system of another package, which brings its own theory, and for a method of
    one whose scheme has a name of its own; for plumbob's own, EXPECTATIONS declare it."""
    try:
        how = find_method(method)
        where = find_system(scene.partition("/")[0])
    except ParameterError:  # of a stored study, whose engine is no longer there
        return None
    foreign = engine_of(how).distribution and not how.scheme.known
    return "converges" if foreign or where.distribution else None


def surprise(scene: Scene, method: Method, judgement: Judgement) -> str:
    """Why a verdict on a convergence study is not the expected one; empty where it is. An engine
    that is not installed is no surprise, nor is a verdict on a user's own settings, of which
    nothing is expected, unless the accuracy that was asked for is missed."""
    if judgement.verdict == "inaccurate":
        return INACCURATE
    if method.name == USER_METHOD or judgement.verdict == "missing":
        return ""
    wanted = expected(scene.name, method.name)
    if judgement.verdict == "unsupported":
        # A scene of which the profile leaves out every step was not tried.
        untried = judgement.cut and judgement.reason == NO_STEP_FITS
        return "" if untried else _verdicts(wanted, judgement)
    if _undecided(scene, method, judgement) and not wanted.limit:
        return _drawn(scene, method, judgement)
    why = _verdicts(wanted, judgement) or _other_size(scene, method, judgement, wanted)
    return why or _drawn(scene, method, judgement)


def _drawn(scene: Scene, method: Method, judgement: Judgement) -> str:
    """Why the run at a step that nobody listed is not as expected; empty where it is."""
    if (drawn := judgement.drawn) is None:
        return ""
    step, error = next(iter(drawn.errors.items()), (math.nan, math.nan))
    held = held_to(scene, method, judgement, step)
    limit = held and method.control == "step" and drawn.errors
    why = "" if limit else run_surprise(scene, method, drawn)
    most = max(*held, float_info.epsilon) if held else 0.0  # an error may be none at all
    if held and error > BETWEEN[method.control] * most:
        why = why or f"the relative error is {error:.3g}, and {max(held):.3g} at listed ones"
    return f"at a step that is drawn, {why}: {drawn.reason}".rstrip(": ") if why else ""


def held_to(scene: Scene, method: Method, judgement: Judgement, step: float) -> list[float]:
    """The errors at listed steps, or tolerances, that the error at a drawn `step` is held to: of a
    known limit all, of a solver with a tolerance the two next to it, and none where it has a
    prediction. It may be smaller than all of them, since it may change its sign in between."""
    if method.control == "tolerance":
        return [
            judgement.errors[t]
            for t in sorted(judgement.errors, key=lambda t: abs(math.log(t / step)))[:2]
        ]
    return list(judgement.errors.values()) if expected(scene.name, method.name).limit else []


def as_expected(scene: Scene, method: Method, judgement: Judgement) -> bool:
    """Whether a verdict on a convergence study is the expected one."""
    return not surprise(scene, method, judgement)


def run_surprise(scene: Scene, method: Method, judgement: Judgement) -> str:
    """Why the verdict on one run is not an expected one; empty where it is. A run is a convergence
    study cut short: of an error that does not converge it may fail, or pass where the step's own
    error is larger; and it may be too large for the theory, or smaller than all steps of a study
    that are. The error of a known limit lies within a factor of two of what its study spans."""
    wanted = expected(scene.name, method.name)
    short = replace(judgement, cut=True)
    if judgement.verdict == "inaccurate":
        return INACCURATE
    if method.name == USER_METHOD or judgement.verdict in ("pre-asymptotic", "missing"):
        return ""
    passes = {wanted.verdict, wanted.other} & {"pre-asymptotic", "not-converging"}
    if judgement.verdict == "predicted" and passes:
        return ""
    return _verdicts(wanted, short) or _other_size(scene, method, judgement, wanted, run=True)


def _verdicts(wanted: Expectation, judgement: Judgement) -> str:
    either = f"{wanted.verdict} or {wanted.other}" if wanted.other else wanted.verdict
    return "" if wanted.allows(judgement) else f"{judgement.verdict}, expected {either}"


def _undecided(scene: Scene, method: Method, judgement: Judgement) -> bool:
    """Scenes of the full profile alone declare no steps that are too large for the theory: on those
    that are hard, and at steps that a profile leaves, every step may be."""
    allowed = scene.hard or judgement.cut or method.control == "tolerance"
    return judgement.verdict == "pre-asymptotic" and scene.profile == "full" and bool(allowed)


def _other_size(
    scene: Scene, method: Method, judgement: Judgement, wanted: Expectation, run: bool = False
) -> str:
    """Why a known limit, or the error of a solver with a tolerance, has not the size that is known,
    empty where it has; of a scene whose parameters were changed no size is known."""
    if _changed(scene):
        return ""
    if method.control == "tolerance":
        held = limits_of(method.name).solvers.get((scene.name, method.name), {})
        return not_those(held, judgement.errors, known_within(method, judgement.versions))
    if not wanted.limit or judgement.verdict == "predicted":
        return ""
    known = limits_of(method.name).sizes.get((scene.name, method.name))
    if known is None and wanted.size:
        why = "" if run else differs_from(wanted.size, judgement.errors)
    elif known is None:
        why = "no size of it is known"
    elif run:
        why = next((differs_at(known, *entry) for entry in judgement.errors.items()), "")
    else:
        why = differs(known, judgement.errors, known_within(method, judgement.versions))
    return f"{judgement.verdict}, a known limit, but {why}" if why else ""


def _changed(scene: Scene) -> bool:
    try:
        usual = find_scene(scene.name)
    except ParameterError:
        return False
    return (dict(usual.parameters), usual.duration) != (dict(scene.parameters), scene.duration)


def accurate(judgement: Judgement, within: float) -> Judgement:
    """The judgement, `inaccurate` where the relative error of the finest run exceeds `within`."""
    if not judgement.errors or judgement.errors[finest := min(judgement.errors)] <= within:
        return judgement
    error = f"the relative error is {judgement.errors[finest]:.2g} at {finest:g}"
    why = f"{error}, and {within:g} was asked for"
    return replace(judgement, verdict="inaccurate", reason=why)


def standing(scene: Scene, method: Method, judgement: Judgement) -> Standing:
    """A verdict's meaning to a reader: `known limit` is a declared one, `pre-asymptotic` and `not
    run` claim nothing."""
    if not as_expected(scene, method, judgement):
        return "unexpected"
    if judgement.verdict in ("unsupported", "missing"):
        return "not run"
    if method.name == USER_METHOD or judgement.verdict == "predicted":
        return "as expected"
    if expected(scene.name, method.name).limit:
        return "known limit"
    return "as expected" if judgement.verdict == "converges" else "pre-asymptotic"
