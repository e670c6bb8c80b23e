"""Known limits and unsupported pairs, with their reasons: strict, so that a limit that disappears
or changes its size, and an engine that refuses a model without having said so, are reported."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal, cast

from plumbob.analytic.parameters import ParameterError
from plumbob.engines.method import USER_METHOD, Method
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.models.registry import find_system
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Scene
from plumbob.reports.judge.known_limits import (
    declared_limit,
    differs_from,
    errors_of_solvers,
    fits,
    known_within,
    not_those,
    sizes,
)
from plumbob.reports.judge.tolerance import STARTS_OFF, TOO_WIDE
from plumbob.reports.judge.verdict import LEAVES_OUT, NO_STEP_FITS, Judgement, Verdict

NO_LIMITS = (LEAVES_OUT, STARTS_OFF, TOO_WIDE)  # reasons of a failure that no limit admits
INACCURATE = "fail, off the accuracy asked for"
# Calibrated: what an error at a drawn step, or tolerance, may be times those at listed ones, where
# no theory says more. Of 1752 draws of the quick profile, by the seeds 1 to 4, the largest were 2.2
# and 6.6 (`python -m plumbob.tests.validation.drawn_steps 1 4`); seed 5 has one of 2.6.
BETWEEN = MappingProxyType({"step": 4.0, "tolerance": 20.0})
Standing = Literal["as expected", "known limit", "pre-asymptotic", "not run", "unexpected"]


@dataclass(frozen=True)
class Expectation:
    """A verdict other than `pass` that scenes and methods of these patterns are to have."""

    scenes: str
    methods: str
    verdict: Verdict
    reason: str
    other: Verdict | None = None  # also expected: which of the two depends on the step sizes

    @property
    def limit(self) -> bool:
        """Whether it admits a known limit, the error of which has a size."""
        return not {self.verdict, self.other} <= {"pass", "converges", "unsupported", None}

    def allows(self, judgement: Judgement) -> bool:
        """Whether a verdict is an expected one. Of a convergence study cut short, a failure is also
        expected where the error is expected not to converge, and a pass is not where the steps are
        expected to be too large; and to leave out an observable, to start elsewhere or declare too
        much is no limit of a kind that is known here."""
        if judgement.reason.startswith(NO_LIMITS):
            return False
        allowed = {self.verdict, self.other}
        if judgement.cut and "not-converging" in allowed:
            allowed.add("fail")
        if judgement.cut and self.verdict == "pre-asymptotic":
            allowed.discard("pass")
        return judgement.verdict in allowed


# MuJoCo with contacts that are not those of `coulomb`.
_CONTACTS = (
    *("mujoco/euler", "mujoco/implicitfast", "mujoco/rk4", "mujoco/euler+pyramidal"),
    *("mujoco/euler+elliptic", "mujoco/euler+elliptic+noslip"),
)
_CHATTER = (
    "contact chatter of a sliding body: the friction cone couples slip speed to normal force; the"
    " channels show the vertical displacement, and samples without all three contacts, at every"
    " step"
)
_DRIFT = (
    "friction at rest is a spring and damper here, whose regularised stiction drifts at every"
    " step; noslip stops where its own tolerance allows, and pyramids have less friction between"
    " their edges"
)
_DEFLECTION = "a contact deflection of 0.1 mm tilts the body: 1e-10 m, and normal forces that lag"
_AFTERWARDS = (
    "noslip changes friction after the normal forces are found: where a support carries hardly"
    " anything, that is up to 1.4 times theory's bound at the coarsest step, 3e-10 m and 3e-10 rad,"
    " and falls with the square of the step"
)
_EQUAL_LOADS = (
    "one equation, of vertical displacement, for three normal forces: MuJoCo distributes the weight"
    " equally over them, where statics does not, and friction turns the body"
)
_PIVOTS = (
    "a joint on a rigid body off its centre clamps the impulse that would bring it to rest, which"
    " is not along its velocity; no step and no number of solver iterations fixes it"
)
_QUICK_TURN = (
    f"{_PIVOTS}; but in a quick turn friction contributes epsilon^2 alone, less than the error of"
    " the step"
)
_HIDDEN = f"{_CHATTER}; an Euler step's leak of angular momentum may hide that plateau"
_NANOMETRE = (
    "the body moves by 1.3 nm in all, and what the solver's iterations leave may be micrometres"
)
_VARIES = (
    f"{_CHATTER}; where a plan then ends differs from step to step by more than a plateau shows"
)
_BOX = (
    "friction is a box by default, whose sides lie along the world's axes: off them it is up to"
    " 1.41 times what it should be"
)
_DAMPED = "every body's velocities are damped by 4 % a second by default, whatever the step"
_IMPULSES = (
    "friction at the contacts of a rigid body is solved direction by direction: its error depends"
    " on the heading, and not on the step"
)
_REGULARISED = (
    "friction is regularised over the speed of the stiction tolerance, 0.1 mm/s by default, in"
    " which a body that should stick drifts"
)
_STUCK = (
    "the solver gives up where a support that is all but unloaded sticks within 1e-7 m/s, and says"
    " so"
)
_NO_CONTACTS = (
    "the engine has no unilateral contacts with Coulomb friction, or none that is carried over"
)
_SPINNING = (
    "with a lone free body that turns, implicitfast takes derivatives of centripetal forces into"
    " its step, which no theory here covers"
)
_NO_THEORY = "no theory here covers what the engine does in a step"
_NO_CLOSED_FORM = "the reference is a series or a quadrature: there is no closed form"
_TWO_DIMENSIONS = "pymunk has two dimensions, and the body turns in three"
_NUMERICAL = (  # scenes whose reference is no closed form
    *("capsule-coast/spin", "capsule-plan/*", "capsule-turn/*", "simple-pendulum/damped-*"),
    *("simple-pendulum/forced-*", "simple-pendulum/overdamped"),
)
EXPECTATIONS: tuple[Expectation, ...] = (
    Expectation("capsule-line/w1-threshold*", "pymunk/feet", "pre-asymptotic", _NANOMETRE, "pass"),
    Expectation("capsule-line/frictionless", "pymunk/pivots", "pass", ""),
    Expectation("capsule-hold/0.5", "pymunk/pivots", "pass", ""),
    Expectation("capsule-hold/0.9", "pymunk/pivots", "pass", ""),
    Expectation("capsule-coast/rotation", "pymunk/pivots", "pass", ""),
    Expectation("capsule-turn/0.0*", "pymunk/pivots", "fail", _QUICK_TURN),
    Expectation("capsule-turn/unloaded*", "pymunk/pivots", "not-converging", _QUICK_TURN, "fail"),
    Expectation("capsule-*", "pymunk/pivots", "not-converging", _PIVOTS),
    Expectation("capsule-line/frictionless", "mujoco/rk4", "not-converging", _DEFLECTION),
    *(Expectation("capsule-line/frictionless", m, "fail", _DEFLECTION) for m in _CONTACTS),
    *(Expectation("capsule-hold/*", m, "not-converging", _DRIFT) for m in _CONTACTS),
    *(
        Expectation(scenes, m, "not-converging", _HIDDEN, "fail")
        for scenes in ("capsule-turn/0.[01]*", "capsule-turn/heading-*", "capsule-turn/unloaded*")
        for m in _CONTACTS
        if m != "mujoco/rk4"
    ),
    *(Expectation("capsule-plan/*", m, "not-converging", _VARIES, "fail") for m in _CONTACTS),
    *(
        Expectation(scene, "mujoco/euler+coulomb+noslip", "fail", _AFTERWARDS)
        for scene in ("capsule-coast/edge", "capsule-hold/unloading")
    ),
    *(Expectation("capsule-*", m, "not-converging", _CHATTER) for m in _CONTACTS),
    Expectation("capsule-line/*", "mujoco/euler+planar", "fail", _EQUAL_LOADS),
    Expectation("free-body/*", "pymunk/*", "unsupported", _TWO_DIMENSIONS),
    *(
        Expectation(s, "dart/default", "not-converging", _BOX)
        for s in (
            *("capsule-line/heading-030", "capsule-line/heading-045", "capsule-coast/*"),
            *("capsule-turn/heading-*", "capsule-plan/heading-*", "capsule-*/light-slider"),
        )
    ),
    Expectation("capsule-hold/unloading", "drake/tamsi+stiction", "diverged", _STUCK),
    Expectation("capsule-*", "exudyn/default", "unsupported", _NO_CONTACTS),
    Expectation("capsule-*", "pinocchio/aba+rk4", "unsupported", _NO_CONTACTS),
    Expectation("capsule-line/*", "drake/default", "not-converging", _REGULARISED),
    Expectation("capsule-line/*", "drake/tamsi", "not-converging", _REGULARISED),
    Expectation("capsule-line/*", "drake/sap", "not-converging", _REGULARISED),
    *(
        Expectation("capsule-line/*", m, "not-converging", _REGULARISED, "pre-asymptotic")
        for m in ("drake/similar", "drake/lagged+stiction")
    ),
    Expectation("*-pendulum/*", "pybullet/default", "not-converging", _DAMPED),
    Expectation("capsule-*", "pybullet/*", "not-converging", _IMPULSES),
    *(Expectation(s, "exact/closed-form", "unsupported", _NO_CLOSED_FORM) for s in _NUMERICAL),
    Expectation("capsule-coast/spin", "mujoco/implicitfast+coulomb", "converges", _SPINNING),
    *(
        Expectation("*-pendulum/*", m, "converges", _NO_THEORY)
        for m in ("exudyn/default", "exudyn/alpha+tight", "exudyn/rk67", "mjx/default")
    ),
    *(Expectation("capsule-*", m, "converges", _NO_THEORY) for m in ("dart/*", "drake/*")),
)


def expected(scene: str, method: str) -> Expectation:
    """The first expectation that matches, of plumbob's own or what the package of an added engine
    declares; or `pass`, or where a package brings no theory `converges`."""
    for entry in EXPECTATIONS:
        if fits(scene, entry.scenes) and fits(method, entry.methods):
            return entry
    if (limit := declared_limit(scene, method)) is not None:
        return Expectation(limit.scenes, method, cast(Verdict, limit.verdict), limit.reason)
    return Expectation(scene, method, "pass", "", _without_theory(scene, method))


def _without_theory(scene: str, method: str) -> Verdict | None:
    """`converges` for a system of another package, which brings its own theory, and for a method of
    one whose scheme has a name of its own; for plumbob's own, EXPECTATIONS declare it."""
    try:
        how, where = find_method(method), find_system(scene.partition("/")[0])
    except ParameterError:  # of a stored study, whose engine is no longer there
        return None
    foreign = engine_of(how).distribution and not how.scheme.known
    return "converges" if foreign or where.distribution else None


