"""The fitted order: exact powers are recovered, noise widens the interval, round-off is left
out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plumbob.engines.study.order import fit_order

STEPS = 0.1 / 2.0 ** np.arange(8)


@given(st.floats(0.5, 8.0), st.floats(-8.0, 2.0))
def test_an_exact_power_is_recovered(order, size):
    found = fit_order(STEPS, 10.0**size * STEPS**order, np.zeros(8))
    # linregress on eight exact points: round-off of logarithms, some 1e-15 of 20, over a span of 3
    assert found.slope == pytest.approx(order, abs=1e-12)
    assert found.high - found.low < 1e-6


def test_round_off_is_left_out_and_would_bias_the_fit():
    floor = 1e-9
    errors = np.maximum(STEPS**4, floor)
    clean = fit_order(STEPS, errors, np.full(8, floor))
    dirty = fit_order(STEPS, errors, np.zeros(8))
    assert clean.slope == pytest.approx(4.0, abs=1e-9)
    assert abs(dirty.slope - 4.0) > 0.5


@pytest.mark.long
@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=6))
def test_the_interval_is_the_one_of_a_regression(noise):
    from scipy.stats import linregress  # takes a second: one process imports it, and not each
    from scipy.stats import t as student

    steps = STEPS[: len(noise)]
    errors = steps**2 * np.exp(noise)
    found = fit_order(steps, errors, np.zeros(len(noise)))
    fit = linregress(np.log(steps), np.log(errors))
    assert found.slope == pytest.approx(fit.slope, abs=1e-12)
    margin = student.ppf(0.975, len(noise) - 2) * fit.stderr
    assert found.high - found.slope == pytest.approx(margin, rel=1e-9, abs=1e-7)
    assert found.slope - found.low == pytest.approx(margin, rel=1e-9, abs=1e-7)


@pytest.mark.parametrize("errors", [[1.0, 0.5, 0.25], [np.nan] * 8, [0.0] * 8])
def test_too_little_to_fit(errors):
    assert fit_order(STEPS[: len(errors)], errors, np.zeros(len(errors))) is None
