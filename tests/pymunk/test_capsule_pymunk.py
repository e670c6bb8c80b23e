"""The capsule in pymunk: on feet and from the side errors are as predicted, on bare pivots they are
not."""

import pytest

from plumbob.engines.adapters.pymunk import capsule
from plumbob.tests.support.pymunk_capsule import (
    GOOD,
    METHODS,
    last,
    problem_of,
)
from plumbob.tests.support.random_capsules import LINE


@pytest.mark.parametrize("model", GOOD)
def test_model_error_bounds_are_small(model):
    # Less than the sawtooth's largest value, so that a fault of the size of the step's error is
    # detected: 50 iterations with one sticking foot leave 2 % of the velocity change at the stop,
    # contacts leave nothing.
    part = {"feet": 0.6, "side": 1e-3}[model]
    for step in (1e-3, 1e-4):
        bounds = capsule.model_error(problem_of(LINE), 0.15, METHODS[model], step)
        assert sum(bounds["displacement"].values()) < part * LINE.closed.braking * step**2 / 8


def test_drift_in_ten_seconds():
    # Required: 1e-6 m at 0.999 of the threshold; pivots slide away.
    for model, most in (("feet", 1e-15), ("side", 1e-15)):
        assert abs(last("capsule-hold/0.999", model, 1e-3)) < most
    assert last("capsule-hold/0.999", "pivots", 1e-3) > 1.0