def refused(scene: str, method: str, judgement: Judgement) -> bool:
    """Whether an engine did not run a scene though nothing declares it unsupported; a scene of
    which the profile leaves out every step was not tried, and a user's own settings claim
    nothing."""
    if judgement.verdict != "unsupported" or method == USER_METHOD:
        return False
    untried = judgement.cut and judgement.reason == NO_STEP_FITS
    return not untried and not expected(scene, method).allows(judgement)


def surprise(scene: Scene, method: Method, judgement: Judgement) -> str:
    """Why a verdict on a convergence study is not the expected one; empty where it is. An engine
    that is not installed is no surprise, nor is a verdict on a user's own settings, of which
    nothing is expected, unless the accuracy that was asked for is missed."""
    if judgement.inaccurate:
        return INACCURATE
    if method.name == USER_METHOD or judgement.verdict == "missing":
        return ""
    if judgement.claims:
        return judgement.claims
    wanted = expected(scene.name, method.name)
    if judgement.verdict == "unsupported":
        return _verdicts(wanted, judgement) if refused(scene.name, method.name, judgement) else ""
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
    if held and error > BETWEEN[method.control] * max(held):
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
    wanted, short = expected(scene.name, method.name), replace(judgement, cut=True)
    if judgement.inaccurate:
        return INACCURATE
    if method.name == USER_METHOD or judgement.verdict in ("pre-asymptotic", "missing"):
        return ""
    passes = {wanted.verdict, wanted.other} & {"pre-asymptotic", "not-converging"}
    if judgement.verdict == "pass" and passes:
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
        held = errors_of_solvers().get((scene.name, method.name), {})
        return not_those(held, judgement.errors, known_within(method, judgement.versions))
    if not wanted.limit or judgement.verdict == "pass":
        return ""
    known = sizes().get((scene.name, method.name))
    if known is None and (limit := declared_limit(scene.name, method.name)) is not None:
        why = "" if run else differs_from(limit.size, judgement.errors)
    elif known is None:
        why = "no size of it is known"
    elif run:
        why = next((known.differs_at(*entry) for entry in judgement.errors.items()), "")
    else:
        why = known.differs(judgement.errors, known_within(method, judgement.versions))
    return f"{judgement.verdict}, a known limit, but {why}" if why else ""


