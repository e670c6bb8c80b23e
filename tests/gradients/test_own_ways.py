"""Engines' own derivatives: their errors are the derivatives of the predicted errors, and what a
way cannot do has a reason."""

import mujoco
import numpy as np
import pytest

from plumbob.analytic.sensitivities.neighbours import Neighbours
from plumbob.engines.adapters.mujoco import transition
from plumbob.engines.adapters.ode import forward
from plumbob.engines.adapters.own_derivatives import moved
from plumbob.tests.support.derivatives import judged_way

CONE, LINE, SWING, SPIN = (
    "cone-pendulum/rotating-base",
    "capsule-line/heading-030",
    "simple-pendulum/free-large",
    "free-body/about-largest",
)
COAST = "capsule-coast/translation"
LEFT = 0.02  # of a derivative: of one 250 times as large as the start, by differences of steps
# The allowance for rounding includes the fast passage, which magnifies it 3,000 times.
LEFT_NEAR_SADDLE = 0.2


@pytest.mark.long(keep=3)
@pytest.mark.parametrize(
    ("name", "how", "of", "by", "way"),
    [
        (CONE, "mujoco/euler", "theta", "theta", "transition"),
        (CONE, "mujoco/euler", "theta_dot", "platform_rate", "transition"),
        (LINE, "mujoco/euler+coulomb", "displacement", "w1", "transition"),
        ("cone-pendulum/equal-wells-short", "mujoco/implicit", "theta", "theta", "inverse"),
        ("slider-crank/turning", "mujoco/euler", "angle", "angle", "inverse"),
        ("cone-pendulum/fast-platform", "mujoco/euler", "theta", "theta", "inverse"),
        ("cone-pendulum/equal-wells", "mujoco/euler", "theta", "theta", "transition"),
        (COAST, "mujoco/implicitfast+coulomb", "y", "velocity_x", "transition"),
        (COAST, "mujoco/euler+reduced", "y", "velocity_x", "transition"),
        (SPIN, "mujoco/euler", "angular_velocity_x", "angular_velocity[0]", "inverse"),
        (CONE, "ode/euler", "theta", "pivot_y", "variational"),
        (CONE, "ode/leapfrog", "theta", "theta", "variational"),
        (CONE, "ode/rk4", "theta", "platform_rate", "variational"),
        (CONE, "ode/radau", "theta", "platform_rate", "variational"),
        ("simple-pendulum/near-top-1e-11", "ode/dop853", "theta", "gravity", "variational"),
    ],
)
def test_an_own_way_has_the_error_of_its_step(name, how, of, by, way):
    judged = judged_way(name, how, of, by, way)
    assert (judged.verdict, judged.why) == ("predicted", "")
    left = LEFT_NEAR_SADDLE if name == "cone-pendulum/equal-wells" else LEFT
    assert judged.tried.left_open < left * abs(judged.gradient.exact)


def test_two_ways_have_one_derivative_of_a_step():
    """To the rounding of differences, with accelerations of 4e5 rad/s^2, and no more is left."""
    fast = "cone-pendulum/fast-platform", "mujoco/implicit", "theta", "theta"
    judged = [judged_way(*fast, way) for way in ("transition", "inverse")]
    errors = [each.relative_error for each in judged]
    assert errors[0] == pytest.approx(errors[1], abs=1e-5)
    assert all(each.record()["left_open"] < 4e-5 for each in judged)


@pytest.mark.parametrize("size", [1e-310, 0.0])
def test_a_state_that_has_decayed_has_no_derivative_left(size):
    read = moved(lambda place: {"theta": np.array([place * size])}, np.array([size]))
    assert read["theta"] == pytest.approx(0.0, abs=1e-300)


@pytest.mark.long
@pytest.mark.parametrize("touching", [transition.TOUCHING_NUDGE, transition.STEP_NUDGE])
def test_a_support_that_begins_to_slip_is_slower_than_a_nudge(touching, monkeypatch):
    """Its friction turns round with a nudge of 1e-6 m/s, which one beside it shows."""
    monkeypatch.setattr(transition, "TOUCHING_NUDGE", touching)
    pivot = "capsule-turn/pivot", "mujoco/euler+coulomb", "heading", "angular_acceleration"
    judged = judged_way(*pivot, "transition", 2.5e-4)
    assert (judged.record()["left_open"] < 1e-3) == (touching < transition.STEP_NUDGE)


@pytest.mark.parametrize(
    ("name", "how", "of", "by", "way", "why"),
    [
        (CONE, "mujoco/rk4", "theta", "theta", "transition", "refuse RK4"),
        (
            CONE,
            "mujoco/euler",
            "theta",
            "gravity",
            "transition",
            "gravity is a parameter of the",
        ),
        (
            CONE,
            "mujoco/euler",
            "theta",
            "gravity",
            "inverse",
            "by the state alone, not by gravity",
        ),
        (
            LINE,
            "mujoco/euler+coulomb",
            "displacement",
            "w1",
            "inverse",
            "too large for friction",
        ),
        (COAST, "mujoco/euler+reduced", "x", "velocity_x", "inverse", "too large for friction"),
        (CONE, "pymunk/torque", "theta", "gravity", "transition", "pymunk has no way called"),
        (
            SWING,
            "mujoco/euler",
            "tension",
            "theta",
            "transition",
            "gives theta, theta_dot alone",
        ),
        (SWING, "ode/rk4", "theta", "damping_rate", "variational", "damping_rate = -"),
        (
            "projectile",
            "ode/rk4",
            "z",
            "gravity",
            "variational",
            "only with one degree of freedom",
        ),
    ],
)
def test_what_a_way_cannot_do_has_a_reason(name, how, of, by, way, why):
    judged = judged_way(name, how, of, by, way, at=0.1)
    assert judged.verdict == "unsupported"
    assert why in judged.why


@pytest.mark.parametrize(
    ("way", "function", "part"),
    [("transition", "mjd_transitionFD", 1e-6), ("inverse", "mjd_inverseFD", 1e-4)],
)
def test_a_wrong_derivative_of_the_state_is_seen(way, function, part, monkeypatch):
    right = getattr(mujoco, function)

    def wrong(model, data, eps, *rest):
        right(model, data, eps, *rest)
        if rest[1] is not None:
            rest[1][:] *= 1.0 + part

    monkeypatch.setattr(mujoco, function, wrong)
    judged = judged_way(CONE, "mujoco/euler", "theta", "theta", way)
    assert judged.verdict == "off-prediction"
    assert judged.surprise


def test_a_sensitivity_without_a_term_is_seen(monkeypatch):
    right = forward._with_sensitivity

    def without(equations):
        return right(Neighbours((equations.here,) * 9, equations.offsets))

    monkeypatch.setattr(forward, "_with_sensitivity", without)
    judged = judged_way(CONE, "ode/rk4", "theta", "platform_rate", "variational")
    assert judged.verdict == "off-prediction"
