"""The exact rotation of a free body: 45-digit integration, invariants, symmetries, limits."""

from pathlib import Path

import numpy as np
import pytest

from plumbob.analytic.numerics.arithmetic import ULP
from plumbob.analytic.numerics.elliptic.reciprocal_integral import ReciprocalIntegral
from plumbob.analytic.numerics.quad import double, quad
from plumbob.analytic.systems.free_body.problem import FreeBody
from plumbob.analytic.systems.free_body.rotation import ATTITUDE, RATES, compose_quaternions
from plumbob.tests.support.extrapolation import recorded

CASES = recorded(Path(__file__).with_name("recorded.json"))
NAMES = (*RATES, *ATTITUDE)


def seen(body, times):
    """All observables, shape (7, n)."""
    found = body.observe(np.atleast_1d(np.asarray(times, dtype=float)))
    return np.stack([found[name] for name in NAMES])


def errors(name, change=0.0):
    """The body of a recorded case, its first moment changed relatively, the times, and its errors
    beside the record, shape (7, n)."""
    case = CASES[name]
    x, y, z = case.constants
    body = FreeBody(x * (1 + change), y, z, case.start)
    at = np.array(case.times)
    return body, at, np.abs(seen(body, at) - np.array(case.states, dtype=float).T)


@pytest.mark.parametrize("name", CASES)
def test_45_digits_over_up_to_a_thousand_periods(name):
    # The bound: 1e-13 for each radian of phase, and what one unit in the last place of the inputs
    # does next to the separatrix, whose growth no arithmetic in double can take away.
    body, at, error = errors(name)
    conditioned = np.stack([body.uncertainty(at)[n] for n in NAMES])
    scale = np.array([[body.fastest]] * 3 + [[1.0]] * 4)
    assert (error <= np.maximum(1e-13 * (1.0 + body.fastest * at) * scale, conditioned)).all()
    assert (error <= conditioned + 4 * ULP * scale).all()  # what the reference itself claims


@pytest.mark.parametrize("name", ["about the smallest", "1e-6 off the separatrix"])
def test_uncertainty_is_not_excessive(name):
    # against each input changed alone, by much more than a unit in the last place: three times that
    # holds the roundings on the way and of the times too, which are as large as those of the inputs
    inputs = np.array([*CASES[name].constants, *CASES[name].start])
    at = np.linspace(0.0, 60.0, 241)
    change = 1e-11
    total = np.zeros((7, 241))
    x, y, z, *rates = inputs.tolist()
    body = FreeBody(x, y, z, rates)
    for moved in inputs * (1.0 + change * np.eye(6)):
        x, y, z, u, v, w = moved.tolist()
        total += np.abs(seen(FreeBody(x, y, z, (u, v, w)), at) - seen(body, at)) * ULP / change
    claimed = np.stack([body.uncertainty(at)[n] for n in NAMES])
    for said, found in zip(claimed, total, strict=True):
        assert 0.9 * found.max() < said.max() < 5.0 * found.max() + 1e-13


def test_on_the_separatrix_it_never_turns_over():
    body = FreeBody(1.0, 2.0, 2.25, (3.0, 0.0, 4.0))
    assert body.kind == "separatrix"
    last = seen(body, [400.0])[:3, 0]
    assert abs(last[1]) == pytest.approx(np.hypot(3.0, 9.0) / 2.0, rel=1e-15)  # |L|/I_y
    np.testing.assert_allclose(last[[0, 2]], 0.0, 0, 1e-100)
    # Long after, when the elliptic functions have left the range of doubles, it still turns about
    # its middle axis by |L|/I_y: half a turn between these times, whose rounding is 1e-12 s.
    later = 4000.0 + np.array([0.0, np.pi / abs(last[1])])
    before, after = seen(body, later)[3:].T
    half = np.array([[0.0], [0.0], [np.sign(last[1])], [0.0]])
    np.testing.assert_allclose(
        compose_quaternions(before[:, None], half)[:, 0], after, 0, 2e-12
    )


def test_the_third_kind_over_a_half_turn_is_that_over_its_quarters():
    for b in (0.9, 1e-3, 1e-12):
        f = quad(0.75)
        below = quad(0.25)
        integral = ReciprocalIntegral(quad(1.0), quad(b), f, below)
        whole = double(integral.over_half_turn)
        body = np.pi / 2 / float(_mean(1.0, b))
        quarter = integral.at(np.array([body]), quad(1.0))[0]
        assert whole == pytest.approx(2 * quarter, rel=1e-14)


def _mean(a, b):
    for _ in range(40):
        a, b = (a + b) / 2, float(np.sqrt(a * b))
    return a
