"""What is known to go wrong, and why: strict, so that a limit that disappears is told."""

from __future__ import annotations

import fnmatch
from dataclasses import dataclass

from plumbob.engines.method import USER_METHOD, Method
from plumbob.models.scene import Scene
from plumbob.reports.judge.verdict import Judgement, Verdict


@dataclass(frozen=True)
class Expectation:
    """A verdict other than `pass` that scenes and methods of these patterns are to have."""

    scenes: str
    methods: str
    verdict: Verdict
    reason: str
    other: Verdict | None = None  # as good: which of the two it is hangs on the step_sizes

    def allows(self, found: Judgement) -> bool:
        """Whether a verdict is the expected one, or as good; of a step_sizes cut short, a failure is as
        good as the finding that none of its steps helps."""
        good = (self.verdict, self.other)
        short = found.cut and found.verdict == "fail"
        return found.verdict in good or (short and "not-converging" in good)


# MuJoCo with contacts that are not those of `coulomb`.
_CONTACTS = (
    *("mujoco/euler", "mujoco/implicitfast", "mujoco/rk4", "mujoco/euler+pyramidal"),
    *("mujoco/euler+elliptic", "mujoco/euler+elliptic+noslip"),
)
_HOPS = (
    "a body that slides on these contacts hops: the cone couples slip speed to normal force; the"
    " channels show its heave, and samples without all three contacts, at every step"
)
_CREEPS = "friction that holds is a spring and damper here, which creeps at every step; " + (
    "noslip stops where its own tolerance lets it, and pyramids hold less between their edges"
)
_YIELDS = "contacts that yield by 0.1 mm tilt the body: 1e-10 m, and normal forces that lag"
_SHARES = (
    "one equation, of heave, for three normal forces: MuJoCo shares the weight equally among them,"
    " where statics does not, and friction turns the body"
)

_PIVOTS = (
    "a joint on a rigid body off its centre clamps the impulse that would bring it to rest, which"
    " is not along its velocity; no step and no number of sweeps mends it"
)

_LOSES = (
    "a joint as it comes loses energy at first order: at 5e-5 s, a million steps, theta is still"
    " off by 0.8 rad after 50 s, which is beyond a series in the step; error_bias 0 mends it"
)
_QUICK = f"{_PIVOTS}; but of a quick turn friction makes epsilon^2 alone, and the step errs by more"

_HIDES = f"{_HOPS}; an Euler step's leak of angular momentum may hide that floor"
_WANDERS = f"{_HOPS}; where a plan then ends differs from step to step, by more than a floor shows"
_LONE = (
    "with a lone free body implicitfast takes velocity derivatives of centripetal forces into its"
    " step, as implicit does: another scheme, of first order too, that errs 2.6 times as much"
)

EXPECTATIONS: tuple[Expectation, ...] = (
    Expectation("simple-pendulum/free-large", "pymunk/default", "coarse", _LOSES),
    Expectation("capsule-line/frictionless", "pymunk/pivots", "pass", ""),
    Expectation("capsule-hold/0.5", "pymunk/pivots", "pass", ""),
    Expectation("capsule-hold/0.9", "pymunk/pivots", "pass", ""),
    Expectation("capsule-coast/rotation", "pymunk/pivots", "pass", ""),
    Expectation("capsule-turn/0.0*", "pymunk/pivots", "fail", _QUICK),
    Expectation("capsule-*", "pymunk/pivots", "not-converging", _PIVOTS),
    Expectation("capsule-line/frictionless", "mujoco/rk4", "not-converging", _YIELDS),
    *(Expectation("capsule-line/frictionless", m, "fail", _YIELDS) for m in _CONTACTS),
    *(Expectation("capsule-hold/*", m, "not-converging", _CREEPS) for m in _CONTACTS),
    *(
        Expectation("capsule-turn/0.[01]*", m, "not-converging", _HIDES, "fail")
        for m in _CONTACTS
        if m != "mujoco/rk4"
    ),
    *(Expectation("capsule-plan/*", m, "not-converging", _WANDERS, "fail") for m in _CONTACTS),
    *(Expectation("capsule-*", m, "not-converging", _HOPS) for m in _CONTACTS),
    Expectation("capsule-coast/spin", "mujoco/implicitfast+coulomb", "fail", _LONE),
    Expectation("capsule-line/*", "mujoco/euler+planar", "fail", _SHARES),
)


def expected(scene: str, method: str) -> Expectation:
    """The first expectation that matches, or `pass`."""
    for entry in EXPECTATIONS:
        if fnmatch.fnmatchcase(scene, entry.scenes) and fnmatch.fnmatchcase(method, entry.methods):
            return entry
    return Expectation(scene, method, "pass", "")


def as_expected(scene: Scene, method: Method, found: Judgement) -> bool:
    """Whether a verdict is the expected one. What cannot be run breaks no promise, nor do a user's
    own settings, of which nothing is promised; and a hard scene may be beyond every step of its
    step_sizes, or a quick profile beyond its own, which the page says, and which claims nothing."""
    if method.name == USER_METHOD:
        return True
    if found.verdict in ("unsupported", "missing"):
        return True
    if found.verdict == "coarse" and (scene.hard or found.cut or method.control == "tolerance"):
        return True
    return expected(scene.name, method.name).allows(found)
