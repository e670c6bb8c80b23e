"""Rounding decides the steps of solvers that choose them: one ulp of the start moves their errors
at loose tolerances by more than 2 % and less than the factor of two within which they are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.registry import method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.known_sizes import FACTOR, SAME, known_within

ULPS = range(-3, 4)


@pytest.mark.parametrize(
    ("name", "how", "tolerance"),
    [
        ("cone-pendulum/fast-platform", "ode/dop853", 1e-6),
        ("simple-pendulum/free-large", "ode/dop853", 1e-5),
        ("simple-pendulum/rotating-slow", "ode/radau", 1e-3),
    ],
)
def test_an_ulp_of_the_start_moves_the_error(name: str, how: str, tolerance: float) -> None:
    swing, sizes = scene(name), []
    moved = next(n for n, x in swing.parameters.items() if n.startswith("theta") and x)
    for ulps in ULPS:
        value = swing.parameters[moved] + ulps * np.spacing(swing.parameters[moved])
        near = replace(swing, parameters={**swing.parameters, moved: value})
        run, _ = measure(case_of(near), method(how), tolerance)
        sizes.append(max(error.largest / error.scale for error in run.errors.values()))
    assert SAME < max(sizes) / min(sizes) < FACTOR
    assert known_within(method(how), None) == FACTOR
