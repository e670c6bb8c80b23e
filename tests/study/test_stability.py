"""The largest step that holds, by runs: against closed forms, whatever the prediction, and red for
what is sabotaged."""

import math
import operator
from dataclasses import replace
from functools import partial

import pytest

from plumbob.analytic.stability import (
    TRIAL_STEP_RATIO,
    TRIAL_STRIDE,
    StabilityTheory,
    StepLimit,
)
from plumbob.analytic.tableau import CLASSICAL
from plumbob.engines.adapters import integrators
from plumbob.engines.largest_step import bracket
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.stability import (
    MeasuredLimit,
    SceneLimits,
    StabilitySearch,
    scene_limits,
    searched_limits,
)
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene
from plumbob.reports.judge.stability import judged_limits

SWING, OVERDAMPED = "linear-pendulum/free-small", "linear-pendulum/overdamped"
DAMPED = "linear-pendulum/damped-small"
OMEGA = math.sqrt(9.8)
# of a limit at an equilibrium: a bracket of 1 %, and as much for runs that are finite
SHARP = 0.02


def euler_limit(damping, implicit):
    """Where semi-implicit Euler's multiplier passes -1: h^2 omega^2 = 4 - 2 c h with explicit
    damping c, and 4 + 2 c h with implicit damping."""
    half = (1.0 if implicit else -1.0) * damping / OMEGA**2
    return half + math.sqrt(half * half + 4.0 / OMEGA**2)


def closed_forms():
    """Scenes, methods and limits [s]: RK4's from its stability function, 2.785 on the real axis and
    2 sqrt(2) on the imaginary one."""
    fast = 5.0 + math.sqrt(25.0 - OMEGA**2)
    return [
        *((SWING, m, 2.0 / OMEGA) for m in ("mujoco/euler", "ode/euler", "pymunk/spring")),
        (SWING, "ode/leapfrog", 2.0 / OMEGA),
        (OVERDAMPED, "ode/leapfrog", 2.0 / OMEGA),
        (SWING, "ode/rk4", math.sqrt(8.0) / OMEGA),
        (SWING, "mujoco/rk4", math.sqrt(8.0) / OMEGA),
        (OVERDAMPED, "ode/rk4", 2.785293563405282 / fast),
        (OVERDAMPED, "ode/euler", euler_limit(10.0, implicit=False)),
        (OVERDAMPED, "pymunk/spring", euler_limit(10.0, implicit=False)),
        (OVERDAMPED, "mujoco/euler", euler_limit(10.0, implicit=True)),
        (DAMPED, "ode/euler", euler_limit(0.08, implicit=False)),
        (DAMPED, "mujoco/implicitfast", euler_limit(0.08, implicit=True)),
    ]


def at_equilibrium(growth=lambda duration: 1.0):
    """A swing's record, without a limit."""
    return StabilityTheory(
        2.0 * math.pi / OMEGA, True, lambda s: (), growth, lambda seen: "swing"
    )


def found_by(scene, method, prediction):
    """The limit that a search from a prediction finds."""
    limits = () if prediction is None else (StepLimit("unstable", prediction, ""),)
    (limit,) = searched_limits(
        case_of(find_scene(scene)), find_method(method), at_equilibrium(), limits
    ).limits
    return limit


@pytest.mark.long(keep=4)
@pytest.mark.parametrize(("scene", "method", "wanted"), closed_forms())
def test_limits_of_linear_motions_are_those_of_closed_forms(scene, method, wanted):
    found = found_by(scene, method, None)
    assert found.fails == pytest.approx(TRIAL_STEP_RATIO * found.holds)
    assert found.holds / wanted == pytest.approx(1.0, abs=SHARP)


@pytest.mark.parametrize("first", range(-400, 401, 57))
@pytest.mark.parametrize("every", [1, TRIAL_STRIDE])
def test_a_bracket_is_that_of_its_numbers(first, every):
    begun = first // every * every
    for last in (-400, -123, 0, 1, 399):
        found = bracket(partial(operator.ge, last), begun, -400, 400, every)
        assert found == (last, last + 1)
    assert bracket(lambda n: True, begun, -400, 400, every) == (400, None)
    assert bracket(lambda n: False, begun, -400, 400, every) == (None, -400)


@pytest.mark.parametrize("first", [-300, -20, 0, 56, 88, 300])
def test_a_window_that_fails_below_is_seen_from_anywhere(first):
    def holds(number):
        return number <= 90 and number not in range(70, 75)

    assert bracket(holds, first, -400, 400, TRIAL_STRIDE) == (69, 70)


