"""Error coefficients and energy drift of fixed-step schemes against the schemes themselves."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ellipk

from plumbob.analytic.errors.smooth_motion.rotor_errors import RotorErrors
from plumbob.analytic.errors.smooth_motion.stepped_rotor import error_orders
from plumbob.analytic.left_open import by_rounding, by_series
from plumbob.analytic.schemes import EULER, LEAPFROG, RK4, Scheme
from plumbob.analytic.systems.pendulums.driven_motion import DrivenMotion
from plumbob.models.registry import case_of, scene
from plumbob.tests.support.fixed_step import run
from plumbob.tests.support.pendulum_cases import CASES, GRAVITY, motion

NAMES = ("theta", "theta_dot")
FREE = (Scheme(EULER), Scheme(EULER, position_first=True), Scheme(LEAPFROG), Scheme(RK4))
DAMPED = (Scheme(EULER), Scheme(EULER, implicit_damping=True), Scheme(LEAPFROG), Scheme(RK4))
HELD = (
    Scheme(RK4, "start"),
    Scheme(RK4, "midpoint"),
    Scheme(EULER, "midpoint"),
    Scheme(LEAPFROG, "start"),
)
PAIRS = [
    *((name, scheme) for name in ("free-large", "rotating-slow", "cone") for scheme in FREE),
    *((name, scheme) for name in ("damped-large", "damped-rotating") for scheme in DAMPED),
    *(
        (name, scheme)
        for name in ("forced-large", "forced-chaotic")
        for scheme in DAMPED + HELD
    ),
]


def start(case):
    """Theta and theta_dot at time 0."""
    return case.theta, case.theta_dot


def errors(case, scheme, steps, samples=100):
    """Step, times and the scheme's error there, from its start to the case's end."""
    step = case.duration / steps
    found = run(case.rotor, case.theta, case.theta_dot, step, steps, scheme)
    times = np.linspace(0.0, case.duration, steps + 1)[:: steps // samples]
    exact = DrivenMotion(case.rotor, case.theta, case.theta_dot).observe(times)
    return (
        step,
        times,
        {q: x[:: steps // samples] - exact[q] for q, x in zip(NAMES, found, strict=True)},
    )


def remainders(case, scheme, steps, rotor, terms=2):
    """Largest error of theta and theta_dot, and largest rest after one, two ... terms of the
    expansion made for `rotor`; shape (terms + 1, 2)."""
    step, times, error = errors(case, scheme, steps)
    coefficients = RotorErrors(rotor, *start(case), terms=terms).series(scheme, times)
    left = dict(error)
    found = [[np.abs(error[q]).max() for q in NAMES]]
    for order in sorted(coefficients):
        left = {q: left[q] - step**order * coefficients[order][q] for q in NAMES}
        found.append([np.abs(left[q]).max() for q in NAMES])
    return np.array(found)


@pytest.mark.long(keep=12)
@pytest.mark.parametrize(("name", "scheme"), PAIRS)
def test_the_coefficients_make_up_the_error(name, scheme):
    case = replace(CASES[name], duration=0.5 if name == "cone" else 5.0)
    # the error far above round-off
    steps = 2000 if error_orders(scheme, case.rotor, 1)[0] == 1 else 200
    error, _, second, _, fourth = remainders(case, scheme, steps, case.rotor, terms=4)
    assert np.all(second < 0.02 * error)  # two orders predict the error to 2 %
    # and the remainder consists of the next two orders: no term is missing or counted twice
    assert np.all(fourth < 0.1 * second + 1e-14 * steps)


@pytest.mark.parametrize("scheme", [Scheme(RK4), Scheme(EULER)], ids=str)
@pytest.mark.parametrize("step", [pytest.param(2e-4, marks=pytest.mark.rare), 5e-4])
def test_a_stiff_motion_that_follows_a_slow_command_has_a_series(scheme, step):
    # The damping forgets rounding within some milliseconds. The series therefore has terms that
    # are far smaller than rounding that adds up over three seconds.
    stiff_servo = case_of(scene("linear-pendulum/stiff-servo"))
    times = np.linspace(0.0, 3.0, 301)
    stepped = stiff_servo.errors.at_step(scheme, step, times)
    coefficients = stiff_servo.errors.series(scheme, times)
    for name in NAMES:
        terms = [c[name] * step**power for power, c in sorted(coefficients.items())]
        left = np.abs(stepped.errors[name] - sum(terms))
        rounding = by_rounding(stepped.uncertainty[name], round(3.0 / step))
        assert np.all(left <= by_series(terms) + rounding)


def period(case):
    """Period of an undamped simple pendulum that starts at rest or turns over."""
    g = case.rotor.sin
    m = math.sin(case.theta / 2) ** 2 + case.theta_dot**2 / (4 * g)
    if m < 1:
        return float(4 * ellipk(m) / math.sqrt(g))
    return float(2 * ellipk(1 / m) / math.sqrt(g * m))


CONE_PERIOD = 0.16006944027755794  # physics.md, correct Hamiltonian, theta_dot(0) = 37


@pytest.mark.parametrize(
    "name", ["free-small", "free-large", "rotating-slow", "rotating-fast", "cone"]
)
def test_rk4_loses_energy_at_the_averaged_rate(name):
    case = CASES[name]
    turn = CONE_PERIOD if name == "cone" else period(case)
    rates = RotorErrors(case.rotor, *start(case)).energy_drift_rate(turn, Scheme(RK4))
    # A pendulum's motion is symmetric under time reversal, so that even powers vanish. That of a
    # cone that rotates in a potential without mirror symmetry is not: its energy drifts with h^4
    # already.
    assert (rates[4] == 0.0) == (name != "cone")
    assert rates[5] < 0.0
    per_turn, turns = 120, 300
    step = turn / per_turn
    x, v = run(case.rotor, case.theta, case.theta_dot, step, per_turn * turns, Scheme(RK4))
    energy = case.rotor.energy(x, v)[::per_turn]
    measured = float(energy[-1] - energy[0]) / (turns * turn)
    # The remainder: h^8, the change of the orbit itself over 300 turns, round-off of 1e-16 a step:
    # 9e-5 of the drift at most. A coefficient that is 1e-3 off is seen.
    assert sum(rate * step**p for p, rate in rates.items()) == pytest.approx(measured, rel=3e-4)


@pytest.mark.parametrize("scheme", [Scheme(LEAPFROG), Scheme(EULER)])
@pytest.mark.parametrize("name", ["free-large", "rotating-slow", "cone"])
def test_symplectic_schemes_have_no_drift(name, scheme):
    case = CASES[name]
    turn = CONE_PERIOD if name == "cone" else period(case)
    rates = RotorErrors(case.rotor, *start(case)).energy_drift_rate(turn, scheme)
    assert rates
    assert not any(rates.values())


@pytest.mark.parametrize("name", ["free-large", "rotating-fast", "cone"])
def test_the_error_of_euler_is_half_the_acceleration_at_both_ends(name):
    case = replace(CASES[name], duration=0.5)
    times = np.linspace(0.0, 0.5, 21)
    rotor = case.rotor
    theta = case.theta
    theta_dot = case.theta_dot
    exact = motion(case).observe(times)
    theory = RotorErrors(rotor, theta, theta_dot)
    lead = theory.series(Scheme(EULER), times)[1]
    by_rate = theory.motion.tangents(times)[:, :, 1]
    first = 0.5 * rotor.acceleration(0.0, theta, theta_dot)
    last = 0.5 * rotor.acceleration(times, exact["theta"], exact["theta_dot"])
    # semi-implicit Euler is leapfrog with the rate read half a step late, at both ends
    assert lead["theta"] == pytest.approx(first * by_rate[:, 0], rel=1e-7, abs=1e-9)
    assert lead["theta_dot"] == pytest.approx(first * by_rate[:, 1] - last, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("scheme", FREE)
def test_a_gravity_error_of_two_percent_spoils_the_prediction(scheme):
    case = replace(CASES["free-large"], duration=5.0)
    wrong = replace(case.rotor, sin=1.02 * GRAVITY)
    steps = 200 if scheme.integrator == RK4 else 4000
    for rotor, spoilt in ((case.rotor, False), (wrong, True)):
        error, _, rest = remainders(case, scheme, steps, rotor)
        assert np.any(rest > 0.02 * error) == spoilt
