"""The bouncing ball against 40 digits and event by event; contacts for a restitution."""

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp
from scipy.integrate import solve_ivp

from plumbob.analytic.errors.contact_models import impacts
from plumbob.engines.method import meant
from plumbob.engines.registry import engine_of, method, methods
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, matching_scenes, scene
from plumbob.reports.judge.verdict import judge

SCENES = matching_scenes("bouncing-ball")
BALL = case_of(scene("bouncing-ball/half")).problem


def height(ball, time):
    """The height z [m] with 40 digits, impact by impact."""
    h, e, g, left = map(mp.mpf, (ball.height, ball.restitution, ball.gravity, time))
    fall = mp.sqrt(2 * h / g)
    if left < fall:
        return h - g * left**2 / 2
    left = left - fall
    speed = e * g * fall
    while 2 * speed / g <= left and speed > mp.mpf(10) ** -30:
        left = left - 2 * speed / g
        speed = e * speed
    return (
        max(speed * left - g * left**2 / 2, mp.mpf(0))
        if speed > mp.mpf(10) ** -30
        else mp.mpf(0)
    )


@pytest.mark.parametrize("e", [0.0, 1e-8, 0.3, 0.5, 0.9, 1.0 - 1e-3, 1.0 - 1e-12, 1.0])
def test_40_digits(e):
    ball = replace(BALL, height=0.7, restitution=e)
    end = min(1.2 * ball.zeno_time, 60.0)
    times = np.concatenate([np.linspace(0.0, end, 57), [1e-9, ball.fall * (1 - 1e-9)]])
    exact = ball.observe(times)["z"]
    doubt = ball.uncertainty(times)["z"]
    with mp.workdps(40):
        errors = [
            abs(float(height(ball, t) - mp.mpf(z))) for t, z in zip(times, exact, strict=True)
        ]
    assert np.all(np.array(errors) <= doubt)
    assert doubt.max() < 1e-10  # an ulp of e moves impact n by n of its own


@pytest.mark.parametrize("e", [1.0, 0.9, 0.5, 0.2, 0.1353352832366127, 0.05])
def test_a_damping_ratio_gives_its_restitution(e):
    """By integration of the contact itself, until it no longer pushes."""
    zeta = impacts.damping_ratio(e)
    released = lambda t, y: -2 * zeta * y[1] - y[0]  # noqa: E731
    released.terminal, released.direction = True, -1
    slope = lambda t, y: (y[1], released(t, y))  # noqa: E731
    run = solve_ivp(
        slope, (0.0, 50.0), (0.0, -1.0), "DOP853", events=released, rtol=1e-12, atol=1e-14
    )
    assert run.y[1, -1] == pytest.approx(e, rel=1e-8)


@pytest.mark.parametrize("chosen", SCENES, ids=lambda s: s.name)
def test_every_method_makes_the_error_that_is_predicted(chosen):
    """Of the engines that are installed with plumbob; the others' are in `tests/peers`."""
    case = case_of(chosen)
    for how in methods():
        if meant(how, chosen) and not engine_of(how).optional:
            step = 1e-3 if how.control == "step" else how.step_sizes[-1]
            found, _ = measure(case, how, step)
            judged = judge(found, case.system, how)
            assert judged.verdict == "predicted", (how.name, judged.reason)


@pytest.mark.parametrize(
    ("constant", "value", "name"),
    [
        ("IMPACT_IMPEDANCE", 0.9901, "mujoco/euler"),
        ("ALLOWED_PENETRATION", 1.01e-4, "pymunk/contact"),
    ],
)
def test_a_slightly_different_contact_is_noticed(constant, value, name, monkeypatch):
    case = case_of(scene("bouncing-ball/half"))
    how = method(name)
    run = measure(case, how, 1e-3)[1]
    monkeypatch.setattr(impacts, constant, value)
    stepped = case.errors.at_step(how.scheme, 1e-3, run.times)
    predicted = stepped.errors["z"] + case.reference.observe(run.times)["z"]
    allowed = stepped.uncertainty["z"].max() * 2 * np.sqrt(run.steps)
    assert np.abs(run.observables["z"] - predicted).max() > 10 * allowed


@pytest.mark.parametrize("name", ["ode/dop853", "ode/radau", "ode/lsoda"])
def test_solvers_find_each_impact_and_the_rest_after_infinitely_many(name):
    """A restitution that is another by 1e-9 moves the ball a hundred times further than they do."""
    case = case_of(scene("bouncing-ball/to-rest"))
    how = method(name)
    ball = case.problem
    tolerance = how.step_sizes[-1]
    times = (run := measure(case, how, tolerance)[1]).times
    z = run.observables["z"]
    impacts_at = times[:-1][z[:-1] == 0.0]
    exact = ball.impacts(np.arange(1.0, 6.0))[0]  # after that absolute tolerances are flights
    np.testing.assert_allclose(impacts_at[:5], exact, 0, 20.0 * min(tolerance, 1e-12))
    left = (
        2.0 * np.sqrt(2.0 * tolerance * ball.height / ball.gravity) / (1.0 - ball.restitution)
    )
    # its last flights are wrong by some
    assert 0.0 < ball.zeno_time - impacts_at[-1] < 2.0 * left
    other = replace(ball, restitution=ball.restitution * (1.0 + 1e-9)).observe(times)["z"]
    if tolerance < 1e-10:
        assert np.abs(z - other).max() > 100.0 * np.abs(z - ball.observe(times)["z"]).max()
