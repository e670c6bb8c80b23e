"""What the verdict on solvers that control their local error would notice, and how tight it is."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest

from plumbob.analytic.shared import Same, exactly
from plumbob.engines.registry import engine_of, installed, method
from plumbob.engines.study.measurement import Measurement, confirming, measure
from plumbob.models.registry import case_of, scene
from plumbob.reports.judge.verdict import judge

SOLVERS = ("ode/dop853", "ode/radau", "ode/lsoda", "heyoka/taylor")
SWING, TURN = "simple-pendulum/free-large", "cone-pendulum/rotating-base"


def run(name: str, solver: str, tolerance: float, **wrong: float) -> Measurement:
    """A run whose engine is given a wrong parameter, by a factor; its second run is, too."""
    how, chosen = method(solver), scene(name)
    if not installed(engine_of(how)):
        pytest.skip(f"{engine_of(how).package} is not installed: make peers")
    case = case_of(chosen)
    if wrong:
        changed = {key: chosen.parameters[key] * factor for key, factor in wrong.items()}
        case = replace(case, problem=case_of(scene(name, changed)).problem)
    return measure(case, how, tolerance)[0]


def verdict(found: Measurement, name: str, solver: str) -> str:
    return judge(found, case_of(scene(name)).system, method(solver)).verdict


@pytest.mark.long(keep=1)
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("name", "parameter"), [(SWING, "gravity"), (TURN, "platform_rate")])
def test_a_parameter_that_is_a_millionth_off_is_seen(
    name: str, parameter: str, solver: str
) -> None:
    tightest = method(solver).step_sizes[-1]
    assert verdict(run(name, solver, tightest), name, solver) == "predicted"
    wrong = run(name, solver, tightest, **{parameter: 1 + 1e-6})
    assert verdict(wrong, name, solver) == "off-prediction"


@pytest.mark.parametrize("solver", ["ode/dop853", "ode/lsoda", "heyoka/taylor"])
def test_at_the_smallest_tolerances_a_billionth_is_seen(solver: str) -> None:
    wrong = run(SWING, solver, method(solver).step_sizes[-1], gravity=1 + 1e-9)
    assert verdict(wrong, SWING, solver) == "off-prediction"


@pytest.mark.parametrize("solver", SOLVERS)
def test_bounds_are_near_the_errors(solver: str) -> None:
    found = run(SWING, solver, 1e-6)
    for error in found.errors.values():
        assert error.controlled is not None
        assert error.largest <= error.controlled.largest < 3.0 * error.largest


def test_a_second_run_that_is_no_better_bounds_nothing() -> None:
    case, how = case_of(scene(SWING)), method("ode/dop853")
    same = measure(case, how, 1e-8)[1]
    held, _ = measure(case, how, 1e-8, lambda: same)
    assert judge(held, case.system, how).verdict == "off-prediction"
    left, _ = measure(case, how, 1e-8, lambda: None)
    assert judge(left, case.system, how).verdict == "pre-asymptotic"


def test_the_second_run_is_the_most_exact_of_its_engine() -> None:
    case = case_of(scene(SWING))
    second = confirming(case, method("ode/radau"))
    assert second is not None
    off = second.observables["theta"] - case.reference.observe(second.times)["theta"]
    assert np.abs(off).max() < 1e-10


def test_methods_share_what_they_are_held_to() -> None:
    case = case_of(scene("simple-pendulum/free-small"))
    radau, lsoda = (confirming(case, method(f"ode/{name}")) for name in ("radau", "lsoda"))
    assert radau is lsoda
    assert confirming(case.lasting(1.0), method("ode/radau")) is not radau
    exact, times = case.reference, np.linspace(0.0, 1.0, 3).tobytes()
    assert exactly(Same(exact), times) is exactly(Same(exact), times)
    assert Same(exact) != Same(copy.copy(exact))
