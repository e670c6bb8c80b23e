"""Sensitivities, condition numbers and growth of errors along the driven rotor's motion."""

from dataclasses import fields, replace

import numpy as np
import pytest

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.analytic.numerics.rotor.variational import sensitivity
from plumbob.tests.support.linear_response import (
    condition,
    parameter_sensitivity,
)
from plumbob.tests.support.pendulum_cases import CASES, endpoint, motion

PARAMETERS = [field.name for field in fields(DrivenRotor)]


def nudged(case, field, by):
    """The case with one number of its start or of its rotor changed."""
    if hasattr(case, field):
        return replace(case, **{field: getattr(case, field) + by})
    return replace(case, rotor=replace(case.rotor, **{field: getattr(case.rotor, field) + by}))


@pytest.mark.parametrize("name", ["damped-rotating", "forced-large", "forced-chaotic", "cone"])
def test_sensitivities_are_central_differences(name):
    case = replace(CASES[name], duration=0.5 if name == "cone" else 10.0)
    given = (case.rotor, case.theta, case.theta_dot, np.array([case.duration]))
    derivatives = {field: rows[0] for field, rows in parameter_sensitivity(*given).items()}
    derivatives |= zip(("theta", "theta_dot"), sensitivity(*given)[0].T, strict=True)
    for field, derivative in derivatives.items():
        if not getattr(case.rotor, field, 1.0):
            continue
        above, below = (endpoint(nudged(case, field, by)) for by in (1e-5, -1e-5))
        # central differences: 1e-10 times a third derivative that grows as the cube of the first
        assert derivative == pytest.approx(
            (above - below) / 2e-5, rel=1e-5, abs=1e-5 * np.abs(derivative).max()
        )


def test_condition_adds_up_what_each_input_does():
    case = CASES["forced-large"]
    times = np.array([1.0, 7.0, 50.0])
    total = condition(case.rotor, case.theta, case.theta_dot, times)["theta"]
    by_parameter = parameter_sensitivity(case.rotor, case.theta, case.theta_dot, times)
    weighted = [np.abs(getattr(case.rotor, p) * by_parameter[p][:, 0]) for p in PARAMETERS]
    speed = motion(case).observe(times)["theta_dot"]
    assert total == pytest.approx(sum(weighted) + np.abs(times * speed), rel=1e-12)
