"""Derivatives by engines' own means, beside MuJoCo's: each has the error of its step."""

import pytest

from plumbob.engines.adapters.mjx import _loop
from plumbob.tests.peers.test_smooth_peers import CONE, DAMPED, FORCED, SWING, needed
from plumbob.tests.support.derivatives import judged_way


@pytest.mark.parametrize(
    ("name", "how", "by", "way", "why"),
    [
        (CONE, "pinocchio/aba+rk4", "platform_rate", "rnea", ""),
        (CONE, "pinocchio/aba+euler", "theta", "rnea", ""),
        (DAMPED, "pinocchio/aba+rk4", "damping_rate", "rnea", ""),
        (FORCED, "pinocchio/aba+euler", "forcing_amplitude", "rnea", ""),
        (SWING, "pinocchio/aba+rk4", "gravity", "rnea", ""),
        ("servo/saturated", "pinocchio/aba+rk4", "kp", "rnea", "a motor's limit"),
        (CONE, "drake/default", "pivot_y", "autodiff", ""),
        (DAMPED, "drake/default", "length", "autodiff", ""),
        (SWING, "drake/default", "gravity", "autodiff", "gravity is no parameter in a context"),
        (FORCED, "drake/default", "length", "autodiff", "a motor's force is no parameter"),
        (
            "servo/stiff",
            "drake/default",
            "kp",
            "autodiff",
            "an actuator's gain is no parameter",
        ),
        (CONE, "drake/rk3", "theta", "autodiff", "need a discrete plant"),
        (SWING, "mjx/euler+float64", "length", "jacfwd", ""),
        # JAX compiles each way for 20 s
        pytest.param(
            *(SWING, "mjx/euler+float64", "gravity", "jacrev", ""), marks=pytest.mark.rare
        ),
    ],
)
def test_an_own_way_has_the_error_of_its_step(name, how, by, way, why):
    needed(how)
    judged = judged_way(name, how, "theta", by, way, at=0.1)
    assert judged.verdict == ("unsupported" if why else "predicted"), judged.why
    assert why in judged.why


@pytest.mark.parametrize(
    ("how", "way"), [("drake/default", "autodiff"), ("pinocchio/aba+rk4", "rnea")]
)
def test_an_own_way_reaches_a_tree_with_three_joints_of_one_body(how, way):
    needed(how)
    by = ("heavy-top/nutating", how, "precession", "tilt", way)
    judged = judged_way(*by, at=0.1)
    assert judged.verdict == "predicted", judged.why


def test_all_runs_of_mjx_share_a_compiled_loop():
    needed("mjx/default")
    before = _loop()._cache_size()
    judged = judged_way(CONE, "mjx/default", "theta", "theta", "jacfwd", at=0.1)
    assert judged.verdict == "predicted", judged.why
    assert _loop()._cache_size() <= before + 1