def _changed(scene: Scene) -> bool:
    try:
        usual = find_scene(scene.name)
    except ParameterError:
        return False
    same = (dict(usual.parameters), usual.duration) == (dict(scene.parameters), scene.duration)
    return not same


def accurate(judgement: Judgement, within: float) -> Judgement:
    """The judgement, as `fail` where the relative error of the finest run exceeds `within`."""
    if not judgement.errors or judgement.errors[finest := min(judgement.errors)] <= within:
        return judgement
    error = f"the relative error is {judgement.errors[finest]:.2g} at {finest:g}"
    why = f"{error}, and {within:g} was asked for"
    return replace(judgement, verdict="fail", reason=why, inaccurate=True)


def standing(scene: Scene, method: Method, judgement: Judgement) -> Standing:
    """A verdict's meaning to a reader: `known limit` is a declared one, `pre-asymptotic` and `not
    run` claim nothing."""
    if not as_expected(scene, method, judgement):
        return "unexpected"
    if judgement.verdict in ("unsupported", "missing"):
        return "not run"
    if method.name == USER_METHOD or judgement.verdict == "pass":
        return "as expected"
    if expected(scene.name, method.name).limit:
        return "known limit"
    return "as expected" if judgement.verdict == "converges" else "pre-asymptotic"
