"""The pendulum where its motion has no period, or a degenerate one; and other results of the
solution: the time of an angle, momentum, phase, condition numbers, uncertainty."""

import math
from dataclasses import replace

import numpy as np
import pytest
from gmpy2 import mpfr
from scipy.integrate import solve_ivp

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.cone_pendulum import ConePendulum, solid_cone
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.tests.support.high_precision import orbit_of
from plumbob.tests.support.random_pendulums import pendulums

STEEL = ConePendulum(
    solid_cone(8000.0, 0.3, math.radians(30.0)), 0.0, 0.09, 26.0, 9.8, 0.0, 37.0
)
FLAT = replace(
    STEEL, body=solid_cone(8000.0, 0.3, math.radians(150.0)), pivot_y=0.0
)  # I_x < I_z

SEPARATRICES = {
    "over the only barrier": replace(STEEL, platform_rate=0.0, theta=0.3, theta_dot=1.0),
    "round both wells": replace(STEEL, theta=0.3, theta_dot=-1.0),
    "round, from the shallower well": replace(STEEL, theta=-1.2, theta_dot=1.0),
    "between two saddles": replace(FLAT, theta=0.2, theta_dot=1.0),
    "back between two saddles": replace(FLAT, theta=-0.2, theta_dot=-1.0),
    "over the top between two saddles": replace(FLAT, theta=3.0, theta_dot=-1.0),
    "without gravity": replace(FLAT, gravity=0.0, theta=0.2, theta_dot=-1.0),
    "from saddle to saddle at 0 and pi": replace(STEEL, pivot_y=0.0, gravity=0.0, theta=-4.0),
}


@pytest.mark.parametrize("case", SEPARATRICES)
def test_separatrix(case):
    pendulum = replace(SEPARATRICES[case], excess=0.0)
    motion = pendulum.motion
    orbit = orbit_of(pendulum)
    assert (motion.regime, motion.period, motion.mean_rate) == ("separatrix", math.inf, 0.0)
    assert math.isnan(motion.action)
    assert motion.period_condition == math.inf
    times = np.array([-0.3, -0.1, 0.0, 0.1, 0.2, 0.3])
    theta, theta_dot = motion.state(times)
    for time, x, v in zip(times, theta, theta_dot, strict=True):
        spent = orbit.over(mpfr(0), orbit.sense * (mpfr(x) - orbit.theta))[0]
        speed = orbit.speed(mpfr(x))
        assert abs(float((time - spent) * speed)) <= 1e-15 * (1 + abs(x))
        assert v == pytest.approx(orbit.sense * float(speed), rel=1e-13, abs=1e-13)
    # It tends to saddles, as exp(-rate t).
    ends, rates = motion.state(np.array([-1e5, 1e5]))
    saddles = np.array([e.theta for e in pendulum.equilibria if e.kind == "saddle"])
    gaps = 2 * np.abs(np.sin((ends[:, None] - saddles) / 2)).min(axis=1)
    assert gaps.max() <= 1e-15
    assert np.abs(rates).max() <= 1e-13
    assert np.sign(ends[1] - ends[0]) == orbit.sense
    assert np.isnan(motion.time_at(ends[1:] + orbit.sense * 0.1))
    late = times >= 0
    gaps = np.abs(motion.time_at(theta[late]) - times[late])
    assert (gaps * np.abs(theta_dot[late]) <= 1e-15 * (1 + np.abs(theta[late]))).all()


@pytest.mark.parametrize("index", range(11))
def test_time_of_an_angle(index):
    """theta(time_at(x)) = x, and no earlier time has it."""
    _, pendulum = list(pendulums(11, seed=3))[index]
    motion = pendulum.motion
    times = np.linspace(0.0, motion.period, 201)
    theta, _ = motion.closed_form.state(times)
    reached = motion.time_at(theta)
    again, rate = motion.closed_form.state(reached)
    span = 1.0 + np.abs(rate) * motion.period
    assert (np.abs(again - theta) <= 1e-14 * span).all()
    # At a turning point a rounding of the angle changes the time by its square root.
    rounding = np.sqrt(1e-15 * (1.0 + np.abs(theta)) / np.ptp(theta))
    assert (reached <= times + rounding * motion.period).all()
    assert np.isnan(motion.time_at(theta[:1] - 7.0 * np.sign(pendulum.theta_dot or 1.0))).all()


def test_momentum_and_phase():
    motion = replace(STEEL, theta_dot=-37.0).motion
    times = np.linspace(0.0, 0.5, 300)
    theta, theta_dot = motion.state(times)
    assert motion.momentum(theta) == pytest.approx(motion.inertia * theta_dot, rel=1e-13)
    assert motion.phase(np.array([motion.period])) == pytest.approx(2 * math.pi, rel=1e-15)
    assert np.isnan(replace(STEEL, theta_dot=5.0).motion.momentum(np.array([math.pi]))).all()


INPUTS = ("a", "b", "c", "inertia", "theta", "theta_dot")


