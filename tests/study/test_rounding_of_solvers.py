"""Rounding decides the steps of solvers that choose them: a few ulps of the start move an error at
one tolerance by more than 2 %, and the median over tolerances by less than a factor of two."""

from dataclasses import replace

import numpy as np
import pytest

from plumbob.engines.registry import limits_of, method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.known_sizes import (
    FACTOR,
    SAME_VERSIONS_FACTOR,
    known_factor,
    tolerance_sizes_mismatch,
)

ULPS = (-4, 0, 4)


@pytest.mark.long(keep=2)
@pytest.mark.parametrize("how", ["ode/dop853", "ode/lsoda", "ode/radau"])
@pytest.mark.parametrize(
    "name", ["cone-pendulum/fast-platform", "simple-pendulum/rotating-slow"]
)
def test_ulps_of_the_start_move_single_errors_and_leave_their_median(name, how):
    swing = scene(name)
    known = limits_of(how).solvers[name, how]
    moved = next(n for n, x in swing.parameters.items() if n.startswith("theta") and x)
    spread = []
    for ulps in ULPS:
        value = swing.parameters[moved] + ulps * np.spacing(swing.parameters[moved])
        near = case_of(replace(swing, parameters={**swing.parameters, moved: value}))
        (quantity,) = near.system.quantities(near)
        runs = {tol: measure(near, method(how), tol, theory=False)[0] for tol in known}
        errors = {
            t: r.errors[quantity.observable].largest / quantity.scale for t, r in runs.items()
        }
        assert not tolerance_sizes_mismatch(known, errors)
        assert tolerance_sizes_mismatch(
            known, {tolerance: 2.5 * error for tolerance, error in errors.items()}
        )
        spread.append([errors[tolerance] for tolerance in known])
    assert np.max(np.max(spread, axis=0) / np.min(spread, axis=0)) > SAME_VERSIONS_FACTOR
    assert known_factor(method(how), None) == FACTOR
