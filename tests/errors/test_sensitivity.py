"""Sensitivities, condition numbers and growth of errors along the driven rotor's motion."""

from dataclasses import fields

import numpy as np
import pytest

from plumbob.analytic.numerics.rotor.driven_rotor import DrivenRotor
from plumbob.tests.support.linear_response import (
    condition,
    parameter_sensitivity,
)
from plumbob.tests.support.pendulum_cases import CASES, motion

PARAMETERS = [field.name for field in fields(DrivenRotor)]


def test_condition_adds_up_what_each_input_does():
    case = CASES["forced-large"]
    times = np.array([1.0, 7.0, 50.0])
    total = condition(case.rotor, case.theta, case.theta_dot, times)["theta"]
    by_parameter = parameter_sensitivity(case.rotor, case.theta, case.theta_dot, times)
    weighted = [np.abs(getattr(case.rotor, p) * by_parameter[p][:, 0]) for p in PARAMETERS]
    speed = motion(case).observe(times)["theta_dot"]
    assert total == pytest.approx(sum(weighted) + np.abs(times * speed), rel=1e-12)