def test_a_motion_changes_its_kind_before_it_is_unstable():
    """RK4 takes a swing's energy away: within 10^4 steps all of it from h omega = 0.7 on, where its
    step holds up to 2.83."""
    theory = replace(
        at_equilibrium(),
        kind_of=lambda seen: "swing" if abs(seen["theta"][-50:]).max() > 1e-4 else "at rest",
    )
    case = case_of(find_scene(SWING))
    unstable, changes = searched_limits(case, find_method("ode/rk4"), theory, ()).limits
    assert (unstable.kind, changes.kind) == ("unstable", "changes-kind")
    assert changes.why == "swing becomes at rest"
    assert 0.5 < changes.fails * OMEGA < 1.0 < unstable.holds * OMEGA


def test_the_growth_of_the_exact_motion_is_taken_off():
    """Neighbours of a rotation turn at other rates: a nudge grows with time, and more than a
    thousandfold in 10^4 steps."""
    case = case_of(find_scene("simple-pendulum/rotating-slow"))
    method = find_method("ode/leapfrog")
    theory = replace(at_equilibrium(lambda duration: 1.0 + 20.0 * duration), equilibrium=False)
    own, without = (
        searched_limits(case, method, t, (StepLimit("unstable", 0.24, ""),)).limits[0].holds
        or 0.0
        for t in (theory, replace(theory, growth=lambda duration: 1.0))
    )
    assert own == pytest.approx(0.24, rel=0.1)
    assert without < 0.5 * own


def judged(method, limits, scene=SWING):
    """Verdicts, with a mark where unexpected."""
    search = StabilitySearch(scene, method)
    return [f"{of.verdict}{'!' * bool(of.surprise)}" for of in judged_limits(search, limits)]


def rk4_with(second, third):
    """RK4 with another weight of its third stage, and another place of that stage."""
    matrix = ((), (0.5,), (0.5 - third, third), (0.0, 0.0, 1.0))
    weights = (1.0, 2.0, second, 5.0 - 2.0 - second + 1.0)
    return integrators.explicit(replace(CLASSICAL, weights=weights, matrix=matrix, divisor=6.0))


SABOTAGED = {
    "one weight of RK4": ("rk4", "ode/rk4", rk4_with(2.2, 0.5)),
    "a spring in the wrong stage": ("rk4", "ode/rk4", rk4_with(2.0, 0.6)),
}


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("what", SABOTAGED)
def test_a_sabotaged_scheme_is_red(what, monkeypatch):
    name, method, wrong = SABOTAGED[what]
    scene = find_scene(OVERDAMPED)
    how = find_method(method)
    assert judged(method, scene_limits(scene, how), OVERDAMPED) == ["predicted"]
    monkeypatch.setattr(integrators, name, wrong)
    assert judged(method, scene_limits(scene, how), OVERDAMPED) == ["off-prediction!"]


def test_damping_that_is_explicit_is_red_where_implicit_damping_is_predicted():
    promised = euler_limit(10.0, implicit=True)
    kept = euler_limit(10.0, implicit=False)
    for limit, wanted in ((kept, ["predicted"]), (promised, ["off-prediction!"])):
        found = SceneLimits((found_by(OVERDAMPED, "ode/euler", limit),), True)
        assert judged("ode/euler", found, OVERDAMPED) == wanted


@pytest.mark.parametrize(
    ("predicted", "holds", "fails", "equilibrium", "wanted"),
    [
        (1.0, 0.995, 1.005, True, "predicted"),
        (1.0, 0.96, 0.97, True, "off-prediction!"),
        (1.0, 1.03, 1.04, True, "off-prediction!"),
        (1.0, 0.96, 0.97, False, "predicted"),
        (1.0, 0.88, 0.89, False, "off-prediction!"),
        (1.0, 1.12, 1.13, False, "off-prediction!"),
        (math.inf, 20.0, None, True, "predicted"),
        (math.inf, 20.0, 20.2, True, "off-prediction!"),
        (1.0, 20.0, None, True, "off-prediction!"),
        (30.0, 20.0, None, True, "predicted"),
        (1e-4, None, 1e-3, False, "predicted"),
        (1.0, None, 1e-3, False, "off-prediction!"),
        (None, 0.5, 0.505, True, "measured"),
    ],
)
def test_a_limit_is_judged_from_both_sides(predicted, holds, fails, equilibrium, wanted):
    limit = MeasuredLimit("unstable", predicted, holds, fails, "lost")
    assert judged("ode/rk4", SceneLimits((limit,), equilibrium)) == [wanted]
