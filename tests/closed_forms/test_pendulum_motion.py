"""The closed form of the pendulum against 40-digit quadrature, in every regime.

Bounds are those of double precision: the set-up has 34 digits, so that condition numbers, which
would allow larger errors, do not enter.
"""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from gmpy2 import mpfr

from plumbob.analytic.numerics.elliptic.trigonometric_potential import TrigonometricPotential
from plumbob.analytic.numerics.quad import double
from plumbob.analytic.systems.cone_pendulum import ConePendulum, solid_cone
from plumbob.analytic.systems.pendulums.pendulum_motion import PendulumMotion
from plumbob.tests.support.high_precision import Orbit, orbit_of, started
from plumbob.tests.support.random_pendulums import REGIMES, pendulums

EACH = {"quick": 9, "full": 28}  # of every regime, by profile
PERIODS = np.array([0.31, -1.7, 50.3])  # after the start
# Rounded once from 34 digits: 1.1e-16 in theory.
PERIOD = 1e-15
# A mean of up to 2^16 samples, each with an error of some units in the last place.
ACTION = 1e-14
# Relative to 1 rad and the phase; for the rate relative to the largest in the orbit, and for the
# table's, which forces in double make, to that of a turn by 1 rad. Round-off of a time in a period
# as long as ln(1e12) is 1e-14.
ANGLE = 1e-13

STEEL = ConePendulum(
    solid_cone(8000.0, 0.3, math.radians(30.0)), 0.0, 0.09, 26.0, 9.8, 0.0, 37.0
)
FLAT = replace(STEEL, body=solid_cone(8000.0, 0.3, math.radians(150.0)))  # I_x < I_z
LEVEL = replace(STEEL, pivot_y=0.0)
PITCHFORK = LEVEL.pitchfork_rate
SIMPLE = TrigonometricPotential(0.0, 0.0, 9.8)


def errors(motion, orbit, times):
    """Errors of a motion of finite period, each over its bound, closed form and table alike."""
    theta, theta_dot = motion.closed_form.state(times)
    tabled = (motion.table or motion).state(times)  # none of a period that is too long
    period, action, states = orbit.follow(
        times.tolist(), list(zip(theta, theta_dot, strict=True))
    )
    fastest = np.abs(motion.closed_form.state(np.linspace(0.0, motion.period, 200))[1]).max()
    allowed = ANGLE * (1.0 + np.abs(motion.phase(times)))
    uncertain = motion.uncertainty(times)

    def worst(values, which, scale):
        gaps = [float(x - state[which]) for x, state in zip(values, states, strict=True)]
        return float((np.abs(gaps) / scale).max())

    return {
        "period": abs(float(motion.period / period - 1)) / PERIOD,
        "action": abs(float(motion.action / action - 1)) / ACTION,
        "theta": worst(theta, 0, allowed),
        "theta_dot": worst(theta_dot, 1, allowed * fastest),
        "theta of the table": worst(tabled[0], 0, allowed),
        "theta_dot of the table": worst(
            tabled[1], 1, allowed * (fastest + motion.rotor.rate())
        ),
        "theta over its uncertainty": worst(theta, 0, uncertain["theta"]),
        "theta_dot over its uncertainty": worst(theta_dot, 1, uncertain["theta_dot"]),
    }


def assert_exact(motion, orbit, times=None):
    times = PERIODS * motion.period if times is None else times
    found = errors(motion, orbit, times)
    assert max(found.values()) <= 1.0, (motion, found)


def simple(theta, theta_dot, **given):
    """A simple pendulum and its independent method."""
    motion = PendulumMotion(SIMPLE, 1.0, theta, theta_dot, **given)
    orbit = Orbit(mpfr(0), mpfr(0), mpfr(9.8), mpfr(1), mpfr(theta), mpfr(theta_dot))
    return motion, started(orbit, given.get("excess"), given.get("theta_from_top"))


@cache
def drawn(each):
    return tuple(pendulums(each * len(REGIMES)))


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("regime", REGIMES)
def test_random_parameters(regime, pytestconfig):
    for name, pendulum in drawn(EACH[pytestconfig.getoption("profile")]):
        if name == regime:
            assert_exact(pendulum.motion, orbit_of(pendulum))


