"""Known limits and unsupported pairs, with their reasons: strict, so that a limit that disappears,
and an engine that refuses a model without having said so, are reported."""

from __future__ import annotations

import fnmatch
from dataclasses import dataclass, replace
from typing import Literal

from plumbob.engines.method import USER_METHOD, Method
from plumbob.models.scene import Scene
from plumbob.reports.judge.verdict import NO_STEP_FITS, Judgement, Verdict

Standing = Literal["as expected", "known limit", "pre-asymptotic", "not run", "unexpected"]


@dataclass(frozen=True)
class Expectation:
    """A verdict other than `pass` that scenes and methods of these patterns are to have."""

    scenes: str
    methods: str
    verdict: Verdict
    reason: str
    other: Verdict | None = None  # also expected: which of the two depends on the step sizes

    def allows(self, found: Judgement) -> bool:
        """Whether a verdict is an expected one; of a convergence study cut short, a failure is also
        expected where the error is expected not to converge."""
        allowed = (self.verdict, self.other)
        short = found.cut and found.verdict == "fail"
        return found.verdict in allowed or (short and "not-converging" in allowed)


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
_VARIES = (
    f"{_CHATTER}; where a plan then ends differs from step to step by more than a plateau shows"
)
_NO_CLOSED_FORM = "the reference is a series or a quadrature: there is no closed form"
_NUMERICAL = (  # scenes whose reference is no closed form
    *("capsule-coast/spin", "capsule-plan/*", "capsule-turn/*", "simple-pendulum/damped-*"),
    *("simple-pendulum/forced-*", "simple-pendulum/overdamped"),
)
_LONE = (
    "with a lone free body implicitfast takes velocity derivatives of centripetal forces into its"
    " step, as implicit does: another scheme, of first order too, with 2.6 times the error"
)

EXPECTATIONS: tuple[Expectation, ...] = (
    Expectation("capsule-line/frictionless", "pymunk/pivots", "pass", ""),
    Expectation("capsule-hold/0.5", "pymunk/pivots", "pass", ""),
    Expectation("capsule-hold/0.9", "pymunk/pivots", "pass", ""),
    Expectation("capsule-coast/rotation", "pymunk/pivots", "pass", ""),
    Expectation("capsule-turn/0.0*", "pymunk/pivots", "fail", _QUICK_TURN),
    Expectation("capsule-*", "pymunk/pivots", "not-converging", _PIVOTS),
    Expectation("capsule-line/frictionless", "mujoco/rk4", "not-converging", _DEFLECTION),
    *(Expectation("capsule-line/frictionless", m, "fail", _DEFLECTION) for m in _CONTACTS),
    *(Expectation("capsule-hold/*", m, "not-converging", _DRIFT) for m in _CONTACTS),
    *(
        Expectation("capsule-turn/0.[01]*", m, "not-converging", _HIDDEN, "fail")
        for m in _CONTACTS
        if m != "mujoco/rk4"
    ),
    *(Expectation("capsule-plan/*", m, "not-converging", _VARIES, "fail") for m in _CONTACTS),
    *(Expectation("capsule-*", m, "not-converging", _CHATTER) for m in _CONTACTS),
    Expectation("capsule-coast/spin", "mujoco/implicitfast+coulomb", "fail", _LONE),
    Expectation("capsule-line/*", "mujoco/euler+planar", "fail", _EQUAL_LOADS),
    *(Expectation(s, "exact/closed-form", "unsupported", _NO_CLOSED_FORM) for s in _NUMERICAL),
)


def expected(scene: str, method: str) -> Expectation:
    """The first expectation that matches, or `pass`."""
    for entry in EXPECTATIONS:
        if fnmatch.fnmatchcase(scene, entry.scenes) and fnmatch.fnmatchcase(method, entry.methods):
            return entry
    return Expectation(scene, method, "pass", "")


def refused(scene: str, method: str, found: Judgement) -> bool:
    """Whether an engine did not run a scene though nothing declares it unsupported; a scene of
    which the profile leaves out every step was not tried, and a user's own settings claim
    nothing."""
    if found.verdict != "unsupported" or method == USER_METHOD:
        return False
    untried = found.cut and found.reason == NO_STEP_FITS
    return not untried and not expected(scene, method).allows(found)


def as_expected(scene: Scene, method: Method, found: Judgement) -> bool:
    """Whether a verdict is the expected one. An engine that is not installed is no surprise, nor is
    a verdict on a user's own settings, of which nothing is expected; and on a hard scene, or in a
    quick profile, every step may be too large for the theory, which the page says, and which claims
    nothing."""
    if method.name == USER_METHOD or found.verdict == "missing":
        return True
    if found.verdict == "unsupported":
        return not refused(scene.name, method.name, found)
    if found.verdict == "pre-asymptotic" and (
        scene.hard or found.cut or method.control == "tolerance"
    ):
        return True
    return expected(scene.name, method.name).allows(found)


def run_as_expected(method: Method, scene: str, found: Judgement) -> bool:
    """Whether the verdict on one run is an expected one. A run is a convergence study cut short: of
    an error that does not converge it may fail, or pass where the step's own error is larger; and
    it may be too large for the theory, or smaller than all steps of a study that are."""
    wanted, short = expected(scene, method.name), replace(found, cut=True)
    if method.name == USER_METHOD or found.verdict in ("pre-asymptotic", "missing"):
        return True
    if found.verdict == "pass" and {wanted.verdict, wanted.other} & {
        "pre-asymptotic",
        "not-converging",
    }:
        return True
    return wanted.allows(short)


def standing(scene: Scene, method: Method, found: Judgement) -> Standing:
    """What a verdict means to who reads it: `known limit` is a declared one, `pre-asymptotic` and
    `not run` claim nothing."""
    if not as_expected(scene, method, found):
        return "unexpected"
    if found.verdict in ("unsupported", "missing"):
        return "not run"
    if method.name == USER_METHOD or found.verdict == "pass":
        return "as expected"
    limit = expected(scene.name, method.name)
    if limit.verdict != "pass" and limit.allows(found):
        return "known limit"
    return "pre-asymptotic"
