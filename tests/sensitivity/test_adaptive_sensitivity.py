"""What the verdict on solvers that control their local error would notice, and how tight it is."""

import pytest

from plumbob.engines.registry import engine_of, installed, method
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of, scene

SWING = "simple-pendulum/free-large"


@pytest.mark.parametrize("solver", ["ode/dop853", "ode/radau", "ode/lsoda", "heyoka/taylor"])
def test_bounds_are_near_the_errors(solver):
    if not installed(engine_of(method(solver))):
        pytest.skip(f"{solver} is not installed: make peers")
    for error in measure(case_of(scene(SWING)), method(solver), 1e-6)[0].errors.values():
        assert error.largest <= error.controlled.largest < 3.0 * error.largest
