"""A pendulum released next to its top, by the complement of its angle: the exact motion against 40
digits, scipy's functions for comparison, and the start of engines that store the angle as a
double."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scipy.special
from gmpy2 import mpfr

from plumbob.analytic.parameters import ParameterError
from plumbob.analytic.reference import Array
from plumbob.analytic.systems.simple_pendulum import SimplePendulum
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, system_of
from plumbob.models.registry import scene as find_scene
from plumbob.tests.support.high_precision import PI, Orbit

ULP = 2.0**-52
EXACT = 1e-12  # required of the period, relative, and of theta(t), times its condition number


def problem(name: str, **changes: Any) -> SimplePendulum:
    """The problem of a scene of the simple pendulum, with parameters changed."""
    scene = find_scene(f"simple-pendulum/{name}", changes)
    found = system_of(scene).problem(scene.parameters)
    assert isinstance(found, SimplePendulum)
    return found


def independent(given: SimplePendulum, off: float = 0.0) -> Orbit:
    """The same pendulum in 60 digits, its distance from the top a relative `off` wrong."""
    distance = mpfr(given.theta_from_top) * (1 + mpfr(off))
    return Orbit(mpfr(0), mpfr(0), mpfr(given.gravity), mpfr(given.length), PI + distance, mpfr(0))


def misses(given: SimplePendulum, orbit: Orbit) -> tuple[float, float]:
    """Relative error of the period, and the largest error of theta over its condition number."""
    motion = given.elliptic
    assert motion is not None
    times = motion.period * np.array([0.24, 0.77, 7.3])
    theta, rate = motion.closed_form.state(times)
    period, _, states = orbit.follow(times.tolist(), list(zip(theta, rate, strict=True)))
    gaps = np.array([float(x - state[0]) for x, state in zip(theta, states, strict=True)])
    condition = motion.uncertainty(times)["theta"] / ULP
    return abs(float(motion.period / period - 1)), float((np.abs(gaps) / condition).max())


@pytest.mark.long(keep=4)
@pytest.mark.parametrize("k", range(1, 13))
def test_against_forty_digits(k: int) -> None:
    given = problem(f"near-top-1e-{k}")
    assert given.theta_from_top == -float(f"1e-{k}")
    period, theta = misses(given, independent(given))
    assert period <= EXACT
    # far below the requirement: no more than the effect of an ulp of every input
    assert theta <= ULP < EXACT


@pytest.mark.parametrize("k", [1, 6, 12])
def test_a_complement_error_of_1e_9_is_detected(k: int) -> None:
    # The period depends on ln of the distance: at least 1/28 of the relative change shows. Theta's
    # condition number adds up eight inputs, of which this is one.
    given = problem(f"near-top-1e-{k}")
    assert min(misses(given, independent(given, off=1e-9))) > EXACT


def by_scipy(theta: float, rate: float, times: Array) -> tuple[Array, float]:
    """theta(t) from rest at `theta` in (0, pi) by the textbook formula with scipy's functions, and
    the period: 2 arcsin(k sn(K - w t, m)), m = k^2 = sin^2(theta/2)."""
    parameter = math.sin(theta / 2) ** 2
    quarter = float(scipy.special.ellipk(parameter))
    sn = scipy.special.ellipj(quarter - rate * times, parameter)[0]
    return 2 * np.arcsin(math.sqrt(parameter) * sn), 4 * quarter / rate


@pytest.mark.parametrize(
    # smallest error of theta [rad] over a period: as measured, rounded down to a power of ten
    ("k", "angle"),
    [(2, 1e-13), (3, 1e-11), (4, 1e-10), (5, 1.0), (6, 1.0), (7, 1.0)],
)
def test_scipy_is_less_accurate(k: int, angle: float) -> None:
    motion = problem(f"near-top-1e-{k}").elliptic
    assert motion is not None
    times = np.linspace(0.0, motion.period, 201)
    theta, _ = by_scipy(math.pi - 10.0**-k, math.sqrt(9.8), times)
    assert np.abs(theta - motion.observe(times)["theta"]).max() > angle


def test_scipy_loses_the_parameter_to_rounding() -> None:
    # m = sin^2(theta/2) rounds to 1 from here on, and the quarter period is infinite
    assert not np.isfinite(by_scipy(math.pi - 1e-8, math.sqrt(9.8), np.zeros(1))[1])


@pytest.mark.parametrize("k", [1, 6, 9, 12])
@pytest.mark.parametrize("method", ["mujoco/rk4", "ode/leapfrog", "ode/dop853", "pymunk/tight"])
def test_engines_start_at_the_nearest_double(k: int, method: str) -> None:
    scene, how = find_scene(f"simple-pendulum/near-top-1e-{k}"), find_method(method)
    step = 1e-12 if how.control == "tolerance" else 2e-3
    run = engine_of(how).prepare(case_of(scene), how, step).run()
    theta = float(run.observables["theta"][0])
    wanted = float(PI - mpfr(f"{10.0**-k!r}"))
    assert theta == wanted == problem(f"near-top-1e-{k}").started.theta


def test_the_error_bar_covers_rounding_of_the_start() -> None:
    # The error of an integrator of accuracy 1e-15 is this one; at 1e-12 it is 4.2e-4 rad.
    pytest.importorskip("heyoka")
    for k, size in ((6, 3.6e-10), (9, 4.1e-7), (12, 4.2e-4)):
        scene, how = find_scene(f"simple-pendulum/near-top-1e-{k}"), find_method("heyoka/taylor")
        error = measure(case_of(scene), how, 1e-15)[0].errors["theta"]
        assert error.largest == pytest.approx(size, rel=0.15)
        assert error.largest < error.uncertainty < 10 * error.largest


def test_theta_and_its_complement_are_interchangeable() -> None:
    near, far = problem("near-top-1e-3"), problem("free-large", theta_from_top=-1e-3)
    assert near.elliptic.period == far.elliptic.period  # type: ignore[union-attr]
    back = problem("near-top-1e-3", theta=-2.0)
    assert (back.theta, back.theta_from_top, back.started) == (-2.0, None, back)
    rest = problem("free-large", theta_from_top=0.0)
    assert rest.elliptic is not None
    assert rest.elliptic.regime == "rest"


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("simple-pendulum/free-large", {"theta": 1.0, "theta_from_top": 1e-3}),
        ("simple-pendulum/free-large", {"theta_from_top": None}),
        ("simple-pendulum/free-large", {"theta_from_top": math.nan}),
        ("simple-pendulum/free-large", {"theta_from_top": 1e-3, "gravity": 0.0}),
        ("simple-pendulum/damped-large", {"theta_from_top": 1e-3}),
        ("simple-pendulum/forced-large", {"theta_from_top": 1e-3}),
        ("linear-pendulum/free-large", {"theta_from_top": 1e-3}),
    ],
)
def test_an_undefined_complement_is_refused(name: str, changes: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match="theta_from_top"):
        find_scene(name, changes)
