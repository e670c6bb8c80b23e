"""The rolling ball against 40 digits, an integration and theory; its file against its builder."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import solve_ivp

from plumbob.engines.registry import method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, matching_scenes, scene
from plumbob.reports.judge.verdict import judge

SCENES = matching_scenes("rolling-ball")
BALL = case_of(scene("rolling-ball/slide-to-roll")).problem
CHANGES = [
    {},
    {"spin": -50.0},
    {"spin": 300.0},
    {"spin": 20.0},  # rolls from the start
    {"friction": 0.0},
    {"rolling_friction": 5e-3},
    {"rolling_friction": 5e-3, "spin": -40.0},
    {"rolling_friction": 5e-3, "spin": -40.0, "speed": 0.1},
    {"rolling_friction": 0.025, "spin": -3.0},  # the spin ends, and does not begin anew
    {"rolling_friction": 0.05, "spin": 60.0},  # too much of it to roll
    {"rolling_friction": 0.027999, "spin": 60.0},  # all but too much
    {"rolling_friction": 0.01, "friction": 0.0, "spin": 3.0},
    {"torsional_friction": 0.1, "speed": -2.0, "spin": 7.0},
]


def stepped_to(ball, end):
    """Place, v and R w with 40 digits, from switch to switch."""
    f = mp.mpf(ball.friction)
    k = mp.mpf(ball.rolling_friction) / ball.radius
    g = ball.gravity
    x = mp.mpf(0)
    v = mp.mpf(ball.speed)
    u = mp.mpf(ball.radius) * ball.spin
    left = mp.mpf(end)
    if abs(v - u) < mp.mpf(10) ** -15:
        u = v
    while left > 0 and (v or u):
        sticks = v == u and 5 * k <= 7 * f
        slip = mp.sign(v - u or v)
        turn = mp.sign(u)
        if not turn and k < f:
            turn = slip
        a = -f * g * slip
        b = mp.mpf(5) / 2 * g * (f * slip - k * turn)
        if sticks:
            a = b = -mp.mpf(5) / 7 * k * g * mp.sign(v)
        elif not u and k >= f:
            b = mp.mpf(0)
        until = [
            -y / r for y, r in ((v - u, a - b), (u, b), (v, a if sticks else 0)) if y * r < 0
        ]
        lasts = min([left, *until])
        x = x + lasts * (v + lasts * a / 2)
        v = v + lasts * a
        u = u + lasts * b
        left = left - lasts
        u = mp.mpf(0) if abs(u) < mp.mpf(10) ** -30 else u
        v = u if abs(v - u) < mp.mpf(10) ** -30 else v
    return [x, v, u / ball.radius]


@pytest.mark.parametrize("changes", CHANGES, ids=str)
def test_40_digits(changes):
    ball = replace(BALL, **changes)
    last = ball.pieces[-1].time
    times = np.concatenate([np.linspace(0.0, 1.5 * last + 1.0, 23), [last, 1e-9]])
    exact = ball.observe(times)
    doubt = ball.uncertainty(times)
    with mp.workdps(40):
        for i, time in enumerate(times):
            for name, value in zip(exact, stepped_to(ball, time), strict=True):
                assert abs(float(value - mp.mpf(exact[name][i]))) <= doubt[name][i], (
                    name,
                    time,
                )
    assert doubt["speed"].max() < 4e-15 * ball.scale


@pytest.mark.parametrize("changes", CHANGES, ids=str)
def test_an_integration_of_smoothed_friction_comes_near(changes):
    """With tanh for the signs, and no events: within 1e-3 of the speeds."""
    ball = replace(BALL, **changes)
    width = 1e-4
    times = np.linspace(0.0, 1.2, 25)

    def slope(time, y):
        rolled = ball.friction * np.tanh((y[1] - y[2]) / width)
        turned = ball.rolling_friction / ball.radius * np.tanh(y[2] / width)
        return y[1], -ball.gravity * rolled, 2.5 * ball.gravity * (rolled - turned)

    start = (0.0, ball.speed, ball.radius * ball.spin)
    run = solve_ivp(slope, (0.0, 1.2), start, "Radau", times, rtol=1e-8, atol=1e-9)
    for exact, values, size in zip(
        ball.observe(times).values(), run.y, (1, 1, ball.radius), strict=True
    ):
        assert np.abs(exact * size - values).max() < 1e-3 * ball.scale


@pytest.mark.parametrize("chosen", SCENES[:2], ids=lambda s: s.name)
@pytest.mark.parametrize(
    "name", ["exact/closed-form", "mujoco/euler+coulomb", "pymunk/contact"]
)
@pytest.mark.parametrize(
    "changes", [{}, {"radius": 0.03, "mass": 7.0, "friction": 0.45}], ids=str
)
def test_the_error_is_the_predicted_one(chosen, name, changes):
    how = method(name)
    case = case_of(replace(chosen, parameters={**chosen.parameters, **changes}))
    for step in (2e-3, 7e-4) if how.control == "step" else how.step_sizes[-1:]:
        judged = judge(measure(case, how, step)[0], case.system, how)
        assert judged.verdict == "predicted", judged.reason


@pytest.mark.parametrize("name", ["mujoco/euler+coulomb", "pymunk/contact"])
def test_a_slightly_different_friction_is_noticed(name):
    case = case_of(SCENES[0])
    how = method(name)
    near = replace(case, errors=case.system.errors(replace(BALL, friction=0.2 * (1 + 1e-6))))
    assert judge(measure(near, how, 1e-3)[0], case.system, how).verdict == "off-prediction"