@pytest.mark.long(keep=6)
@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["above", "below"])
@pytest.mark.parametrize(
    "pendulum", [STEEL, LEVEL, FLAT], ids=["two wells", "equal wells", "flat"]
)
@pytest.mark.parametrize("k", [3, 6, 9, 12, 20])
def test_next_to_the_highest_barrier(pendulum, sign, k):
    height = double(pendulum.motion.barriers[0]) or 1.0
    near = replace(pendulum, theta=0.3, theta_dot=-1.0, excess=sign * 10.0**-k * abs(height))
    assert_exact(near.motion, orbit_of(near))


@pytest.mark.long(keep=8)
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("k", range(1, 13))
@pytest.mark.parametrize("name", ["excess", "theta_from_top"])
def test_simple_pendulum_next_to_its_top(name, k, sign):
    """By its energy, and released at pi - 10^-k, by its complement."""
    if name == "excess":
        assert_exact(*simple(0.1, 2.0, excess=sign * 19.6 * 10.0**-k))
    else:
        assert_exact(*simple(math.pi, 0.0, theta_from_top=-sign * 10.0**-k))


HARD = {
    **{
        f"pitchfork, {x:g}": replace(LEVEL, platform_rate=PITCHFORK, theta=x, theta_dot=0.0)
        for x in (1.0, 1e-1, 1e-2, 1e-4)
    },
    **{
        f"pitchfork, rate {r:g}, pivot {y:g}": replace(
            LEVEL, platform_rate=PITCHFORK * r, pivot_y=y, theta=0.3, theta_dot=0.5
        )
        for r in (0.999999, 1.000000001, 1.00001)
        for y in (0.0, 1e-12, 1e-9, 1e-6)
    },
    **{
        f"equal wells, {x:g}": replace(LEVEL, theta=x, theta_dot=0.0)
        for x in (0.1, -0.1, 1e-6, 1.5, 3.0, 3.1415926)
    },
    **{
        f"let go at {x:g}": replace(STEEL, theta=x, theta_dot=0.0)
        for x in (-2.9, -2.0, -1.0, -0.5, 0.0, 0.7, 2.0, 3.0, 100.0)
    },
    **{f"start at {x:g}": replace(STEEL, theta=x) for x in (100.0, -55.5)},
    **{
        f"small swing of {x:g}": replace(LEVEL, platform_rate=3.0, theta=x, theta_dot=0.0)
        for x in (1e-4, 1e-8, 1e-12)
    },
    **{f"no gravity, pivot {y:g}": replace(STEEL, gravity=0.0, pivot_y=y) for y in (0.0, 0.05)},
    "flat, no gravity": replace(FLAT, gravity=0.0, pivot_y=0.0, theta_dot=5.0),
    "still platform": replace(STEEL, platform_rate=0.0, theta_dot=13.0),
    "1000 rad/s": replace(STEEL, platform_rate=1000.0, theta=0.3),
}


@pytest.mark.parametrize("case", HARD)
def test_hard_case(case):
    assert_exact(HARD[case].motion, orbit_of(HARD[case]))


@pytest.mark.parametrize("change", ["a", "b", "c", "inertia"])
@pytest.mark.parametrize("theta_dot", [37.0, 5.0])
def test_a_change_of_2e_11_is_detected(change, theta_dot):
    pendulum = replace(STEEL, theta_dot=theta_dot)
    orbit = orbit_of(pendulum)
    orbit = replace(orbit, **{change: getattr(orbit, change) * mpfr("1.00000000002")})
    found = errors(pendulum.motion, orbit, PERIODS * pendulum.motion.period)
    for name in ("period", "action", "theta", "theta_dot"):
        assert found[name] > 1.0, name


@pytest.mark.parametrize("excess", [None, 0.0, -19.6], ids=["turns", "separatrix", "rest"])
def test_many_times_have_the_digits_of_few(excess):
    motion = PendulumMotion(SIMPLE, 1.0, 0.0, 7.0, excess)
    some = np.s_[::10_007]
    times = np.linspace(0.0, 1e9, 50_001)
    for name, values in motion.observe(times).items():
        gaps = values[some] - motion.observe(times[some])[name]
        assert (np.abs(gaps) <= ANGLE * (1 + np.abs(values[some]))).all()