def nudged(motion, name, by):
    """The motion with one input changed by the relative amount `by`, and all as doubles."""
    v = motion.potential
    values = {
        "a": double(v.a),
        "b": double(v.b),
        "c": double(v.c),
        "inertia": motion.inertia,
        "theta": motion.theta,
        "theta_dot": motion.theta_dot,
    }
    if name:
        values[name] *= 1 + by
    a, b, c = (values.pop(key) for key in "abc")
    return PendulumMotion(TrigonometricPotential(a, b, c), **values)


@pytest.mark.parametrize(
    "start", [(0.4, 37.0), (0.4, 5.0), (-1.2, 3.0), (-2.7, 0.5), (0.4, -20.5)]
)
def test_the_condition_number_is_that_of_finite_changes(start):
    motion = nudged(replace(STEEL, theta=start[0], theta_dot=start[1]).motion, "", 0.0)
    total = 0.0
    for which in INPUTS:
        more, less = (nudged(motion, which, by).period for by in (1e-6, -1e-6))
        total += abs(more - less) / 2e-6 / motion.period
    # Second derivatives over 1e-6, and round-off of 1e-15 over 1e-6.
    assert motion.period_condition == pytest.approx(total, rel=1e-5)


@pytest.mark.parametrize("excess", [1e-6, 1e-9])
def test_an_error_as_large_as_the_distance_from_the_barrier_is_not_small(excess):
    # Where the speed is smallest all kinetic energy is what the energy is above the barrier.
    motion = replace(STEEL, theta_dot=1.0, excess=excess).motion
    times = np.linspace(0.0, motion.period, 2001)
    slowest = times[[int(np.abs(motion.state(times)[1]).argmin())]]
    rate = motion.state(slowest)[1]
    errors = {"theta": np.zeros(1), "theta_dot": excess / (motion.inertia * rate)}
    assert motion.nonlinearity(slowest, errors) == pytest.approx(0.5, rel=0.05)
    small = {name: 1e-3 * error for name, error in errors.items()}
    assert motion.nonlinearity(slowest, small) == pytest.approx(5e-4, rel=0.05)


def test_uncertainty_is_not_excessive():
    times = np.array([0.5, 50.0])
    theta = STEEL.motion.uncertainty(times)["theta"]
    assert (theta <= 1e-13 * (1 + STEEL.motion.phase(times))).all()


EQUAL_WELLS = ConePendulum(
    solid_cone(8000.0, 0.3, math.radians(30.0)), 0.0, 0.0, 10.0, 9.8, 1e-3, 0.0
)  # next to the saddle between two equal wells


def responses_to_a_push(motion, times):
    """The first-order and the second-order part of the response of theta and theta_dot to a rate
    that is larger by 1 rad/s at the first of `times` [s], shapes (2, n), by variations."""
    v = motion.potential
    a, b, c = (float(double(part)) / motion.inertia for part in (v.a, v.b, v.c))

    def slopes(_, state):
        """The rates of the motion and of its first two variations."""
        theta, rate, first, first_rate, second, second_rate = state
        sine, cosine = math.sin(theta), math.cos(theta)
        stiffness = 2 * a * math.cos(2 * theta) - b * sine - c * cosine
        bending = -4 * a * math.sin(2 * theta) - b * cosine + c * sine
        bent = stiffness * second + bending * first**2
        return [
            rate,
            (2 * a * sine + b) * cosine - c * sine,
            first_rate,
            stiffness * first,
            second_rate,
            bent,
        ]

    theta, rate = motion.state(times[[0]])
    begin = [theta[0], rate[0], 0.0, 1.0, 0.0, 0.0]
    span = times[0], times[-1]
    # The ratios that are compared differ from their bounds by 10 % or more.
    states = solve_ivp(slopes, span, begin, "DOP853", times, rtol=1e-11, atol=1e-13).y
    return states[2:4], states[4:6] / 2.0


@pytest.mark.parametrize(
    ("pendulum", "turns"),
    [
        (EQUAL_WELLS, 2.8),
        (replace(STEEL, theta_dot=1.0, excess=1e-4), 1.5),
        (replace(STEEL, theta_dot=1.0, excess=-1e-4), 1.5),
    ],
    ids=["equal wells", "above the barrier", "below the barrier"],
)
def test_the_nonlinearity_bounds_the_second_order_response(pendulum, turns):
    """Next to a saddle a change of the energy changes the period, and the angle moves along the
    orbit: the second orders of both act on the same observables at once."""
    motion = pendulum.motion
    orbit = np.linspace(0.0, motion.period, 1001)
    fastest = orbit[np.abs(motion.state(orbit)[1]).argmax()]
    times = np.linspace(fastest, fastest + turns * motion.period, 2001)
    first, second = responses_to_a_push(motion, times)
    nonlinearity = motion.nonlinearity(
        times, dict(zip(("theta", "theta_dot"), first, strict=True))
    )
    largest = np.maximum.accumulate(np.abs(first), axis=1)
    ratio = (np.abs(second[:, 1:]) / largest[:, 1:]).max() / nonlinearity
    # The ratio is at most the bound and at least half of it: each effect adds half of its part or
    # more.
    assert 0.5 < ratio < 1.0
