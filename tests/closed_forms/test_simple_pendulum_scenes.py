"""The simple pendulum's scenes: references, facts, and parameters that are allowed."""

import numpy as np
import pytest

from plumbob.analytic.schemes import RK4, Scheme
from plumbob.models.registry import case_of
from plumbob.models.registry import scene as find_scene

SIMPLE, LINEAR = "simple-pendulum/", "linear-pendulum/"


def test_an_error_that_is_not_small_is_reported():
    # the response is nonlinear in proportion to the error
    case, linear = (case_of(find_scene(f"{name}damped-rotating")) for name in (SIMPLE, LINEAR))
    times = np.linspace(0.0, 20.0, 400)
    errors = case.errors.series(Scheme(RK4), times)[4]
    small, large = (
        case.reference.nonlinearity(times, {n: part * e for n, e in errors.items()})
        for part in (1e-6, 1e-5)
    )
    assert 0.0 < small == pytest.approx(large / 10, rel=1e-3)
    assert linear.reference.nonlinearity(times, dict(errors)) == 0.0
