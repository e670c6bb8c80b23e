"""A wrong exact motion is never `predicted` where theory steps the model itself and has the exact
motion on both sides: an error stays at every step that no theory derives."""

import math
from functools import cache

import pytest

from plumbob.analytic.systems.bouncing_ball import BouncingBall
from plumbob.analytic.systems.incline import Incline
from plumbob.analytic.systems.manoeuvres.line_motion import LineMotion
from plumbob.analytic.systems.rolling_ball import RollingBall
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.convergence import convergence_study
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.verdict import judge_method

MOST_STEPS = 20_000


def verdict_on(name, method):
    """The verdict on a method on a scene."""
    how = find_method(method)
    case = case_of(scene(name))
    found = convergence_study(scene(name), how, MOST_STEPS)
    return judge_method(found, case.system, how, case.system.quantities(case)).whole


@cache
def right(name, method):
    """The same, while nothing is wrong."""
    return verdict_on(name, method).verdict


RATES, FRICTION = RollingBall.rates, LineMotion.friction_force
WRONG = {
    "restitution squared": (
        *("bouncing-ball/half", BouncingBall, "_inner_restitution"),
        property(lambda ball: ball.restitution**2),
    ),
    "the sine for the tangent of a slope": (
        *("incline/just-slides", Incline, "holds"),
        property(lambda cube: math.sin(cube.slope) <= cube.friction),
    ),
    "a slope that never holds": ("incline/stops", Incline, "holds", False),
    "a tenth of friction too much": (
        *("rolling-ball/slide-to-roll", RollingBall, "rates"),
        lambda ball, v, u: tuple(1.1 * rate for rate in RATES(ball, v, u)),
    ),
    "a force that is read wrongly": (  # not the leading observable
        *("capsule-line/ca1", LineMotion, "friction_force"),
        lambda motion, times: 0.9 * FRICTION(motion, times),
    ),
}
"""What is wrong: a scene, and an attribute of a class with what it becomes."""
LARGE = ("a slope that never holds",)  # wrong by as much as the cube moves at all
METHODS = {"capsule-line/ca1": ("mujoco/euler+reduced", "pymunk/side")}
CONTACTS = ("mujoco/euler+coulomb", "pymunk/contact")


@pytest.mark.long(keep=5)
@pytest.mark.parametrize("engine", [0, 1], ids=["mujoco", "pymunk"])
@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_exact_motion_is_not_predicted(what, engine, monkeypatch):
    name, owner, attribute, wrong = WRONG[what]
    method = METHODS.get(name, CONTACTS)[engine]
    method = method.removesuffix("+coulomb") if owner is BouncingBall else method
    assert right(name, method) == "predicted"
    monkeypatch.setattr(owner, attribute, wrong)
    found = verdict_on(name, method)
    assert found.verdict == ("pre-asymptotic" if what in LARGE else "not-converging")
    assert "stays at" in found.reason
