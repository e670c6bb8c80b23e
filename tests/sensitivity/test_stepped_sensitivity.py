"""Small mistakes at steps that no series reaches fail the verdict, as they do at small steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import pytest

from plumbob.analytic.errors.schemes import Scheme
from plumbob.analytic.errors.theory import Coefficients, ErrorTheory, SteppedErrors
from plumbob.analytic.reference import Array, Reference
from plumbob.engines.method import Method, meant
from plumbob.engines.registry import engine_of
from plumbob.engines.registry import method as find_method
from plumbob.engines.registry import methods as find_methods
from plumbob.engines.study.measurement import measure
from plumbob.models.registry import case_of as case_of_scene
from plumbob.models.registry import scene as find_scene
from plumbob.models.scene import Case
from plumbob.reports.judge.verdict import judge

SLOW, TOP = "simple-pendulum/rotating-slow", "simple-pendulum/near-top-1e-6"
DAMPED, BARRIER = "simple-pendulum/damped-rotating", "cone-pendulum/above-barrier-1e-6"














@dataclass(frozen=True)
class Altered:
    """An `ErrorTheory` that only steps, and whose predictions are altered."""

    theory: ErrorTheory
    exact: Reference
    change: Callable[[ErrorTheory, Reference, Scheme, float, Array], SteppedErrors]

    def series(self, scheme: Scheme, times: Array) -> Coefficients:
        """Empty."""
        return {}

    def at_step(self, scheme: Scheme, step: float, times: Array) -> SteppedErrors:
        """The altered prediction."""
        return self.change(self.theory, self.exact, scheme, step, times)


def as_it_is(
    theory: ErrorTheory, exact: Reference, scheme: Scheme, step: float, times: Array
) -> SteppedErrors:
    """What theory predicts."""
    return theory.at_step(scheme, step, times)


def flipped(
    theory: ErrorTheory, exact: Reference, scheme: Scheme, step: float, times: Array
) -> SteppedErrors:
    """The same with the other sign."""
    found = theory.at_step(scheme, step, times)
    return replace(found, errors={name: -error for name, error in found.errors.items()})


def late(
    theory: ErrorTheory, exact: Reference, scheme: Scheme, step: float, times: Array
) -> SteppedErrors:
    """What is predicted for one step later."""
    found = theory.at_step(scheme, step, times + step)
    here, there = exact.observe(times), exact.observe(times + step)
    return replace(found, errors={n: e + there[n] - here[n] for n, e in found.errors.items()})


@pytest.mark.long(keep=4)
@pytest.mark.parametrize(
    ("change", "wanted"), [(as_it_is, "pass"), (flipped, "fail"), (late, "fail")]
)
@pytest.mark.parametrize(
    ("name", "method", "step"),
    [
        (SLOW, "mujoco/euler", 1e-2),
        (SLOW, "pymunk/default", 1e-2),
        (SLOW, "ode/rk4", 1e-2),  # where the series reaches the step, both agree
        (BARRIER, "ode/leapfrog", 1e-3),
        ("linear-pendulum/forced-large", "mujoco/discrete", 1e-3),
    ],
)
def test_a_prediction(
    name: str,
    method: str,
    step: float,
    change: Callable[[ErrorTheory, Reference, Scheme, float, Array], SteppedErrors],
    wanted: str,
) -> None:
    case, how = case_of(name), find_method(method)
    case = replace(case, errors=Altered(case.errors, case.reference, change))
    found, _ = measure(case, how, step)
    assert judge(found, case.system, how).verdict == wanted
